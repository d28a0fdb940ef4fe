"""Frame by frame from the same state: the sheet, with its tables replaced by their functions, against the reference."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from saoflow import Diagnosis, DiagnosisError, LoadedSheet, Simulator
from verification.verifier.case import Array, Compared, Expected, ReferenceCase, Scenario
from verification.verifier.comparison import Worst, relative_difference
from verification.verifier.report import Check, OtherChoice, Place

Progress = Callable[[int], None]
"""Called with a number of frames that have been done since the last call."""


@dataclass(frozen=True)
class Findings:
    """What the frame-by-frame comparison found."""

    checks: tuple[Check, ...]
    other_choices: tuple[OtherChoice, ...]


def probes_of(case: ReferenceCase, sheet: LoadedSheet) -> tuple[str, ...]:
    """The wires that must be probed: all that the case names and that are no outputs. Each once, in order."""
    wires = (*case.state_wires, *(wire for c in case.compared for wire in c.wires), *(c.wire for c in case.choices))
    outputs = {port.name for port in sheet.frame_program.outputs}
    return tuple(dict.fromkeys(wire for wire in wires if wire not in outputs))


def compare_frames(
    sheet: LoadedSheet, case: ReferenceCase, scenarios: tuple[Scenario, ...], progress: Progress
) -> Findings:
    """Run every scenario through the sheet, and the reference in each frame from the sheet's state.

    Raises :class:`saoflow.DiagnosisError` if the sheet lacks a wire that the case names.
    """
    simulator = sheet.simulator(exact=True, probes=probes_of(case, sheet))
    worst = [Worst() for _ in case.compared]
    others: list[OtherChoice] = []
    for scenario in scenarios:
        got, expected = _run(simulator, case, scenario, progress)
        alike, found = _choices(case, scenario, got, expected)
        others += found
        for compared, record in zip(case.compared, worst, strict=True):
            _see(record, case, compared, scenario, got, expected, alike)
            if compared.key in case.initial:
                _see_initial(record, compared, scenario, got, case.initial[compared.key])
    checks = [
        record.check(c.part, c.name, c.wire_name, c.unit, f"{c.tolerance:g} max(|ref|, sigma)", repeat=c.repeat)
        for c, record in zip(case.compared, worst, strict=True)
    ]
    total = sum(len(scenario) for scenario in scenarios)
    return Findings((*checks, *_choice_checks(case, others, total)), tuple(others))


def _run(
    simulator: Simulator, case: ReferenceCase, scenario: Scenario, progress: Progress
) -> tuple[dict[str, Array], list[Expected]]:
    simulator.reset()
    got = simulator.run(scenario.inputs)
    expected = []
    for k in range(len(scenario)):
        state = {wire: got[wire][k] for wire in case.state_wires}
        inputs = {name: column[k] for name, column in scenario.inputs.items()}
        try:
            expected.append(case.expect(state, inputs))
        except Exception as error:
            cause = f"in frame {k} of {scenario.name} it raised {type(error).__name__}: {error}"
            raise _unusable(case, cause, "mend the reference") from error
        if k % 16 == 15:
            progress(16)
    progress(len(scenario) % 16)
    return got, expected


def _choices(
    case: ReferenceCase, scenario: Scenario, got: dict[str, Array], expected: list[Expected]
) -> tuple[Array, list[OtherChoice]]:
    """How many choices in a row fell alike in each frame, shape (frames,), and the frames where one did not."""
    alike = np.full(len(expected), float(len(case.choices)))
    others = []
    for number in reversed(range(len(case.choices))):
        choice = case.choices[number]
        right = np.array([e.choices[choice.name] for e in expected])
        alike[got[choice.wire] != right] = number
    for k in np.flatnonzero(alike < len(case.choices)):
        choice = case.choices[int(alike[k])]
        margin = expected[k].margins[choice.name]
        sheet, right_k = float(got[choice.wire][k]), float(expected[k].choices[choice.name])
        # Written so that a margin of NaN excuses nothing.
        excused = bool(margin <= choice.margin)
        place = Place(scenario.name, int(k), scenario.first_frame + int(k), (), sheet, right_k)
        others.append(OtherChoice(choice.name, place, margin, excused))
    return alike, others


def _see(
    record: Worst,
    case: ReferenceCase,
    compared: Compared,
    scenario: Scenario,
    got: dict[str, Array],
    expected: list[Expected],
    alike: Array,
) -> None:
    shift = int(compared.following)
    rows = np.flatnonzero(alike >= compared.after)
    rows = rows[rows + shift < len(expected)]
    if not len(rows):
        return
    right = np.array([expected[k].values[compared.key] for k in rows], dtype=np.float64)
    found = compared.of_sheet(got)[rows + shift]
    if found.shape != right.shape:
        shapes = f"has shape {list(found.shape[1:])}, the reference gives {list(right.shape[1:])}"
        cause = f"for {compared.name} the wire {compared.wire_name} {shapes}"
        raise _unusable(case, cause, "compare a wire of the same shape")
    ratio = relative_difference(found, right, compared.sigma) / compared.tolerance
    record.see(scenario, rows.astype(float), found, right, ratio)


def _see_initial(record: Worst, compared: Compared, scenario: Scenario, got: dict[str, Array], initial: Array) -> None:
    found, right = compared.of_sheet(got)[:1], np.asarray(initial, dtype=np.float64)[None]
    ratio = relative_difference(found, right, compared.sigma) / compared.tolerance
    record.see(scenario, np.array([-1.0]), found, right, ratio)


def _unusable(case: ReferenceCase, cause: str, remedy: str) -> DiagnosisError:
    message = f"the reference of `{case.sheet}` cannot be used"
    return DiagnosisError([Diagnosis("E604", message, cause=cause, remedy=remedy)])


def _choice_checks(case: ReferenceCase, others: list[OtherChoice], frames: int) -> list[Check]:
    """One check for all choices together: none unexcused, and few enough."""
    if not case.choices:
        return []
    unexcused = [other for other in others if not other.excused]
    share = max(choice.share for choice in case.choices)
    margin = max(choice.margin for choice in case.choices)
    worst = (unexcused or others)[:1]
    passed = not unexcused and len(others) <= max(1.0, share * frames)
    return [
        Check(
            part="choices",
            quantity="frames with another choice",
            wire=f"{case.choices[0].wire} ...",
            unit="frames",
            largest=float(len(others)),
            ratio=float("inf") if unexcused else len(others) / max(1.0, share * frames),
            tolerance=f"margin {margin:g}, {share:g} of the frames",
            frames=frames,
            where=worst[0].where if worst else None,
            passed=passed,
        )
    ]
