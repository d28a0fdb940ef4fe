"""Valid sheets, mutated at random in their text and in their tree: `check` answers, or gives diagnoses, and nothing else.

What `check` accepts is also counted and run for two frames, where it is small.
"""

from __future__ import annotations

import copy
import random
import re
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

from saoflow import DiagnosisError
from saoflow.blocks.library import SYMBOLS
from saoflow.diagrams.expression_value import Quantity
from saoflow.diagrams.reader import read_text
from saoflow.diagrams.store import SHIPPED, SheetStore
from saoflow.pipeline import LoadedSheet

GOOD = Path(__file__).parent / "sheets" / "good"
SOURCES = [*sorted(GOOD.glob("**/*.yaml")), *sorted(SHIPPED.glob("*/*.yaml"))]
SMALL = 4000
"""Characters of a sheet that is mutated: larger ones would only be slower."""
MUTANTS = 2100
SECONDS = 40.0
"""A mutant that takes long is a finding too: far more than all of them need."""

ODD = [
    "", "0", "-1", "1e9", "1e400", "nan", "inf", "1.5", "true", "no", "~", "x", "u", "y", "pi", "[]", "{}", "[[1, 2], [3]]",
    "[a, b]", "-", "1/0", "2^2^2^2^9", "sqrt(-1)", "zeros(10^6, 10^6)", "u[", "u[0]", "u.T", "u[9:]", "diag(u)", "a.b.c",
    "stages[0].y", "\u00e9", "\x00", "*a", "&a 1", "!!python/object:os.system", "'", '"', "#", "? :", "- -", "|", ">", "%",
    "kt", "m/s^2", "rad^0.5", "six", "sao", "inherited", "matrix", "hold", "9" * 400,
]  # fmt: skip
WORDS = [
    "sheet", "doc", "profile", "parameters", "inputs", "blocks", "outputs", "budget", "shape", "unit", "type", "boolean",
    "value", "fold", "map", "count", "carry", "each", "in", "order", "reverse", "initial", "frames", "add", "mul", "lookup",
    "inv2", "delay", "saturation", "constant", "select", "concatenate", "transpose", "diagonal", "compare", "and", "or",
    "not", "switch", "reciprocal", "window_rms", "index", "breakpoints", "values", "function", "range", "error",
]  # fmt: skip

Mutation = Callable[[random.Random, str], str]


# -- in the text


def _character(rng: random.Random, text: str) -> str:
    i = rng.randrange(len(text))
    return text[:i] + rng.choice(["", *"[]{}:,-'\"#&*!|>%@` \t\n0aé\x07", text[i] * 3]) + text[i + 1 :]


def _line(rng: random.Random, text: str) -> str:
    lines = text.split("\n")
    i, j = rng.randrange(len(lines)), rng.randrange(len(lines))
    what = rng.randrange(5)
    if what == 0:
        del lines[i]
    elif what == 1:
        lines.insert(j, lines[i])
    elif what == 2:
        lines[i], lines[j] = lines[j], lines[i]
    elif what == 3:
        lines[i] = "  " * rng.randrange(4) + lines[i].lstrip()
    else:
        lines[i] = lines[i][: rng.randrange(len(lines[i]) + 1)]
    return "\n".join(lines)


def _word(rng: random.Random, text: str) -> str:
    words = list(re.finditer(r"[\w.]+", text))
    word = rng.choice(words)
    others = [rng.choice(words).group(), rng.choice(ODD), rng.choice(WORDS), word.group()[:-1], word.group() + "x"]
    return text[: word.start()] + rng.choice(others) + text[word.end() :]


def _end(rng: random.Random, text: str) -> str:
    return text[: rng.randrange(len(text))]


# -- in the tree


def _names(tree: Any) -> list[str]:
    """What operands of the sheet can name."""
    found = ["pi", "index", "nowhere"]
    for key in ("inputs", "blocks", "parameters"):
        part = tree.get(key)
        found += [str(name) for name in part] if isinstance(part, (dict, list)) else []
    return found


def _operand(rng: random.Random, names: list[str]) -> str:
    name = rng.choice(names)
    forms = ["{}", "{}", "{}", "-{}", "{}.T", "{}[0]", "{}[-1]", "{}[1:]", "{}[0, 1]", "diag({})", "[{}, 1]", "[[{0}, {0}]]",
             "{}.y", "2*{}", "{}[0].y", "{}.y[0]", "[{0}, -{0}]", "sqrt({})"]  # fmt: skip
    return rng.choice(forms).format(name)


