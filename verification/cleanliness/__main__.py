"""``python -m verification.cleanliness``: is the generated C clean? ``--quick`` for the shortened check.

The flagship and its variants, the library and random sheets, in binary64 and binary32, under gcc and clang with every
warning an error, under sanitizers and valgrind, under cppcheck's MISRA addon; what their object files need and hold; their
stack. One line a check; tools that are missing are named and their checks left out. Exits 1 at any finding.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from os import cpu_count
from pathlib import Path

import saoflow
from verification.cleanliness.checks import CHECKS, Check, Found
from verification.cleanliness.misra import ACCEPTED, Misra, read_accepted
from verification.cleanliness.subjects import ESTIMATORS, Subject, estimators, library, random_sheets
from verification.cleanliness.tools import where


@dataclass(frozen=True, slots=True)
class Extent:
    """How much is looked at."""

    names: tuple[str, ...]
    widths: tuple[int, ...]
    every: int
    """Each so-many-th sheet of the library."""
    random: int
    frames: int
    small_frames: int
    seed: int


def gather(extent: Extent, folder: Path) -> list[Subject]:
    """Generate all the C, and name what is left out."""
    names = tuple(name for name in extent.names if _exists(name))
    subjects = list(estimators(folder, names, extent.widths, extent.frames))
    found, alone = library(folder / "library", extent.widths, extent.small_frames, extent.every)
    if alone:
        print(f"left out, they do not stand alone: {', '.join(alone)}")
    return [*subjects, *found, *random_sheets(folder / "random", extent.random, extent.seed, extent.small_frames)]


def _exists(name: str) -> bool:
    try:
        saoflow.load(name)
    except saoflow.DiagnosisError as problem:
        if all(d.code == "E602" for d in problem.diagnoses):
            print(f"left out, there is no such sheet: {name}")
            return False
        raise
    return True


def look_at(check: Check, group: str, subjects: Sequence[Subject]) -> bool:
    """Run one check on the sheets of a group, and print its line. Returns whether all are clean."""
    with ThreadPoolExecutor(cpu_count()) as pool:
        all_found = list(pool.map(check.look, subjects))
    many = f"{len(subjects)} files" if len(subjects) > 2 else " and ".join(str(s.real) for s in subjects) + " bits"
    bad = [(s, found) for s, found in zip(subjects, all_found, strict=True) if found.findings]
    note = _note(all_found)
    verdict = f"{len(bad)} NOT CLEAN" if bad else "clean"
    print(f"{group}: {check.name}: {verdict} ({many}{', ' + note if note else ''})", flush=True)
    for s, found in bad:
        for text in found.findings:
            print(f"    {s}: {text}")
    return not bad


def _note(all_found: Sequence[Found]) -> str:
    """The notes of few files; of many, the one with the largest number."""
    if len(all_found) <= 2:
        return "; ".join(dict.fromkeys(found.note for found in all_found if found.note))
    most = max(all_found, key=lambda found: found.measure)
    return f"most: {most.note}" if most.note else ""


def available(checks: Sequence[Check]) -> list[Check]:
    """The checks whose tools are here; the others are named."""
    for check in checks:
        if missing := [tool for tool in check.tools if where(tool) is None]:
            print(f"not installed: {', '.join(missing)}; left out: {check.name}")
    return [check for check in checks if all(map(where, check.tools))]


def examine(extent: Extent, quick: bool) -> bool:
    """Everything. Returns whether all is clean."""
    misra = Misra(read_accepted())
    checks = available([*CHECKS, Check("MISRA, cppcheck", ("cppcheck",), misra.look)])
    print(
        "Division by zero is meant: the reciprocal of zero is infinity in every back end, so that float-divide-by-zero"
    )
    print("is not among the sanitizers (as in gcc and clang, where `undefined` leaves it out).")
    clean = True
    with tempfile.TemporaryDirectory() as folder:
        subjects = gather(extent, Path(folder))
        for group in dict.fromkeys(s.group for s in subjects):
            members = [s for s in subjects if s.group == group]
            for check in checks:
                clean = look_at(check, group, members) and clean
    if not quick and where("cppcheck"):
        for entry in misra.unneeded():
            print(f"{ACCEPTED.name}:{entry.line}: {entry.rule} no longer occurs: remove the entry")
    print("clean" if clean else "NOT CLEAN")
    return clean


def main(arguments: Sequence[str] | None = None) -> int:
    """Run what is asked for; 0 when all is clean."""
    parser = argparse.ArgumentParser(prog="python -m verification.cleanliness", description=__doc__)
    parser.add_argument("--quick", action="store_true", help="umhe_fte in binary64 and a few small sheets")
    parser.add_argument("--random", type=int, default=None, help="random sheets (40; quick: 4)")
    parser.add_argument(
        "--frames", type=int, default=None, help="frames of the estimators under sanitizers (2000; quick: 200)"
    )
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args(arguments)
    quick = options.quick
    extent = Extent(
        names=("umhe_fte",) if quick else ESTIMATORS,
        widths=(64,) if quick else (64, 32),
        every=8 if quick else 1,
        random=options.random if options.random is not None else (4 if quick else 40),
        frames=options.frames or (200 if quick else 2000),
        small_frames=50 if quick else 200,
        seed=options.seed,
    )
    return 0 if examine(extent, quick) else 1


if __name__ == "__main__":
    sys.exit(main())
