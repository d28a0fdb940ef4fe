"""Whatever text it gets, the reader answers with a sheet or with clean diagnoses, in bounded time."""

from __future__ import annotations

import random
import time
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from saoflow.diagnosis import DiagnosisError
from saoflow.diagrams.reader import read_text
from saoflow.diagrams.sheet import Sheet

SHEETS = Path(__file__).parent.parent / "sheets"
PIECES = (
    *"{}[]:,\n\t|>-?'\"#%@\\~^()\r!&*",
    ": ", "- ", "\n  ", "&a ", "*a", "!!x ", "null", "1e999", "é", "\u2028", "\ud800", "\x00", "\x85", "\x1b",
    "x" * 70, "---\n", "...\n", "<<: ", "..", "  ", "\ufeff", "{a: ", "a: &a [*a]",
)  # fmt: skip


def judge(text: str) -> Sheet | None:
    """Read, and check that every diagnosis is complete."""
    try:
        return read_text(text, "f.yaml")
    except DiagnosisError as error:
        assert error.diagnoses
        for d in error.diagnoses:
            assert d.position is not None
            assert d.position.line >= 1
            assert d.position.column >= 1
            assert d.position.length >= 1
            assert d.cause, d
            assert d.remedy, d
            assert "\n" not in d.message + d.cause + d.remedy
        assert "Traceback" not in str(error)
        return None


def corpus() -> list[str]:
    paths = sorted(SHEETS.glob("*/*.yaml"))
    texts = [p.read_bytes().decode("utf-8", "ignore") for p in paths]
    return [t for t in texts if len(t) < 4000]


def mutated(text: str, rng: random.Random) -> str:
    for _ in range(rng.choice([1, 1, 1, 2, 5, 20])):
        at, other, kind = rng.randrange(len(text) + 1), rng.randrange(len(text) + 1), rng.random()
        if kind < 0.4:
            text = text[:at] + rng.choice(PIECES) + text[at:]
        elif kind < 0.6:
            text = text[:at] + text[at + rng.randrange(1, 6) :]
        elif kind < 0.8 and 0 < other - at < 60:
            text = text[:at] + text[other:]
        else:
            text = text[:at] + text[other : other + rng.randrange(40)] + text[at:]
    return text


def test_mutated_sheets() -> None:
    rng, texts = random.Random(20261122), corpus()
    assert len(texts) > 30
    outcomes = [judge(mutated(rng.choice(texts), rng)) for _ in range(4000)]
    assert sum(sheet is None for sheet in outcomes) > 1000


def test_mutated_good_sheet() -> None:
    good = (Path(__file__).parent / "grammar.yaml").read_text(encoding="utf-8")
    rng = random.Random(7)
    outcomes = [judge(mutated(good, rng)) for _ in range(1500)]
    assert sum(sheet is not None for sheet in outcomes) > 20


@given(st.text(max_size=200))
@settings(max_examples=300, deadline=None)
def test_any_text(text: str) -> None:
    judge(text)


HEAD = "sheet: a\noutputs: [u]\n"


@pytest.mark.parametrize(
    "text",
    [
        "[" * 500_000,
        "{a: " * 200_000,
        "- " * 200_000,
        "? " * 100_000,
        "\n".join(" " * i + "a:" for i in range(1000)),
        HEAD + "parameters: {a: " + "-" * 9000 + "}\n",
        HEAD + "parameters: {a: " + "1" * 2_000_000 + "}\n",
        HEAD + "parameters: {a: " + "b" * 2_000_000 + "}\n",
        HEAD + "inputs: {" + ", ".join(f"u{i}: {{shap: 1}}" for i in range(5000)) + "}\n",
        HEAD + "inputs:\n" + "  u: {}\n" * 10_000,
        HEAD + "parameters:\n  a: >\n" + "    1 + a\n" * 1000,
        HEAD + "parameters:\n  a0: &a0 1\n" + "".join(f"  a{i}: &a{i} [*a{i - 1}]\n" for i in range(1, 3000)),
        HEAD
        + "parameters:\n  a0: &a0 [1, 1]\n"
        + "".join(f"  a{i}: &a{i} [*a{i - 1}, *a{i - 1}]\n" for i in range(1, 60)),
        HEAD + 'parameters: {a: "1 + ' + "\\e" * 9000 + '"}\n',
        HEAD + 'parameters: {a: "1 + ' + "\\e" * 1_000_000 + '"}\n',
        HEAD + "parameters:\n  a: >\n" + "    1 +\n" * 1200 + "    $\n",
        HEAD + " " * 1_000_000,
        HEAD + "doc: '" + "''" * 500_000 + "'\n",
    ],
    ids=range(18),
)
def test_hostile_text_takes_no_time(text: str) -> None:
    start = time.process_time()
    judge(text)
    assert time.process_time() - start < 5
