"""``python -m verification.bits``: the whole comparison of bits; ``--quick`` for the shortened one.

Random sheets drawn by hypothesis, and the flagship and its variants over many frames of flights with noise, faults, missing
samples and odd numbers; binary64 and binary32; every compiler and emulated machine that is installed. Exits 1 at the first
difference, with the sheet shrunk.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from pathlib import Path

import numpy as np
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st

import saoflow
from verification.bits.flights import flagship_rows
from verification.bits.harness import TARGETS, Target, first_difference, run_c, run_interpreter
from verification.bits.random_sheets import ROWS, SIDE_SHEETS, sheets

FLAGSHIPS = ("cmhe_fte", "umhe_fte", "cmhe_fte_lean")


def compare_random(targets: list[Target], examples: int, seed: int) -> None:
    """Random sheets on each target; raises AssertionError with the smallest sheet found that differs."""

    @settings(
        max_examples=examples,
        deadline=None,
        database=None,
        suppress_health_check=list(HealthCheck),
        phases=(Phase.generate, Phase.shrink),
        derandomize=False,
    )
    @given(sheets(), ROWS, st.sampled_from([64, 32]))
    def compare(text: str, rows: list[list[float]], real: int) -> None:
        compare_text(text, np.array(rows), real, targets)

    from hypothesis import seed as seeded

    seeded(seed)(compare)()


def compare_text(text: str, rows: np.ndarray, real: int, targets: list[Target]) -> None:
    """One sheet from text on each target. Raises AssertionError."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for side, content in SIDE_SHEETS.items():
            (folder / f"{side}.yaml").write_text(content, encoding="utf-8")
        (folder / "s.yaml").write_text(text, encoding="utf-8")
        sheet = saoflow.load(str(folder / "s.yaml"))
        expected = run_interpreter(sheet, real, rows)
        program = sheet.program(real)
        for target in targets:
            found = run_c(program, target, folder / target.name.replace(" ", "_"), rows)
            difference = first_difference(program, expected, found)
            assert difference is None, f"{target.name}, {real} bits: {difference}\n{text}"


def compare_flagship(name: str, targets: list[Target], frames: int, seed: int) -> list[str]:
    """A shipped sheet over many frames; returns a line for each target and width. Raises AssertionError."""
    sheet = saoflow.load(name)
    rows = flagship_rows(frames, seed)
    lines = []
    for real in (64, 32):
        expected = run_interpreter(sheet, real, rows if real == 64 else rows[: max(frames // 20, 200)])
        program = sheet.program(real)
        for target in targets:
            with tempfile.TemporaryDirectory() as folder:
                found = run_c(program, target, Path(folder), rows[: len(expected)])
            difference = first_difference(program, expected, found)
            assert difference is None, f"{name}, {target.name}, {real} bits: {difference}"
            lines.append(f"{name}, {target.name}, {real} bits: {len(expected)} frames, every bit equal")
    return lines


def main() -> int:
    """Run what is asked for."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--quick", action="store_true", help="the shortened comparison")
    parser.add_argument("--sheets", type=int, default=None, help="random sheets (500; quick: 20)")
    parser.add_argument("--frames", type=int, default=None, help="flagship frames in binary64 (1 000 000; quick: 2000)")
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    targets = [t for t in TARGETS if t.available]
    for target in TARGETS:
        if not target.available:
            print(f"not installed, left out: {target.name} ({target.compiler[0]} {' '.join(target.runner[:1])})")
    frames = options.frames or (2_000 if options.quick else 1_000_000)
    examples = options.sheets or (20 if options.quick else 500)
    try:
        for name in FLAGSHIPS:
            for line in compare_flagship(name, targets, frames, options.seed):
                print(line, flush=True)
        compare_random(targets, examples, options.seed)
        print(f"{examples} random sheets, {len(targets)} targets, binary64 and binary32: every bit equal")
    except AssertionError as problem:
        print(problem, file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
