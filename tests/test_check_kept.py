"""`saoflow check` of what was checked before: the same answer at once, and never about other sheets than those that are there."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from saoflow.cli import run
from saoflow.commands import kept_check
from saoflow.diagrams import content_key
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
    assert run(["check", top]) == 0
    assert capsys.readouterr().out == "top: 2 blocks, 1 sub-sheet, 0 errors\n"


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


def keys(top: str, *settings: str) -> str:
    content_key.code_fingerprint.cache_clear()
    found = kept_check.verdict_key(top, settings)
    assert found
    return found


def test_whatever_a_verdict_depends_on_changes_its_key(top: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Sheets, options, where one stands, saoflow's code and sheets, Python, what is installed: each alone."""
    first = keys(top)
    assert keys(top) == first
    found = {first, keys(top, "n=2"), keys(top, "n=3"), keys(str(tmp_path / "part.yaml"))}
    (tmp_path / "part.yaml").write_text(PART + "# a comment\n")
    found.add(keys(top))
    (tmp_path / "new.yaml").write_text(PART)
    found.add(keys(top))
    monkeypatch.setattr("sys.version", "4.0")
    found.add(keys(top))
    (tmp_path / "site" / "numpy-9.0.dist-info").mkdir(parents=True)
    monkeypatch.syspath_prepend(str(tmp_path / "site"))
    found.add(keys(top))
    package = tmp_path / "saoflow"
    for file in ("diagrams/library/mean.yaml", "code.py"):
        (package / file).parent.mkdir(parents=True, exist_ok=True)
        (package / file).write_text("x")
    monkeypatch.setattr(content_key, "SHIPPED", package / "diagrams")
    found.add(keys(top))
    (package / "diagrams" / "library" / "mean.yaml").write_text("y")
    found.add(keys(top))
    (package / "code.py").write_text("x = 1")
    found.add(keys(top))
    monkeypatch.chdir(tmp_path)
    found.add(keys(top))
    assert len(found) == 12


def test_a_sheet_that_a_link_leads_to_uses_those_beside_it(top: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Under the working folder a linked sheet is where it lies, so a third folder's sheets count, too."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "other").mkdir()
    (tmp_path / "other" / "part.yaml").write_text(PART.replace("mul: [u, 2]", "inner: u"))
    (tmp_path / "other" / "inner.yaml").write_text(PART.replace("sheet: part", "sheet: inner"))
    (tmp_path / "part.yaml").unlink()
    (tmp_path / "part.yaml").symlink_to("other/part.yaml")
    assert run(["check", top]) == 0
    (tmp_path / "other" / "inner.yaml").write_text(PART.replace("sheet: part", "sheet: inner").replace("[u, 2]", "[w, 2]"))
    assert run(["check", top]) == 2


def test_a_sheet_that_changes_while_it_is_checked_is_checked_again(
    top: str, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    check = LoadedSheet.check

    def slow(sheet: LoadedSheet) -> None:
        check(sheet)
        Path(top).write_text(TOP.replace("outputs: [z]", "outputs: [q]"))

    monkeypatch.setattr(LoadedSheet, "check", slow)
    assert run(["check", top]) == 0
    monkeypatch.setattr(LoadedSheet, "check", check)
    assert run(["check", top]) == 2
    assert "E202" in capsys.readouterr().err


def test_what_is_no_plain_file_is_not_waited_for(top: str, tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe.yaml")
    assert run(["check", top]) == 0
    assert run(["check", str(tmp_path / "pipe.yaml")]) == 2


@pytest.mark.parametrize(
    "words", [["--help"], ["--jsno"], [], ["--set", "n"], ["--set=n=3"], ["--", "top.yaml"], [""], ["a\0b"], ["--set"]]
)
def test_only_a_plain_command_line_is_answered_without_its_parser(top: str, words: list[str]) -> None:
    assert run(["check", top]) == 0
    assert kept_check.answer([top]) == 0
    assert kept_check.answer([*words, top] if words else []) is None
