"""`saoflow fmt`: shipped sheets are as they should be; comments and meaning stay, as another reader of YAML sees them."""

from __future__ import annotations

import json
import random
import re
from collections import Counter
from pathlib import Path
from typing import Any

import pytest
import yaml

from saoflow import DiagnosisError, cli
from saoflow.authoring.formatting import formatted
from saoflow.diagrams.reader import read_text
from saoflow.diagrams.store import SHIPPED

SHEETS = sorted(SHIPPED.glob("*/*.yaml"))
CORPUS = sorted((Path(__file__).parents[1] / "sheets").glob("**/*.yaml"))

MESSY = """\
# yaml-language-server: $schema=sheet.schema.json
outputs: [y]   # what comes out

# The blocks
blocks:
    # first
    y:   { add : [ u,v, -k ] }     # a sum
    long_one: {mul: [u, v], doc: "a product that has a rather long word about it so that its line becomes far too long to be read with ease"}
        # between
    z:
      lookup : u
      breakpoints: [0,
         1, 2]
      values: [0, # nothing
         1, 4]



sheet: messy
inputs: {u: {doc: one, unit: kt,   shape: []}, v: {unit: kt}}
doc: >-
    Folded text that is much too long for one line, so that the formatter fills it anew, up to the width that it has for all lines of a file
    and goes on.

    Another paragraph.
parameters:
  k: {source: chosen, value: 1.5, unit: kt}
# the end
"""

NEAT = """\
# yaml-language-server: $schema=sheet.schema.json
sheet: messy
doc: >-
  Folded text that is much too long for one line, so that the formatter fills it anew, up to the width that it has for
  all lines of a file and goes on.

  Another paragraph.
parameters:
  k: {value: 1.5, unit: kt, source: chosen}
inputs: {u: {shape: [], unit: kt, doc: one}, v: {unit: kt}}

# The blocks
blocks:
  # first
  y: {add: [u, v, -k]}             # a sum
  long_one:
    mul: [u, v]
    doc: "a product that has a rather long word about it so that its line becomes far too long to be read with ease"
  # between
  z:
    lookup: u
    breakpoints: [0, 1, 2]
    values: [0, # nothing
       1, 4]
outputs: [y]   # what comes out
# the end
"""


def readable(path: Path) -> str | None:
    """The text of a file that the formatter takes."""
    try:
        return readable_text(path.read_text(encoding="utf-8"))
    except UnicodeDecodeError:
        return None


def readable_text(text: str) -> str | None:
    """The text, if a sheet can be read from it; the formatter must take it then."""
    try:
        read_text(text, "sheet.yaml")
    except DiagnosisError:
        return None
    return text


def data(text: str) -> Any:
    """Keys, values and lists as PyYAML reads them, every scalar as text."""
    return yaml.load(text, Loader=yaml.BaseLoader)


@pytest.mark.parametrize("folder", sorted({path.parent.name for path in SHEETS}))
def test_shipped_sheets_are_formatted(folder: str) -> None:
    for path in SHEETS:
        if path.parent.name == folder:
            text = path.read_text(encoding="utf-8")
            assert formatted(text, path.name) == text, f"saoflow fmt {path}"


def test_a_messy_sheet_becomes_neat() -> None:
    assert formatted(MESSY, "messy.yaml") == NEAT
    assert formatted(NEAT, "messy.yaml") == NEAT
    assert data(NEAT) == data(MESSY)
    assert formatted(MESSY.replace("\n", "\r\n"), "messy.yaml") == NEAT


def test_the_order_of_inputs_and_blocks_stays() -> None:
    assert list(data(NEAT)["blocks"]) == ["y", "long_one", "z"] and list(data(NEAT)["inputs"]) == ["u", "v"]


