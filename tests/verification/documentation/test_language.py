"""docs/language.md names every key that the reader knows, every function, every unit and every bound."""

from __future__ import annotations

import ast
import re
from pathlib import Path

import pytest

from saoflow.blocks import delay
from saoflow.diagrams import expression_parser, parameter_arithmetic, rates, reader, structure, yaml_text
from saoflow.formula import FUNCTIONS, NAMED
from saoflow.scheduler import schedule
from saoflow.tables import tabulate
from saoflow.unit_names import KNOWN
from saoflow.wires import MOST_ELEMENTS

ROOT = Path(__file__).parents[3]
PAGE = (ROOT / "docs" / "language.md").read_text(encoding="utf-8")
MODULES = ("reader", "reader_blocks", "reader_ports")


def texts(node: ast.AST) -> set[str]:
    return {n.value for n in ast.walk(node) if isinstance(n, ast.Constant) and isinstance(n.value, str)}


def keys_of(module: str) -> set[str]:
    """The texts that a module of the reader compares keys with: in ``match key.value``, ``key.value == ...``, ``in (...)``,
    ``"key" in found``, and the tables and dictionaries of keys that it looks them up in."""
    found: set[str] = set()
    for node in ast.walk(ast.parse((ROOT / "saoflow" / "diagrams" / f"{module}.py").read_text(encoding="utf-8"))):
        if isinstance(node, ast.Match) and ast.unparse(node.subject).endswith(".value"):
            found |= {text for case in node.cases for text in texts(case.pattern)}
        elif isinstance(node, ast.Compare):
            compared = [node.left, *node.comparators]
            if any(re.search(r"\.(value|keys)\b|^found$", ast.unparse(part)) for part in compared):
                found |= set().union(*(texts(part) for part in compared))
        elif isinstance(node, ast.Assign | ast.AnnAssign) and node.value is not None:
            name = ast.unparse(node.targets[0] if isinstance(node, ast.Assign) else node.target)
            if isinstance(node.value, ast.Tuple) and re.search(r"_KEYS$|_KINDS$|_RATE$", name):
                found |= texts(node.value)
            elif isinstance(node.value, ast.Dict) and name in ("parts", "texts"):
                found |= {text for key in node.value.keys if key is not None for text in texts(key)}
    return {key for key in found if key.isidentifier()}


def test_the_keys_are_found() -> None:
    """The walk over the reader's source sees keys of every kind; else the test below would hold nothing."""
    found = set().union(*map(keys_of, MODULES))
    assert {"sheet", "parameters_of", "multiply", "period", "shape", "from", "inherited", "source", "offset", "held"} <= found
    assert {"fold", "map", "count", "order", "carry", "each", "in", "every", "auto"} <= found


@pytest.mark.parametrize("module", MODULES)
def test_every_key_is_in_the_page(module: str) -> None:
    assert [key for key in sorted(keys_of(module)) if f"`{key}`" not in PAGE] == []


def section(title: str) -> str:
    start = PAGE.index(f"\n## {title}\n") + 1
    end = PAGE.find("\n## ", start)
    return PAGE[start : end if end > 0 else None]


def test_every_function_and_constant_is_in_the_page() -> None:
    words = set(re.findall(r"\w+", " ".join(re.findall(r"`([^`\n]+(?:\n[^`\n]+)?)`", section("Expressions")))))
    known = {*parameter_arithmetic.FUNCTIONS, *parameter_arithmetic.CONSTANTS, *FUNCTIONS, *NAMED}
    assert known - words == set()


def test_every_unit_is_in_the_page_and_nothing_else_is() -> None:
    shown = [word for line in section("Units").splitlines() if line.startswith("    ") for word in line.split()]
    assert sorted(shown) == sorted(KNOWN)


def test_the_limits_are_those_of_the_code() -> None:
    rows = re.findall(r"^\| (\d+)( MB)? \| (.*) \|$", section("Limits"), re.MULTILINE)
    shown = {what.split(";")[0]: int(number) for number, _, what in rows}
    assert shown == {
        "a file": reader.LARGEST_FILE // 2**20,
        "levels of YAML inside each other": yaml_text.DEEPEST,
        "nodes that aliases stand for": yaml_text.MOST_ALIASED,
        "characters of an expression": expression_parser.LONGEST,
        "brackets of an expression inside each other": expression_parser.NESTED,
        "characters of a name": expression_parser.LONGEST_NAME,
        "elements of a wire or a parameter": MOST_ELEMENTS,
        "instances of a fold or map": structure.MOST_INSTANCES,
        "blocks of a sheet, all sub-sheets laid out": structure.MOST_NODES,
        "frames of a `delay`": delay.LONGEST,
        "points of a computed table": tabulate.MOST_POINTS,
        "`every`": rates.SLOWEST,
    }
    assert parameter_arithmetic.LARGEST == MOST_ELEMENTS
    assert f"{expression_parser.DEEPEST} operators in a chain" in section("Limits")
    assert f"{schedule.LONGEST} frames until the pattern" in section("Limits")
