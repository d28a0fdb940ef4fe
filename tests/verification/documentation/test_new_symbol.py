"""docs/new_symbol.md done as it says, in a copy of the package: file and list, then run, compiled, counted and drawn."""

from __future__ import annotations

import os
import re
import shlex
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import saoflow
from saoflow.codegen.compiler import find_compiler
from verification.demo.readme import blocks

ROOT = Path(__file__).parents[3]
PAGE = (ROOT / "docs" / "new_symbol.md").read_text(encoding="utf-8")
CONSOLE = re.findall(r"^```console\n\$ (saoflow [^\n]*)\n(.*?)^```$", PAGE, re.MULTILINE | re.DOTALL)
DIFFS = re.findall(r"^```diff\n(.*?)\n```$", PAGE, re.MULTILINE | re.DOTALL)

TRIAL = """
import math
import sys
from pathlib import Path

import numpy as np

import saoflow
from saoflow.blocks.library import PROFILES
from saoflow.drawing.page import view_data

assert Path(saoflow.__file__).parents[1] == Path(sys.argv[1]), saoflow.__file__
odd = [0.0, -0.0, 0.5, -0.5, 0.75, -3.0, 5e-324, 1e308, math.inf, -math.inf, math.nan]
stick = np.array(odd)
v = np.random.default_rng(1).normal(0, 2, (len(odd), 3))
sheet = saoflow.load("both.yaml")


def zone(u, width):
    with np.errstate(invalid="ignore"):
        low = np.where(u > -width, u, -width)
        return u - np.where(low < width, low, width)


def bits(array):
    return np.where(np.isnan(array), np.nan, array).tobytes()


backends = ["interpreter"] + sys.argv[2:]
for name in backends:
    out = sheet.simulator(backend=name).run({"stick": stick, "v": v})
    for symbol, composite, expected in (("a", "b", zone(stick, 0.5)), ("c", "d", zone(v, 2.0))):
        assert bits(out[symbol]) == bits(out[composite]) == bits(expected), (name, symbol)
parts = sheet.budget().tree.parts
assert dict(parts["a"].kinds) == {"maximum": 1, "minimum": 1, "subtract": 1}
assert dict(parts["c"].kinds) == {"maximum": 3, "minimum": 3, "subtract": 3}
assert "deadzone" in PROFILES["six"]
data, _ = view_data(sheet, None)
assert "L-7 0H7L" in repr(data["drawings"]), "the glyph is not in the drawing"
print("done by", *backends)
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A copy of the package with the symbol, and the page's sheets."""
    place = tmp_path_factory.mktemp("new_symbol")
    package = place / "saoflow"
    shutil.copytree(Path(saoflow.__file__).parent, package, ignore=shutil.ignore_patterns("__pycache__"))
    for block in blocks(PAGE):
        assert block.kind == "file"
        target = package / "blocks" / block.what if block.what.endswith(".py") else place / block.what
        target.write_text(block.content + "\n", encoding="utf-8")
    library = package / "blocks" / "library.py"
    text = library.read_text(encoding="utf-8")
    for diff in DIFFS:
        before = "\n".join(line[1:] for line in diff.split("\n") if line[:1] != "+")
        after = "\n".join(line[1:] for line in diff.split("\n") if line[:1] != "-")
        assert text.count(before) == 1, f"library.py is no longer as the page shows it: {before}"
        text = text.replace(before, after)
    library.write_text(text, encoding="utf-8")
    return place


def run(folder: Path, *arguments: str) -> str:
    environment = {
        **os.environ,
        "PYTHONPATH": str(folder),
        "XDG_CACHE_HOME": str(folder / "cache"),
        "COLUMNS": "100",
        "PYTHONIOENCODING": "utf-8",
    }
    done = subprocess.run(
        [sys.executable, *arguments], cwd=folder, env=environment, encoding="utf-8", capture_output=True, check=False
    )
    assert "Traceback" not in done.stderr, done.stderr
    return "\n".join(line.rstrip() for line in (done.stdout + done.stderr).strip("\n").split("\n"))


def test_it_runs_in_both_back_ends_and_is_counted_and_drawn(folder: Path) -> None:
    compiled = ["c"] if find_compiler() is not None else []
    (folder / "trial.py").write_text(TRIAL, encoding="utf-8")
    assert run(folder, "trial.py", str(folder), *compiled) == " ".join(["done by interpreter", *compiled])


def test_both_changes_are_there_and_every_answer_is_shown() -> None:
    assert len(DIFFS) == 2
    assert len(CONSOLE) == 3
    assert all(answer.strip() for _, answer in CONSOLE)


@pytest.mark.parametrize(("command", "answer"), CONSOLE, ids=[command for command, _ in CONSOLE])
def test_the_page_shows_what_is_printed(command: str, answer: str, folder: Path) -> None:
    assert run(folder, "-m", "saoflow.cli", *shlex.split(command)[1:]) == answer.rstrip("\n")
