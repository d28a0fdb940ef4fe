"""``saoflow run --report``: the page of a run, refused early where it could not be written."""

from __future__ import annotations

import json
import os
import re
from pathlib import Path

import numpy as np
import pytest

from saoflow import cli
from saoflow.commands import run as run_command
from saoflow.recordings import write_table

LAG = str(Path(__file__).parent / "sheets" / "good" / "first_order_lag.yaml")


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    write_table("in.csv", {"t": 5.0 + np.arange(40) * 0.048, "u": np.sin(np.arange(40.0))})
    return tmp_path


def test_the_page_shows_outputs_and_probes_over_the_recordings_time(
    here: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    arguments = ["run", LAG, "in.csv", "-o", "out.csv", "--probe", "step", "--report", "page.html"]
    assert cli.run(arguments) == 0
    assert capsys.readouterr().out.rstrip().endswith("3 columns in out.csv; page.html")
    page = Path("page.html").read_text()
    assert "first_order_lag: 40 frames" in page
    pictures = [re.findall(r">([^<]*)</text>", svg) for svg in page.split("<svg")[1:]]
    assert len(pictures) == 3 and pictures[0][-2:] == ["y", "first_order_lag"] and "step" in pictures[1]
    for picture in pictures[:2]:
        assert picture[: picture.index("time [s]")] == [f"{5 + k / 4:.2f}" for k in range(8)]
    assert sorted(os.listdir()) == ["in.csv", "out.csv", "page.html"]


@pytest.mark.parametrize(
    "rows",
    ["nan,nan\n", "3,1\n", "0,1e308\n1,1e308\n2,-1e308\n", "2,1\n1,2\n0,3\n", "1,inf\n1,-inf\n", ",\n,\n"],
    ids=["nothing", "one frame", "huge", "backwards", "infinite", "empty"],
)
def test_odd_runs_have_a_page_too(here: Path, recwarn: pytest.WarningsRecorder, rows: str) -> None:
    Path("odd.csv").write_text("t,u\n" + rows)
    assert cli.run(["run", LAG, "odd.csv", "-o", "out.csv", "--report", "page.html"]) == 0
    assert Path("page.html").read_text().count("<svg") == 2
    assert not [str(w.message) for w in recwarn]


def test_a_long_run_shows_its_beginning_and_says_so(
    here: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(run_command, "REPORT_FRAMES", 15)
    assert cli.run(["run", LAG, "in.csv", "-o", "out.csv", "--report", "page.html", "--json"]) == 0
    answer = json.loads(capsys.readouterr().out)
    assert answer["report"] == "page.html" and answer["frames"] == 40
    assert [d["code"] for d in answer["diagnoses"]] == ["W502"]
    assert "first_order_lag: 15 frames" in Path("page.html").read_text()
    assert len(Path("out.csv").read_text().splitlines()) == 41


def test_a_page_that_cannot_be_written_is_refused_before_the_run(
    here: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for name, words in (
        ("none/page.html", "there is no folder `none`"),
        ("out.csv", "it is the recording that is written"),
        ("in.csv", "it is the recording that is read"),
        (".", "it is a folder"),
    ):
        assert cli.run(["run", LAG, "in.csv", "-o", "out.csv", "--report", name]) == 2
        told = capsys.readouterr().err
        assert "error[E601]" in told and words in told
    assert os.listdir() == ["in.csv"]
