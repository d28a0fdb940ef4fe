"""The shortened comparison of bits; the whole one is ``python -m verification.bits``."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import saoflow
from verification.bits.__main__ import compare_flagship, compare_random
from verification.bits.harness import TARGETS, Target, first_difference, run_c, run_interpreter
from verification.bits.native import NATIVE as BACKEND

AVAILABLE = [target for target in TARGETS if target.available]
QUICK = [t for t in AVAILABLE if t.name in ("gcc -O2", "clang -O2", "PowerPC 750", "ARM")]
NATIVE = [t for t in AVAILABLE if t.name in ("gcc -O1", "gcc -O3")]


@pytest.fixture(scope="module", autouse=True)
def _say_what_is_missing() -> None:
    missing = [target.name for target in TARGETS if not target.available]
    if missing:
        print(f"not installed, left out: {', '.join(missing)}")
    if not AVAILABLE:
        pytest.skip("no C compiler is installed")


@pytest.mark.parametrize("target", QUICK, ids=lambda t: t.name)
def test_the_flagship_has_the_interpreters_bits(target: Target) -> None:
    assert len(compare_flagship("cmhe_fte", [target], 600, seed=3)) == 2


def test_backend_c_has_the_interpreters_bits() -> None:
    """One flight at a time, and in lanes, the last of them not full; random sheets are run in every width below."""
    targets = [t for t in BACKEND if t.available and len(t.compiler) == 1]
    first = [t for t in targets if t.compiler == targets[0].compiler]
    chosen = [t for t in first if t.register in (0, 64)]
    assert len(compare_flagship("umhe_fte", chosen, 2310, seed=5, flight=210)) == 4


def test_random_sheets_in_backend_c_have_the_interpreters_bits() -> None:
    available = [t for t in BACKEND if t.available and len(t.compiler) == 1]
    compare_random([t for t in available if t.compiler == available[0].compiler], 4, seed=13)


def test_random_sheets_have_the_interpreters_bits() -> None:
    compare_random(NATIVE[:1], 25, seed=11)


def test_random_sheets_on_other_machines() -> None:
    others = [t for t in QUICK if t.runner]
    if not others:
        pytest.skip("no cross compiler is installed")
    compare_random(others[:1], 6, seed=12)


def test_a_planted_difference_is_found(tmp_path: Path) -> None:
    """The comparison can fail: fused multiplication and addition, and a lost sign of zero, are noticed."""
    text = "sheet: s\ninputs: [a, b, c]\nblocks: {p: {mul: [a, b]}, y: {add: [p, -c]}}\noutputs: [y]\n"
    (tmp_path / "s.yaml").write_text(text, encoding="utf-8")
    sheet = saoflow.load(str(tmp_path / "s.yaml"))
    rows = np.array([[1.0 + 2.0**-30, 1.0 - 2.0**-30, 1.0], [0.0, -1.0, 0.0]])
    expected = run_interpreter(sheet, 64, rows)
    found = run_c(sheet.program(), NATIVE[0], tmp_path / "c", rows)
    assert first_difference(sheet.program(), expected, found) is None
    fused = expected.copy()
    fused[0, 0] = -(2.0**-60)
    difference = first_difference(sheet.program(), fused, found)
    assert difference is not None and (difference.frame, difference.output) == (0, "y")
    unsigned = expected.copy()
    unsigned[1, 0] = 0.0
    assert np.signbit(expected[1, 0])
    assert first_difference(sheet.program(), unsigned, found) is not None
