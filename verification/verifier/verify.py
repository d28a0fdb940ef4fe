"""A sheet against its reference: the whole verification in one place."""

from __future__ import annotations

import time
from collections.abc import Callable

from saoflow import Diagnosis, DiagnosisError, LoadedSheet, load
from saoflow.tables.tabulate import TableError, error_budget
from verification.verifier.case import Reference, ReferenceCase
from verification.verifier.closed_loop import compare_closed_loop
from verification.verifier.find import find_reference
from verification.verifier.frame_by_frame import compare_frames
from verification.verifier.report import OtherDecision, Report
from verification.verifier.whole_run import compare_runs, random_scenarios

FRAMES = 10_000
"""How many frames are compared unless something else is asked for."""

Progress = Callable[[str, float], None]
"""Called with what is being done and the share of the whole that is done, 0 to 1."""


def verify(
    sheet: LoadedSheet | str,
    reference: Reference | str | None = None,
    *,
    frames: int = FRAMES,
    seed: int = 1,
    progress: Progress | None = None,
) -> Report:
    """Compare a sheet with its reference over ``frames`` frames, drawn by ``seed``.

    ``reference`` is one, or ``module:name``, or None for the one that is installed under the sheet's name.

    Raises :class:`saoflow.DiagnosisError`: E604 no reference, E603 frames or seed, and whatever the sheet itself has.
    """
    started = time.perf_counter()
    _check_numbers(frames, seed)
    loaded = load(sheet) if isinstance(sheet, str) else sheet
    if reference is None or isinstance(reference, str):
        reference, found_at = find_reference(loaded.name, reference)
    else:
        found_at = "given"
    if isinstance(reference, ReferenceCase):
        report = _verify_case(loaded, reference, frames, seed, found_at, progress)
    else:
        report = _verify_function(loaded, reference, frames, seed, found_at, progress)
    return report(time.perf_counter() - started)


def _verify_case(
    sheet: LoadedSheet, case: ReferenceCase, frames: int, seed: int, found_at: str, progress: Progress | None
) -> Callable[[float], Report]:
    scenarios = tuple(case.scenarios(frames, seed))
    total = sum(map(len, scenarios))
    closed = case.closed_loop
    share = 0.6 if closed else 1.0
    by_frame = compare_frames(sheet, case, scenarios, _meter(progress, "frame by frame", 0.0, share, total))
    checks = by_frame.checks
    decisions: tuple[OtherDecision, ...] = ()
    if closed is not None:
        meter = _meter(progress, "closed loop", share, 1.0, total)
        more, decisions = compare_closed_loop(sheet, closed, scenarios, meter)
        checks = (*checks, *more)
    names = tuple(scenario.name for scenario in scenarios)
    return lambda seconds: Report(
        sheet.name,
        found_at,
        total,
        seed,
        names,
        checks,
        by_frame.other_choices,
        decisions,
        table_errors(sheet),
        seconds,
    )


def _verify_function(
    sheet: LoadedSheet, reference: Reference, frames: int, seed: int, found_at: str, progress: Progress | None
) -> Callable[[float], Report]:
    assert not isinstance(reference, ReferenceCase)
    make = reference.scenarios
    scenarios = tuple(make(frames, seed)) if make else random_scenarios(sheet, frames, seed)
    total = sum(map(len, scenarios))
    checks = compare_runs(sheet, reference, scenarios, _meter(progress, "runs", 0.0, 1.0, total))
    names = tuple(scenario.name for scenario in scenarios)
    return lambda seconds: Report(
        sheet.name, found_at, total, seed, names, checks, (), (), table_errors(sheet), seconds
    )


def table_errors(sheet: LoadedSheet) -> tuple[TableError, ...]:
    """The error budget of every table of the sheet that approximates a function; each once, largest first."""
    found = {id(table): error_budget(table) for table in sheet.frame_program.tables if table.function is not None}
    return tuple(sorted(found.values(), key=lambda error: (-error.points, error.name)))


def _meter(progress: Progress | None, what: str, start: float, end: float, frames: int) -> Callable[[int], None]:
    done = 0

    def advance(more: int) -> None:
        nonlocal done
        done += more
        if progress is not None:
            progress(what, start + (end - start) * done / max(1, frames))

    return advance


def _check_numbers(frames: int, seed: int) -> None:
    problems = []
    if not 1 <= frames <= 1_000_000:
        problems.append(_number("--frames", frames, "a verification compares 1 to 1000000 frames", "--frames 10000"))
    if not 0 <= seed < 2**63:
        problems.append(_number("--seed", seed, "seeds are whole numbers from 0", "--seed 1"))
    if problems:
        raise DiagnosisError(problems)


def _number(option: str, value: int, cause: str, example: str) -> Diagnosis:
    return Diagnosis("E603", f"{option} cannot be {value}", cause=cause, remedy=f"for example {example}")
