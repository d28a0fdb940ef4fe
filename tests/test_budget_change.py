"""`saoflow budget A --vs B` and `--vs-git REV`."""

from __future__ import annotations

import json
import subprocess
from pathlib import Path

import pytest

from saoflow.cli import run

OLD = """\
sheet: s
inputs: [x, y]
blocks:
  a: {add: [x, y]}
  b: {mul: [a, a, 3]}
  c: {half: [b]}
outputs: [c]
budget: {operations: 5}
"""
NEW = OLD.replace("b: {mul: [a, a, 3]}", "b: {mul: [a, a, 3]}\n  d: {mul: [x, 0.1]}\n  e: {add: [b, d]}").replace("[b]", "[e]")
HALF = "sheet: half\ninputs: [u]\nblocks:\n  h: {mul: [u, 0.5]}\noutputs: [h]\n"


@pytest.fixture
def repository(tmp_path: Path) -> Path:
    folder = tmp_path / "sheets"
    folder.mkdir()
    (folder / "s.yaml").write_text(OLD)
    (folder / "half.yaml").write_text(HALF)

    def git(*arguments: str) -> None:
        subprocess.run(["git", "-C", str(tmp_path), "-c", "user.name=a", "-c", "user.email=a@b", *arguments], check=True)

    git("init", "-q", "-b", "main")
    git("add", ".")
    git("commit", "-q", "-m", "first")
    (folder / "s.yaml").write_text(NEW)
    (folder / "half.yaml").write_text(HALF.replace("0.5]}", "0.5]}\n  g: {add: [h, 1]}").replace("outputs: [h]", "outputs: [g]"))
    return folder


def test_what_changed_since_a_revision_with_the_sheets_beside_it(
    repository: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    sheet = str(repository / "s.yaml")
    assert run(["budget", sheet, "--vs-git", "main", "--json"]) == 1  # 7 operations of 5
    answer = json.loads(capsys.readouterr().out)
    assert (answer["operations_before"], answer["operations"], answer["over"]) == (4, 7, True)
    assert [(p["path"], p["before"], p["after"]) for p in answer["parts"]] == [
        ("d", 0, 1),
        ("e", 0, 1),
        ("c", 1, 2),
        ("c.g", 0, 1),
    ]
    assert run(["budget", sheet, "--vs-git", "main"]) == 1
    told = capsys.readouterr()
    assert "7 operations a frame of 5, OVER BUDGET; +3 operations as against main" in told.out and "E401" in told.err


def test_against_a_file_as_markdown(repository: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (repository / "old.yaml").write_text(OLD.replace("sheet: s", "sheet: old"))
    assert run(["budget", str(repository / "old.yaml"), "--vs", str(repository / "old.yaml")]) == 0
    assert "the same operations" in capsys.readouterr().out
    assert run(["budget", str(repository / "old.yaml"), "--vs", str(repository / "s.yaml"), "--markdown"]) == 0
    told = capsys.readouterr().out
    assert "| operations | 7 | 5 | −2 |" in told and "| d | 1 | 0 | gone |" in told


@pytest.mark.parametrize(
    ("option", "says"),
    [
        (["--vs-git", "nowhere"], "there is no revision `nowhere`"),
        (["--vs-git", "--output=x"], "is no revision"),
        (["--vs", "nothing.yaml"], "nothing.yaml"),
        (["--vs", "umhe_fte", "--vs-git", "main"], "exclude each other"),
    ],
)
def test_what_cannot_be_compared(
    repository: Path, option: list[str], says: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(["budget", str(repository / "half.yaml"), *option]) == 2
    assert says in capsys.readouterr().err


def test_a_sheet_outside_any_repository(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "half.yaml").write_text(HALF)
    assert run(["budget", str(tmp_path / "half.yaml"), "--vs-git", "main"]) == 2
    assert "E612" in capsys.readouterr().err