@pytest.mark.parametrize("style", [None, True, False])
def test_other_writers_sheets_are_formatted_without_a_change_of_meaning(style: bool | None) -> None:
    for path in [*SHEETS[::14], *CORPUS[::4]]:
        text = readable(path)
        if text is None:
            continue
        other = yaml.dump(data(text), sort_keys=style is True, default_flow_style=style, width=60 if style else 100, indent=4)
        if readable_text(other) is None:  # sorted keys: a block's first key is no symbol any more
            continue
        once = formatted(other, "sheet.yaml")
        assert data(once) == data(text), path
        assert formatted(once, "sheet.yaml") == once, path


def test_every_comment_stays_once() -> None:
    chance = random.Random(1)
    done = 0
    for path in [*SHEETS[::11], *CORPUS[::3]]:
        text = readable(path)
        if text is None or re.search(r"[|>]-?$|&|\*\w|\x85", text, re.M) or not text.startswith("sheet"):
            continue
        lines = []
        for number, line in enumerate(text.split("\n")):
            if chance.random() < 0.3:
                lines.append(" " * chance.randrange(9) + f"# own {number}")
            lines.append(f"{line}{' ' * chance.randrange(1, 30)}# at {number}" if line and "#" not in line else line)
        commented = "\n".join(lines)
        if readable_text(commented) is None or data(commented) != data(text):
            continue
        once = formatted(commented, "sheet.yaml")
        assert data(once) == data(text), path
        assert Counter(re.findall(r"# (?:own|at) \d+", once)) == Counter(re.findall(r"# (?:own|at) \d+", commented)), path
        assert formatted(once, "sheet.yaml") == once, path
        done += 1
    assert done > 10


def test_whatever_can_be_read_can_be_formatted() -> None:
    taken = 0
    for path in CORPUS[::2]:
        text = readable(path)
        if text is not None:
            once = formatted(text, "sheet.yaml")
            assert formatted(once, "sheet.yaml") == once, path
            taken += 1
    assert taken > 20


def test_campaigns_are_formatted_too() -> None:
    text = "runs:\n  a: {count: 4,flights: calm}\ncampaign: few\nsheets: [cmhe_fte]\n"
    assert formatted(text, "few.yaml") == "campaign: few\nruns:\n  a: {count: 4, flights: calm}\nsheets: [cmhe_fte]\n"


# -- the command


def test_the_command_formats_checks_and_refuses(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("messy.yaml").write_text(MESSY)
    Path("messy.yaml").chmod(0o640)
    Path("neat.yaml").write_text(NEAT)
    assert cli.run(["fmt", "--check", "messy.yaml", "neat.yaml"]) == 1
    assert capsys.readouterr().out == "messy.yaml: would change\n" and Path("messy.yaml").read_text() == MESSY
    assert cli.run(["fmt", "--check", "messy.yaml", "--json"]) == 1
    assert json.loads(capsys.readouterr().out)["files"] == [{"file": "messy.yaml", "changed": True}]
    Path("broken.yaml").write_text("sheet: broken\noutputs: [v[0]]\n")
    assert cli.run(["fmt", "broken.yaml", "messy.yaml"]) == 2
    out, err = capsys.readouterr()
    assert out == "messy.yaml: formatted\n" and "broken.yaml:2:12: error[E102]" in err
    assert Path("messy.yaml").read_text() == NEAT and Path("messy.yaml").stat().st_mode & 0o777 == 0o640
    assert Path("broken.yaml").read_text() == "sheet: broken\noutputs: [v[0]]\n"
    assert cli.run(["fmt", "--check", "messy.yaml", "neat.yaml"]) == 0
    assert cli.run(["fmt", "nowhere.yaml"]) == 2
    assert sorted(p.name for p in tmp_path.iterdir()) == ["broken.yaml", "messy.yaml", "neat.yaml"]


def test_a_file_that_is_read_only_stays(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "messy.yaml"
    path.write_text(MESSY, encoding="utf-8")
    path.chmod(0o444)
    assert cli.run(["fmt", str(path)]) == 2
    assert "error[E601]" in (told := capsys.readouterr().err) and "it is read-only" in told
    assert path.read_text(encoding="utf-8") == MESSY