def _meaning(rng: random.Random, text: str) -> str:
    """Other wires, symbols, shapes and units in a sheet that stays readable."""
    tree = yaml.safe_load(text)
    names = _names(tree)
    for _ in range(rng.choice([1, 1, 2, 3])):
        blocks = tree.get("blocks") if isinstance(tree.get("blocks"), dict) else {}
        block = blocks.get(rng.choice(list(blocks))) if blocks else None
        inputs = tree.get("inputs") if isinstance(tree.get("inputs"), dict) else {}
        port = inputs.get(rng.choice(list(inputs))) if inputs else None
        what = rng.randrange(8)
        if what <= 2 and isinstance(block, dict) and block:
            key = rng.choice(list(block))
            value = block[key]
            if isinstance(value, list) and value:
                value[rng.randrange(len(value))] = _operand(rng, names)
            elif isinstance(value, dict) and value:
                value[rng.choice(list(value))] = _operand(rng, names)
            else:
                block[key] = _operand(rng, names)
        elif what == 3 and isinstance(block, dict) and block:
            first, *rest = block.items()
            items = [(rng.choice([*SYMBOLS, "reciprocal", "divide", "dot", "last"]), first[1]), *rest]
            block.clear()
            block.update(items)
        elif what == 4 and isinstance(port, dict):
            port["shape"] = rng.choice([[], [1], [2], [3, 2], [2, 2, 2], 4, "n", [0], [1.5], [-1], [10**6, 10**6]])
        elif what == 5 and isinstance(port, dict):
            port["unit"] = rng.choice(
                ["kt", "m/s", "rad", 1, ["rad", "kt"], [["m", "s"], ["kt", "K"]], "kt^-1", "1/s^0.5"]
            )
        elif what == 6 and isinstance(port, dict):
            port["type"] = rng.choice(["boolean", "real", "integer"])
        elif isinstance(block, dict):
            key = rng.choice(
                [*(p.name for s in SYMBOLS.values() for p in s.parameters), "count", "order", "each", "carry"]
            )
            block[key] = rng.choice(
                [0, 1, 2, 1.5, -1, [1, 2], [2, 1], "true", "x", "sin", "1/x", "matrix", "sqrt(x)", 1e-3, []]
            )
    return yaml.safe_dump(tree, sort_keys=False, allow_unicode=True)


def _places(tree: Any) -> list[tuple[Any, Any]]:
    """Every container with one of its keys or indices."""
    found, stack = [], [tree]
    while stack:
        here = stack.pop()
        keys = list(here) if isinstance(here, dict) else list(range(len(here))) if isinstance(here, list) else []
        found += [(here, key) for key in keys]
        stack += [here[key] for key in keys]
    return found


def _tree(rng: random.Random, text: str) -> str:
    tree = yaml.safe_load(text)
    for _ in range(rng.choice([1, 1, 1, 2, 4])):
        places = _places(tree)
        if not places:
            break
        container, key = rng.choice(places)
        what = rng.randrange(6)
        if what == 0:
            del container[key]
        elif what == 1:
            container[key] = rng.choice(ODD)
        elif what == 2:
            container[key] = copy.deepcopy(rng.choice([c[k] for c, k in places]))
        elif what == 3 and isinstance(container, dict):
            items = [(rng.choice([*WORDS, *ODD]) if k == key else k, v) for k, v in container.items()]
            container.clear()
            container.update(items)
        elif what == 4 and isinstance(container, dict):
            items = list(container.items())
            rng.shuffle(items)
            container.clear()
            container.update(items)
        elif isinstance(container, list):
            container.insert(key, copy.deepcopy(container[key]))
        else:
            container[key] = rng.choice([[], {}, None, 0, -3, 1e300, [container[key]], {"a": container[key]}, 10**30])
    return yaml.safe_dump(tree, sort_keys=False, allow_unicode=True)


MUTATIONS: list[Mutation] = [
    _character,
    _line,
    _word,
    _word,
    _end,
    _tree,
    _tree,
    _meaning,
    _meaning,
    _meaning,
    _meaning,
]


def mutant(seed: int) -> tuple[Path, str]:
    """A valid sheet with one to three mutations."""
    rng = random.Random(seed)
    path = rng.choice([p for p in SOURCES if p.stat().st_size < SMALL])
    text = path.read_text(encoding="utf-8")
    for _ in range(rng.choice([1, 1, 1, 2])):
        try:
            text = rng.choice(MUTATIONS)(rng, text) or " "
        except (yaml.YAMLError, ValueError, IndexError, TypeError, AttributeError):
            break  # the text of a mutant need not be YAML any more
    return path, text


def check(store: SheetStore, path: Path, text: str) -> LoadedSheet | None:
    """The sheet if it is good; every diagnosis must be printable, with its cause and remedy."""
    try:
        sheet = read_text(text, str(path))
        store.sources.add(sheet.file, sheet.lines)
        # Sheets of the library leave numbers to the sheets that use them: here 3.
        open_ones = [p.name.text for p in sheet.parameters if p.value is None]
        loaded = LoadedSheet(sheet, store, {name: Quantity(np.array(3.0), None) for name in open_ones})
        loaded.check()
    except DiagnosisError as error:
        assert error.diagnoses
        for diagnosis in error.diagnoses:
            assert diagnosis.render() and diagnosis.to_dict()
            assert diagnosis.cause and diagnosis.remedy, diagnosis
            assert diagnosis.position is not None, diagnosis
            assert diagnosis.position.line >= 1 and diagnosis.position.column >= 1, diagnosis
        return None
    return loaded


def run(loaded: LoadedSheet) -> None:
    """Count the sheet and run two frames of zeros."""
    try:
        if loaded.budget().total > 20_000:
            return
        inputs = {name: np.zeros((2, *wire.shape)) for name, wire in loaded.input_types.items()}
        loaded.simulator().run(inputs or {"frames": np.zeros(2)})
    except DiagnosisError as error:
        assert all(d.code.startswith(("E4", "E5")) for d in error.diagnoses), error


@pytest.mark.parametrize("part", range(8))
def test_mutants_get_clean_diagnoses(part: int) -> None:
    store, good = SheetStore(), 0
    start = time.process_time()
    for seed in range(part, MUTANTS, 8):
        path, text = mutant(seed)
        try:
            loaded = check(store, path, text)
            if loaded is not None:
                good += 1
                if good % 4 == 0:
                    run(loaded)
        except Exception as error:
            raise AssertionError(f"seed {seed}, from {path.name}: {type(error).__name__}: {error}\n{text}") from error
        assert time.process_time() - start < SECONDS, f"seed {seed} of {path.name} takes long:\n{text}"
    assert good < MUTANTS // 8 / 2, "most mutations should break something"
