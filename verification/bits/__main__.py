"""``python -m verification.bits``: the whole comparison of bits; ``--quick`` for the shortened one.

Random sheets drawn by hypothesis, and the flagship and its variants over many frames of flights with noise, faults, missing
samples and odd numbers; binary64 and binary32; every compiler and emulated machine that is installed, and the code of backend
``c`` for this machine, one flight at a time and in lanes. Exits 1 at the first difference, with the sheet shrunk.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st

import saoflow
from saoflow.scheduler.program import FrameProgram
from verification.bits.flights import flagship_rows
from verification.bits.harness import TARGETS, Target, first_difference, run_c, run_interpreter
from verification.bits.native import NATIVE, NativeTarget, run_native
from verification.bits.random_sheets import ROWS, SIDE_SHEETS, sheets

FLAGSHIPS = ("cmhe_fte", "umhe_fte", "ekf_fte", "cmhe_fte_lean")
FLIGHT = 500
"""Frames of a flight."""
FLIGHTS = 5
"""Flights of a random sheet."""
BLOCK = 200_000
"""Frames that are compared at a time, so that memory stays flat."""


def compare_random(targets: Sequence[Target | NativeTarget], examples: int, seed: int) -> None:
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


def compare_text(text: str, rows: np.ndarray, real: int, targets: Sequence[Target | NativeTarget]) -> None:
    """One sheet from text on each target. Raises AssertionError."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for side, content in SIDE_SHEETS.items():
            (folder / f"{side}.yaml").write_text(content, encoding="utf-8")
        (folder / "s.yaml").write_text(text, encoding="utf-8")
        sheet = saoflow.load(str(folder / "s.yaml"))
        # The same frames as several flights, begun at different ones: lanes that differ, and the last ones not full.
        flights = np.concatenate([np.roll(rows, k, axis=0) for k in range(FLIGHTS)])
        expected = run_interpreter(sheet, real, flights, len(rows))
        program = sheet.program(real)
        for target in targets:
            found = _run(program, target, folder / target.name.replace(" ", "_"), flights, len(rows))
            difference = first_difference(program, expected, found)
            assert difference is None, f"{target.name}, {real} bits: {difference}\n{text}"


def _run(
    program: FrameProgram, target: Target | NativeTarget, folder: Path, rows: np.ndarray, flight: int
) -> np.ndarray:
    if isinstance(target, NativeTarget):
        return run_native(program, target, folder, rows, flight)
    return run_c(program, target, folder, rows, flight)


def compare_flagship(
    name: str, targets: Sequence[Target | NativeTarget], frames: int, seed: int, flight: int = FLIGHT
) -> list[str]:
    """A shipped sheet over many frames; returns a line for each target and width. Raises AssertionError.

    The frames are flights of ``flight`` frames, each from the start, which the interpreter runs as a batch; so the
    start-up is met as often as there are flights.
    """
    sheet = saoflow.load(name)
    flight = min(flight, frames)
    frames -= frames % flight
    lines = []
    for real in (64, 32):
        program = sheet.program(real)
        for start in range(0, frames, BLOCK):
            rows = flagship_rows(min(BLOCK, frames - start), seed + start)
            expected = run_interpreter(sheet, real, rows, flight)
            for target in targets:
                with tempfile.TemporaryDirectory() as folder:
                    found = _run(program, target, Path(folder), rows, flight)
                difference = first_difference(program, expected, found)
                assert difference is None, f"{name}, {target.name}, {real} bits: {difference}"
        lines += [f"{name}, {target.name}, {real} bits: {frames} frames, every bit equal" for target in targets]
    return lines


def main() -> int:
    """Run what is asked for."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--quick", action="store_true", help="the shortened comparison")
    parser.add_argument("--sheets", type=int, default=None, help="random sheets (500; quick: 20; 0: none)")
    parser.add_argument("--frames", type=int, default=None, help="frames of each flagship (1 000 000; quick: 2000)")
    parser.add_argument("--flagship", nargs="*", default=FLAGSHIPS, help="which shipped sheets")
    parser.add_argument("--target", nargs="*", default=None, help="which targets, by a part of their names")
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    every: tuple[Target | NativeTarget, ...] = (*TARGETS, *NATIVE)
    wanted = [t for t in every if options.target is None or any(w in t.name for w in options.target)]
    targets = [t for t in wanted if t.available]
    for target in wanted:
        if not target.available:
            tools = (*target.compiler[:1], *(() if isinstance(target, NativeTarget) else target.runner[:1]))
            print(f"not installed, left out: {target.name} ({' '.join(tools)})")
    frames = options.frames or (2_000 if options.quick else 1_000_000)
    examples = options.sheets if options.sheets is not None else (20 if options.quick else 500)
    try:
        for name in options.flagship:
            for line in compare_flagship(name, targets, frames, options.seed):
                print(line, flush=True)
        if examples:
            compare_random(targets, examples, options.seed)
            print(f"{examples} random sheets, {len(targets)} targets, binary64 and binary32: every bit equal")
    except AssertionError as problem:
        print(problem, file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
