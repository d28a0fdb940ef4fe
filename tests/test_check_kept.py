"""`saoflow check` of what was checked before: the same answer at once, and never about other sheets than those that are there."""

from __future__ import annotations

from pathlib import Path

import pytest

from saoflow.cli import run
from saoflow.pipeline import LoadedSheet

TOP = "sheet: top\nparameters: {n: 2}\ninputs: [x]\nblocks: {y: {part: [x]}, z: {mul: [y, 1/n]}}\noutputs: [z]\n"
PART = "sheet: part\ninputs: [u]\nblocks: {v: {mul: [u, 2]}}\noutputs: [v]\n"


@pytest.fixture
def top(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    (tmp_path / "part.yaml").write_text(PART)
    (tmp_path / "top.yaml").write_text(TOP)
    return str(tmp_path / "top.yaml")


def test_the_same_answer_without_elaborating_again(
    top: str, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    assert run(["check", top, "--json"]) == 0
    first = capsys.readouterr().out
    monkeypatch.setattr(LoadedSheet, "check", None)
    assert run(["check", top, "--json"]) == 0
    assert capsys.readouterr().out == first


def test_a_change_of_a_sub_sheet_a_parameter_or_a_shadowing_sheet_is_seen(
    top: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(["check", top]) == 0
    folder = Path(top).parent
    assert run(["check", top, "--set", "n=0"]) == 2
    (folder / "part.yaml").write_text(PART.replace("[u, 2]", "[w, 2]"))
    assert run(["check", top]) == 2
    assert "unknown wire `w`" in capsys.readouterr().err
    (folder / "part.yaml").write_text(PART)
    (folder / "top.yaml").write_text(TOP.replace("{part: [x]}", "{reciprocal: [x]}"))
    assert run(["check", top]) == 0
    (folder / "reciprocal.yaml").write_text("sheet: reciprocal\ninputs: [a, b]\noutputs: [a]\n")  # now before the library's
    assert run(["check", top]) == 2


def test_what_is_wrong_is_found_each_time(top: str, capsys: pytest.CaptureFixture[str]) -> None:
    Path(top).write_text(TOP.replace("outputs: [z]", "outputs: [q]"))
    told = []
    for _ in range(2):
        assert run(["check", top]) == 2
        told.append(capsys.readouterr().err)
    assert told[0] == told[1] and "E202" in told[0]
