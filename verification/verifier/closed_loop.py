"""The closed loop with tables against the reference, each from its own state."""

from __future__ import annotations

import numpy as np

from saoflow import LoadedSheet
from verification.verifier.case import Array, ClosedLoop, Decision, Scenario, Values
from verification.verifier.comparison import Worst
from verification.verifier.frame_by_frame import Progress
from verification.verifier.report import Check, OtherDecision


def compare_closed_loop(
    sheet: LoadedSheet, case: ClosedLoop, scenarios: tuple[Scenario, ...], progress: Progress
) -> tuple[tuple[Check, ...], tuple[OtherDecision, ...]]:
    """Run sheet and reference over every scenario.

    In fault-free scenarios the outputs have to stay close; in all, the decisions have to be the same in every frame.
    Where one falls otherwise because its measure is within the table error of its threshold, that is reported and
    the scenario is compared up to that frame only: the two runs go on with different sensors.
    """
    simulator = sheet.simulator()
    worst = [Worst() for _ in case.close]
    decided = [Worst() for _ in case.decisions]
    others: list[OtherDecision] = []
    for scenario in scenarios:
        simulator.reset()
        got, right = simulator.run(scenario.inputs), case.run(scenario.inputs)
        first, found = _first_other_decision(case, scenario, got, right)
        others += found
        frames = np.arange(float(first))
        for decision, record in zip(case.decisions, decided, strict=True):
            _see_decision(record, decision, scenario, got, right, found, first)
        if scenario.fault_free:
            for close, record in zip(case.close, worst, strict=True):
                a = got[close.output][:first] * close.scale
                b = right[close.output][:first] * close.scale
                with np.errstate(all="ignore"):
                    ratio = np.nan_to_num(np.abs(a - b), nan=np.inf) / (close.limit or 1.0)
                record.see(scenario, frames, a, b, ratio)
        progress(len(scenario))
    checks = [
        record.check(
            "closed loop with tables",
            decision.output,
            decision.output,
            "",
            f"equal, but within {decision.table_error:g} {decision.unit} of {decision.threshold:g}",
        )
        for decision, record in zip(case.decisions, decided, strict=True)
    ]
    checks += [
        record.check(
            "closed loop with tables",
            close.output,
            close.output,
            close.unit,
            f"{close.limit:g} {close.unit}, fault-free" if close.limit is not None else "shown",
            judged=close.limit is not None,
        )
        for close, record in zip(case.close, worst, strict=True)
    ]
    return tuple(checks), tuple(others)


def _first_other_decision(
    case: ClosedLoop, scenario: Scenario, got: Values, right: Values
) -> tuple[int, list[OtherDecision]]:
    """The number of frames in which all decisions are the same, and what differs in the frame after them."""
    frames = len(scenario)
    first = frames
    for decision in case.decisions:
        differs = (got[decision.output] != right[decision.output]).reshape(frames, -1).any(axis=1)
        first = min(first, int(np.argmax(differs)) if differs.any() else frames)
    others = []
    for decision in case.decisions if first < frames else ():
        for element in np.argwhere(got[decision.output][first] != right[decision.output][first]):
            index = tuple(int(i) for i in element)
            # A confirmation counts frames in a window: the measure may have been near its threshold in any of them.
            window = slice(max(0, first + 1 - decision.window), first + 1)
            measure = np.asarray(right[decision.measure])[window].reshape(window.stop - window.start, -1)
            measure = measure[:, np.ravel_multi_index(index, right[decision.measure].shape[1:])] * decision.scale
            nearest = measure[int(np.argmin(np.abs(measure - decision.threshold)))]
            excused = bool(abs(nearest - decision.threshold) <= decision.table_error)
            others.append(
                OtherDecision(
                    decision.output,
                    scenario.name,
                    first,
                    index,
                    float(nearest),
                    decision.threshold,
                    decision.unit,
                    excused,
                )
            )
    return first, others


def _see_decision(
    record: Worst,
    decision: Decision,
    scenario: Scenario,
    got: Values,
    right: Values,
    others: list[OtherDecision],
    first: int,
) -> None:
    """All frames up to the first difference are alike; that one counts unless it is excused."""
    mine = [other for other in others if other.output == decision.output and not other.excused]
    last = first + 1 if mine else first
    a: Array = np.asarray(got[decision.output][:last], dtype=np.float64)
    b: Array = np.asarray(right[decision.output][:last], dtype=np.float64)
    record.see(scenario, np.arange(float(last)), a, b, np.where(a == b, 0.0, np.inf))
