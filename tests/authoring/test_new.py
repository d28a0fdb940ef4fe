"""`saoflow new`: what it writes checks clean, runs, and computes what it says; nothing is overwritten."""

from __future__ import annotations

import shlex
from pathlib import Path

import numpy as np
import pytest

from saoflow import cli, load
from saoflow.authoring.first import NEXT, TEMPLATES, write_first
from saoflow.authoring.formatting import formatted
from saoflow.recordings import read_frames, read_table


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.parametrize("kind", ["sheet", "estimator"])
def test_the_next_commands_work_as_they_are_printed(here: Path, kind: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.run(["new", "mine", "--kind", kind, "-o", "my sheets"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0] == "written: my sheets/mine.yaml, my sheets/mine.csv" and lines[1] == "next:"
    assert len(lines) == 2 + len(NEXT[kind])
    for line in lines[2:]:
        words = shlex.split(line)
        assert words[0] == "saoflow" and cli.run(words[1:]) == 0, (line, capsys.readouterr().err)
    assert "0 errors" in capsys.readouterr().out


@pytest.mark.parametrize("kind", list(NEXT))
def test_what_is_written_is_formatted(kind: str) -> None:
    text = (TEMPLATES / f"{kind}.yaml").read_text(encoding="utf-8")
    assert formatted(text, f"{kind}.yaml") == text and text.count("NAME") == 1


def test_the_sheet_is_a_lag_of_the_mean(here: Path) -> None:
    write_first("mine", here, "sheet")
    sheet = load("mine.yaml")
    frames = read_frames("mine.csv", sheet.input_types)
    expected, value = [], 250.0
    for sample in frames.inputs["vc"].mean(axis=1):
        value += 0.25 * (sample - value)
        expected.append(value)
    np.testing.assert_allclose(sheet.simulator().run(frames.inputs)["smooth"], expected, rtol=1e-13)


def test_the_estimator_is_a_kalman_filter_and_finds_the_truth(here: Path) -> None:
    write_first("mine", here, "estimator")
    sheet = load("mine.yaml")
    frames = read_frames("mine.csv", sheet.input_types)
    out = sheet.simulator().run(frames.inputs)
    F, G = np.array([[1, 0.1], [0, 1]]), np.array([0.005, 0.1])
    H, Q, R = np.array([[1.0, 0.0]]), np.diag([1e-4, 1e-2]), np.array([[4.0]])
    x, P = np.array([1000.0, 0.0]), np.diag([100.0, 25.0])
    for k, (h, a) in enumerate(zip(frames.inputs["h"], frames.inputs["a"], strict=True)):
        x, P = F @ x + G * a, F @ P @ F.T + Q
        K = P @ H.T @ np.linalg.inv(H @ P @ H.T + R)
        x, P = x + K @ (h - H @ x), (np.eye(2) - K @ H) @ P
        np.testing.assert_allclose([out["h_hat"][k], out["climb_hat"][k]], x, rtol=1e-9, atol=1e-9)
    truth = read_table("mine.csv", ["h", "h_true", "climb_true"])
    settled = slice(100, None)
    error = out["h_hat"] - truth["h_true"]
    assert np.std(error[settled]) < 0.5 * np.std((truth["h"] - truth["h_true"])[settled])
    assert np.abs(out["climb_hat"] - truth["climb_true"])[settled].max() < 1.0


def test_the_campaign_can_be_read_and_its_sheets_fly(here: Path) -> None:
    from verification.campaigns.check import check_campaign
    from verification.campaigns.reader import read_campaign

    assert write_first("mine", ".", "campaign").files == ("mine.yaml",)
    campaign = read_campaign("mine.yaml")
    assert campaign.name == "mine" and sum(runs.count for runs in campaign.runs) == 8
    assert [d.code for d in check_campaign(campaign)] in ([], ["W607"])


def test_nothing_is_overwritten_and_nothing_half_written(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    Path("mine.csv").write_text("years of work")
    assert cli.run(["new", "mine"]) == 2
    assert "mine.csv cannot be written" in capsys.readouterr().err
    assert [p.name for p in here.iterdir()] == ["mine.csv"] and Path("mine.csv").read_text() == "years of work"
    Path("file").write_text("")
    assert cli.run(["new", "mine", "-o", "file/below"]) == 2
    assert "error[E601]" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["my-sheet"], "remedy: write `my_sheet`"),
        (["../up"], "error[E112]"),
        (["mine", "--kind", "shet"], "did you mean `sheet`?"),
    ],
)
def test_bad_names_and_kinds_are_refused(
    here: Path, capsys: pytest.CaptureFixture[str], arguments: list[str], words: str
) -> None:
    assert cli.run(["new", *arguments]) == 2
    assert words in capsys.readouterr().err and not list(here.iterdir())
