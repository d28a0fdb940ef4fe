"""Files that cannot be read at all, and files near the bounds."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from saoflow.diagnosis import DiagnosisError
from saoflow.diagrams import reader
from saoflow.diagrams.reader import read_sheet, read_text

GOOD = "sheet: a\ninputs: [u]\noutputs: [u]\n"


def said_of(path: str | Path) -> str:
    with pytest.raises(DiagnosisError) as caught:
        read_sheet(path)
    return str(caught.value)


def test_no_such_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    assert said_of("none.yaml") == (
        "none.yaml:1:1: error[E101]: the file cannot be read\n"
        "    = cause: it does not exist\n"
        "    = remedy: correct the path"
    )


def test_directory(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "d.yaml").mkdir()
    assert said_of("d.yaml") == (
        "d.yaml:1:1: error[E101]: the file cannot be read\n"
        "    = cause: it is a directory\n"
        "    = remedy: name a YAML file in it"
    )


def test_pipe_is_not_waited_for(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "p.yaml")
    assert "it is not a regular file" in said_of(tmp_path / "p.yaml")


@pytest.mark.skipif(os.geteuid() == 0, reason="root may read everything")
def test_no_permission(tmp_path: Path) -> None:
    path = tmp_path / "a.yaml"
    path.write_text(GOOD)
    path.chmod(0)
    assert "permission denied" in said_of(path)


def test_permission_is_told_whoever_runs_the_test(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "a.yaml"
    path.write_text(GOOD)

    def refuse(*_: object, **__: object) -> None:
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr("builtins.open", refuse)
    with pytest.raises(DiagnosisError) as caught:
        read_sheet(path)
    monkeypatch.undo()
    assert "E101" in str(caught.value)
    assert "permission denied" in str(caught.value)


@pytest.mark.parametrize("name", ["a\0b.yaml", "a" * 5000 + ".yaml", "loop.yaml", ""])
def test_impossible_paths(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "loop.yaml").symlink_to(tmp_path / "loop.yaml")
    assert "error[E101]: the file cannot be read" in said_of(name)


def test_too_large(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(reader, "LARGEST_FILE", 2**20)
    path = tmp_path / "a.yaml"
    path.write_text(GOOD + "#" * (2**20 - len(GOOD)))
    assert read_sheet(path).name.text == "a"
    path.write_text(GOOD + "#" * (2**20 + 1 - len(GOOD)))
    monkeypatch.chdir(tmp_path)
    assert said_of("a.yaml") == (
        "a.yaml:1:1: error[E110]: the file is too large\n"
        "    = cause: it has more than 1 MB\n"
        "    = remedy: split it into several sheets, or use `fold` and `map`"
    )


def test_byte_order_mark(tmp_path: Path) -> None:
    path = tmp_path / "a.yaml"
    path.write_bytes(b"\xef\xbb\xbf" + GOOD.encode())
    assert read_sheet(path).name.position.column == 8
    assert read_text("\ufeff" + GOOD, "a.yaml").name.position.column == 8


def test_place_of_a_wrong_byte(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "a.yaml").write_bytes(b"\xef\xbb\xbfsheet: a\ndoc: \xc3\xa9\xc3\xa9 \xff\n")
    assert said_of("a.yaml").startswith("a.yaml:2:9: error[E104]: the file is not text in UTF-8")


def test_what_would_act_on_a_terminal_is_not_printed() -> None:
    for text in (
        'sheet: "a\\e[31m"\noutputs: [u]\n',
        "sheet: \x1b[31m\n",
        'sheet: a\noutputs: ["\\e"]\n',
        "sheet: \ud800",
    ):
        with pytest.raises(DiagnosisError) as caught:
            read_text(text, "a.yaml")
        shown = str(caught.value).replace("\n", "")
        assert shown.isprintable(), shown
        shown.encode()
