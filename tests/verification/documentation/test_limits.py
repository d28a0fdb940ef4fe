"""docs/limits.md: its bounds are those of the code, all of them, and what it names exists."""

from __future__ import annotations

import ast
import importlib
import re
from pathlib import Path

import pytest

import saoflow
from saoflow.codes import CODES
from saoflow.diagnosis import DiagnosisError

ROOT = Path(__file__).parents[3]
PAGE = (ROOT / "docs" / "limits.md").read_text(encoding="utf-8")
ROWS = re.findall(r"^\| (\d+) \| (.+) \| `([\w.]+)` \| (\w+) \|$", PAGE, re.MULTILINE)
BOUND = re.compile(r"^(MOST|LARGEST|LONGEST|DEEPEST|SLOWEST|NESTED)(_|$)")
FOLDERS = ("diagrams", "blocks", "scheduler", "tables", "recordings", "codegen")
"""From a sheet to frames; bounds of what is printed or shown elsewhere refuse nothing."""
INNER = {
    "saoflow.codegen.guide.MOST_BUCKETS": "memory of a guide into a table",
    "saoflow.codegen.inlining.LARGEST": "what is placed in its callers; the results are the same",
    "saoflow.codegen.inlining.MOST": "as above",
    "saoflow.codegen.names.LONGEST": "longer names are shortened, and stay unique",
    "saoflow.diagrams.content_key.LARGEST": "larger sheets are looked at anew every time",
    "saoflow.diagrams.content_key.MOST_SHEETS": "as above, in folders of more",
    "saoflow.codegen.self_check.MOST_LITERALS": "fewer frames in a self-check",
    "saoflow.recordings.table.MOST_SHOWN": "mistakes shown one by one; the others are counted",
    "saoflow.scheduler.python_printer.DEEPEST": "how a statement is split",
}
"""Bounds that refuse nothing: what is shown, kept or laid out."""


@pytest.mark.parametrize(("number", "what", "place", "code"), ROWS, ids=[row[2] for row in ROWS])
def test_a_bound_is_that_of_the_code(number: str, what: str, place: str, code: str) -> None:
    module, _, name = place.rpartition(".")
    assert getattr(importlib.import_module(module), name) == int(number), what
    assert code in CODES


def block(text: str, more: str = "") -> str:
    return f"sheet: s\ninputs: {{x: {{}}}}\n{more}blocks: {{y: {text}}}\noutputs: [y]\n"


BEYOND = {
    "saoflow.diagrams.yaml_text.DEEPEST": block("{mul: [x, " + "[" * 64 + "1" + "]" * 64 + "]}"),
    "saoflow.diagrams.expression_parser.LONGEST": block(f"{{mul: [x, '1{'+1' * 5000}']}}"),
    "saoflow.diagrams.expression_parser.DEEPEST": block(f"{{mul: [x, '1{'+1' * 100}']}}"),
    "saoflow.diagrams.expression_parser.NESTED": block(f"{{mul: [x, '{'(' * 50}1{')' * 50}']}}"),
    "saoflow.diagrams.expression_parser.LONGEST_NAME": f"sheet: s\ninputs: [x, {'x' * 65}]\noutputs: [x]\n",
    "saoflow.diagrams.parameter_arithmetic.LARGEST": block("{mul: [x, k]}", "parameters: {k: 'max(zeros(1001, 1000))'}\n"),
    "saoflow.wires.MOST_ELEMENTS": "sheet: s\ninputs: {x: {shape: [1000, 1001]}}\noutputs: [x]\n",
    "saoflow.diagrams.structure.MOST_INSTANCES": block("{fold: running_sum, count: 100001, carry: {sum: 0}, in: {x: x}}"),
    "saoflow.blocks.delay.LONGEST": block("{delay: x, frames: 10001}"),
    "saoflow.diagrams.rates.SLOWEST": block("{reciprocal: x, every: 1001, transition: hold}"),
    "saoflow.scheduler.schedule.LONGEST": block(
        "{reciprocal: x, every: 997, transition: hold}, z: {reciprocal: x, every: 101, transition: hold}"
    ),
    "saoflow.tables.tabulate.MOST_POINTS": block("{lookup: x, function: sin, range: [0, 1000], error: 1e-9}"),
}
"""Sheets one beyond a bound."""


@pytest.mark.parametrize("place", BEYOND)
def test_beyond_a_bound_the_diagnosis_is_the_one_named(place: str, tmp_path: Path) -> None:
    path = tmp_path / "s.yaml"
    path.write_text(BEYOND[place], encoding="utf-8")
    with pytest.raises(DiagnosisError) as refused:
        saoflow.load(str(path)).check()
    (code,) = (code for _, _, where, code in ROWS if where == place)
    assert {d.code for d in refused.value.diagnoses} == {code}


def test_every_bound_that_refuses_is_in_the_page() -> None:
    found = set()
    for path in [ROOT / "saoflow" / "wires.py", *(p for name in FOLDERS for p in (ROOT / "saoflow" / name).glob("*.py"))]:
        module = ".".join(path.relative_to(ROOT).with_suffix("").parts)
        for node in ast.parse(path.read_text(encoding="utf-8")).body:
            targets = node.targets if isinstance(node, ast.Assign) else []
            found |= {f"{module}.{t.id}" for t in targets if isinstance(t, ast.Name) and BOUND.match(t.id)}
    shown = {place for _, _, place, _ in ROWS}
    assert found - shown - set(INNER) == set(), "a new bound: into docs/limits.md, or among those that refuse nothing"
    assert set(INNER) <= found, "gone"
