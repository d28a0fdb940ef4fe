"""The README: its first sheet runs, its numbers are what the commands print, and what it names exists."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from saoflow import cli
from verification.demo.equations import reading_order
from verification.demo.readme import Block, blocks, output, renewed

ROOT = Path(__file__).parents[3]
README = (ROOT / "README.md").read_text(encoding="utf-8")
BLOCKS = list(blocks(README))
SLOW = "python -m verification.results"
"""Renewed by the same commands, but too slow to run here; ``tests/verification/results`` holds what they claim."""


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    place = tmp_path_factory.mktemp("readme")
    for block in BLOCKS:
        if block.kind == "file":
            (place / block.what).write_text(block.content + "\n", encoding="utf-8")
    return place


QUICK = [block for block in BLOCKS if block.kind == "numbers" and not block.what.startswith(SLOW)]


@pytest.mark.parametrize("block", QUICK, ids=lambda block: block.what)
def test_blocks_are_what_the_commands_print(block: Block, folder: Path) -> None:
    assert output(block.what, folder) == block.content, "renew it: python -m verification.demo.readme"


def test_the_first_sheet_by_hand(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    value, expected = 240.0, []
    for _ in range(4):
        value = (250 + 251 + 256) * 0.25 / 3 + value * 0.75
        expected.append(value)
    shown = next(block for block in BLOCKS if block.what == "python first.py").content
    assert [float(number) for number in shown.strip("[]").split()] == pytest.approx(expected, abs=1e-8)
    (folder / "readings.csv").write_text("vc_1,vc_2,vc_3\n" + "250,251,256\n" * 4)
    assert (
        cli.run(["run", str(folder / "airspeed.yaml"), str(folder / "readings.csv"), "-o", str(folder / "o.csv")]) == 0
    )
    rows = (folder / "o.csv").read_text().split()
    assert rows[0] == "smooth"
    assert [float(row) for row in rows[1:]] == pytest.approx(expected, abs=1e-12)


def test_no_block_is_empty() -> None:
    assert [block.what for block in BLOCKS if not block.content.strip("|\n ")] == []


def test_what_is_named_exists() -> None:
    named = set(re.findall(r"`((?:docs|tests|verification|saoflow|benchmarks)/[\w./-]*)", README))
    named |= set(re.findall(r"\]\(([^)h]+)\)", README))
    assert named
    assert [name for name in named if not (ROOT / name).exists()] == []
    for path, test in re.findall(r"`(tests/[\w./]+\.py)::(\w+)`", README):
        assert f"def {test}(" in (ROOT / path).read_text(), f"{path}::{test}"


def test_commands_exist(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.run(["--help"]) == 0
    known = capsys.readouterr().out
    for name in set(re.findall(r"saoflow ([a-z]+)\b", "\n".join(re.findall(r"`[^`\n]+`", README)))):
        assert f"\n  {name} " in known, name


def test_every_sheet_of_the_flagship_is_in_the_table() -> None:
    users = ("cmhe_fte", "umhe_fte", "ekf_fte", "step3_half_rate")  # the last: docs/multirate.md
    names = {sheet.name.text for user in users for sheet in reading_order(user)}
    assert names == {path.stem for path in (ROOT / "saoflow" / "diagrams" / "cmhe_fte").glob("*.yaml")}


def test_renewing_replaces_what_is_marked_and_nothing_else(tmp_path: Path) -> None:
    text = "a\n<!-- file: x.py -->\n```\nprint(6 * 7)\n```\n<!-- numbers: python x.py -->\n```\nold\n```\n"
    table = "<!-- numbers: python -c 'print(1); print(2)' | head -1 -->\n|old|\n|old|\n\nend\n"
    measured = "<!-- measured: python x.py -->\n```\nold\n```\n"
    assert renewed(text + table + measured) == (
        text.replace("old", "42") + table.replace("|old|\n|old|", "1") + measured
    )
    assert renewed(measured.replace("python x.py", "python -c 'print(3)'"), ("measured",)).count("3\n") == 1
    with pytest.raises(RuntimeError, match="exit code 1"):
        renewed("<!-- numbers: python -c 'import nothing' -->\n|\n")
    with pytest.raises(ValueError, match="line 1"):
        list(blocks("<!-- numbers: x -->\n```\nno end"))
