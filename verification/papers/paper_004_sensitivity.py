"""Paper 004, Section IV: the sensitivity of the residual with and without active bounds, and Theorem 1."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path

import numpy as np

from verification.flights import Fault, load_recording, sensors
from verification.papers.air_data_runs import CALM, DEGREES, NAMES, SLOW, WIND, run
from verification.papers.finding import Finding, Verdict
from verification.papers.style import COLOURS, LIMIT, figure, save
from verification.reference.arrays import Array
from verification.reference.tuning import Tuning
from verification.results.fault_sensitivity import ALPHA, VC, Sensitivity, held_newest, run_traces, sensitivity
from verification.results.fig4 import FAULT

PAPER = "004"
RAISED = 1.1
"""Sensitivity is improved: by a tenth or more."""

KEPT, LOST = 0.5, 0.05
"""In the long run a residual keeps a fault (half of it or more), or loses it."""

ROUNDING = 1e-6
"""Eigenvalues smaller than this count as zero."""

WORDS = {ALPHA: "AOA", VC: "airspeed"}
BIAS = {ALPHA: (6.0, 0.1), VC: (-80.0, -1.0)}
"""A bias of all three sensors that takes the wind to its bound, and what is added to it [deg], [kt]."""


@dataclass(frozen=True)
class Case:
    """A flight with a fault that takes the wind to a bound."""

    flight: str
    fault: Fault
    seconds: float

    @property
    def output(self) -> int:
        """Which residual is looked at: that of the faulty sensors."""
        return VC if self.fault.sensor == "vc" else ALPHA


CASES = (
    Case(CALM, FAULT, 30.0),
    Case(WIND, replace(FAULT, onset=52.0), 56.0),
    Case(CALM, Fault("runaway", "alpha", rate=2.0, onset=5.0), 15.0),
    Case(SLOW, Fault("runaway", "alpha", rate=-4.0, onset=5.0), 15.0),
)
SHORT = (Case(CALM, replace(FAULT, onset=4.0), 10.0), replace(CASES[2], seconds=9.5))


@dataclass(frozen=True, eq=False)
class Course:
    """A case flown by the reference of CMHE: the frames from a second before the onset until one is masked."""

    case: Case
    period: float
    frames: tuple[Sensitivity, ...]
    newest: tuple[float, ...]
    """At the first active frame of an airspeed fault: the answer with 0, 1, 2, 3 of the window's W_x held."""

    @property
    def active(self) -> tuple[Sensitivity, ...]:
        """Frames on a bound."""
        return tuple(one for one in self.frames if one.active)

    @property
    def raised(self) -> bool:
        """Whether the active bounds raise the answer in every frame."""
        return bool(self.active) and all(one.held >= RAISED * one.free for one in self.active)


def course(case: Case) -> Course:
    """Fly the reference of CMHE and work out both sensitivities in every frame."""
    tuning = Tuning()
    readings = sensors(load_recording(case.flight).part(0.0, case.seconds), 1, faults=[case.fault])
    traces = run_traces(readings.inputs(), tuning)
    rows: list[Sensitivity] = []
    newest: tuple[float, ...] = ()
    for k in range(case.fault.onset_frame(tuning.t_s) - 20, len(traces) - 1):
        if not traces[k].window.row_mask.all():
            break
        rows.append(sensitivity(k, traces[k], traces[k + 1], tuning, case.output))
        if rows[-1].active and not newest and case.output == VC:
            newest = held_newest(traces[k], traces[k + 1], tuning)
    return Course(case, tuning.t_s, tuple(rows), newest)


def long_run(output: int, sheet: str, onset: float = 5.0, seconds: float = 12.0) -> Array:
    """What the residual keeps of a lasting change of the readings, by frame after the onset; calm air.

    Two runs with biases that differ by a little; decisions are switched off, so that the faulty sensors stay.
    """
    truth = load_recording(CALM).part(0.0, seconds)
    sensor, unit = ("vc", 1.0) if output == VC else ("alpha", DEGREES)
    bias, more = BIAS[output]
    faults = [Fault("bias", sensor, amplitude=amplitude, onset=onset) for amplitude in (bias, bias + more)]
    out = run(
        sheet,
        [sensors(truth, 1, faults=[fault]) for fault in faults],
        {"vc_threshold": 900.0, "alpha_threshold": 170.0},
    )
    predicted = out[f"{sensor}_pred"] * unit
    answer: Array = 1.0 - (predicted[1] - predicted[0]) / more
    return answer[faults[0].onset_frame(truth.period) :]


def findings(pictures: Path, *, short: bool = False) -> Iterator[Finding]:
    """Section IV-B, the long run, and the two parts of Theorem 1; short: two cases, their faults earlier."""
    courses = [course(case) for case in (SHORT if short else CASES)]
    yield improved(courses)
    yield kept({(o, s): long_run(o, s) for o in (VC, ALPHA) for s in ("cmhe_fte", "umhe_fte")}, courses[0], pictures)
    yield theorem(courses)
    yield more_bounds(courses)


def improved(courses: Sequence[Course]) -> Finding:
    """What the bounds do to S_f in one window."""
    raised, not_raised = ([c for c in courses if c.raised is wanted] for wanted in (True, False))
    kinds = {WORDS[c.case.output] for c in raised}, {WORDS[c.case.output] for c in not_raised}
    condition = ""
    if not not_raised:
        verdict = Verdict.HOLDS
    elif raised and not kinds[0] & kinds[1]:
        verdict = Verdict.ONLY_IF
        least, most = min(c.active[0].free for c in not_raised), max(c.active[0].held for c in not_raised)
        condition = (
            f"the fault is one of {' and '.join(kinds[0])}; that of {' and '.join(kinds[1])} is answered with"
            f" {least:.2f} to {most:.2f} with or without the bound"
        )
    else:
        verdict = Verdict.FAILS
    rows = "\n".join(
        f"| {c.case.flight} | {WORDS[c.case.output]} {c.case.fault.rate:+g} |"
        f" {(c.active[0].frame - c.case.fault.onset_frame(c.period)) * c.period:.2f} | {', '.join(c.active[0].active)}"
        f" | {c.active[0].free:.3f} | {c.active[0].held:.3f} | {len(c.active)} | {min(s.held for s in c.active):.3f} |"
        for c in courses
        if c.active
    )
    text = (
        "Three sensors run away (kt/s, deg/s) through the reference of CMHE-FTE. In every frame the window's quadratic"
        " program (42) is solved exactly; the bounds that hold the solution are J_a of (37). The answer is the sum of"
        " S_f's (or S_f^a's) entries from a fault of 1 in every sample of the window and the next one to the residual"
        " of the faulty kind: 1 if the estimate takes in nothing.\n\n| flight | fault | first active after onset, s |"
        f" bounds | without | with | active frames | least with |\n|---|---|---|---|---|---|---|---|\n{rows}\n\nAn"
        " airspeed fault has only W_x to go into; a fault of AOA goes into the angle of attack itself, which no bound"
        " holds, and into W_z."
    )
    claim = (
        "active bounds keep the estimate from taking in the fault, so the residual becomes more sensitive, from the"
        " first instant on"
    )
    return Finding(PAPER, "Section IV", "sensitivity at the wind's bound", claim, verdict, condition, text)


def kept(answers: Mapping[tuple[int, str], Array], shown: Course, pictures: Path) -> Finding:
    """What the bounds do in the long run."""
    last = {key: float(answer[-20:].mean()) for key, answer in answers.items()}
    verdict = (
        Verdict.HOLDS
        if all((v >= KEPT) if s == "cmhe_fte" else (abs(v) <= LOST) for (_, s), v in last.items())
        else Verdict.FAILS
    )
    with figure(7.2, 2.6) as drawn:
        left, right = drawn.subplots(1, 2, sharey=True)
        time = [one.frame * shown.period for one in shown.frames]
        left.plot(time, [one.held for one in shown.frames], color=COLOURS[0], label="active bounds held")
        left.plot(time, [one.free for one in shown.frames], color=COLOURS[1], label="without bounds")
        left.axvline(shown.case.fault.onset, color=LIMIT, linestyle=":", linewidth=0.8)
        left.set_xlabel("t [s]; dotted: airspeed sensors run away")
        left.set_ylabel("answer to a lasting fault, S_f")
        left.set_ylim(-0.05, 1.1)
        left.legend(loc="lower left")
        for (output, sheet), answer in answers.items():
            colour, dash = COLOURS[0] if sheet == "cmhe_fte" else COLOURS[1], "-" if output == VC else "--"
            label = f"{NAMES[sheet]}, {WORDS[output]}"
            right.plot(np.arange(len(answer)) * shown.period, answer, dash, color=colour, label=label)
        right.set_xlabel("time after the onset of a bias [s]")
        right.legend(loc="center right")
        save(drawn, pictures / "004_sensitivity.png")
    rows = "\n".join(
        f"| {WORDS[o]}, {BIAS[o][0]:+g} {'kt' if o == VC else 'deg'} | {NAMES[s]} | "
        + " | ".join(f"{a[i]:.2f}" for i in (0, 5, 10, 20, 40))
        + f" | {last[o, s]:.2f} |"
        for (o, s), a in answers.items()
    )
    text = (
        "S_f sees one window of three samples; what is estimated there is the next window's prior. So the same by"
        " experiment: all three sensors biased so far that the wind meets its bound, once more by 1 kt or 0.1 deg,"
        " decisions switched off; what the residual keeps of the difference, by frames after the onset:\n\n| fault | |"
        f" 0 | 5 | 10 | 20 | 40 | the last 20 of {len(answers[VC, 'cmhe_fte'])}"
        f" |\n|---|---|---|---|---|---|---|---|\n{rows}\n\nWithout bounds every lasting fault goes into the wind, and"
        " nothing is left after some seconds; with the wind at its bound the residual keeps all of an airspeed fault,"
        " and most of one of AOA, since the vertical speed then says what the angle of attack is. This, far more than"
        " what changes in S_f, is what detects. (The dip of CMHE is where the wind is still on its way to the bound.)"
    )
    claim = "once at its bound the wind can no longer compensate for the fault, and the residual grows"
    return Finding(PAPER, "Section IV", "in the long run", claim, verdict, "", text, ("004_sensitivity.png",))


def theorem(courses: Sequence[Course]) -> Finding:
    """S_a S_a' >= S S'."""
    active = [one for c in courses for one in c.active]
    least, largest = min(one.printed[0] for one in active), max(one.printed[1] for one in active)
    indefinite = sum(one.printed[0] < -ROUNDING and one.printed[1] > ROUNDING for one in active)
    turned = sum(one.in_deviations[1] <= ROUNDING for one in active)
    lowest = min(one.in_deviations[0] for one in active)
    verdict = Verdict.HOLDS if all(one.printed[0] >= -ROUNDING for one in active) else Verdict.FAILS
    text = (
        f"Eigenvalues of S_a S_a' - S S' over {len(active)} frames with an active bound, SI units: from {least:.2f} to"
        f" {largest:.2f}; in {indefinite} of them some are negative and some positive. With faults and residuals"
        f" counted in standard deviations none is positive in {turned} of {len(active)} (least {lowest:.3f}): the"
        " inequality then holds the other way round. That can be proved: with U = diag(V, R) in the middle, S U S' ="
        " Phi J_1 X H X J_1' Phi' + R, and X H X = X, so the smaller X_a makes it smaller. The printed proof fails at"
        " its last step: V - J_1 X_a J_1' >= V - J_1 X J_1' does not carry over to the product (39), whose outer two"
        " matrices differ. Either way S S' takes away the signs with which the entries of a lasting fault add up. What"
        " the theorem is for does hold, in the long run: see above."
    )
    claim = "with active bounds S_a S_a' >= S S'"
    return Finding(PAPER, "Theorem 1", "the inequality", claim, verdict, "", text)


def more_bounds(courses: Sequence[Course]) -> Finding:
    """A larger number of active bounds."""
    answers = [c.newest for c in courses if c.newest]
    grows = all(b > a + 1e-3 for row in answers for a, b in pairwise(row[1:]))
    verdict = Verdict.HOLDS if answers and grows else Verdict.FAILS
    heads = " | ".join(f"{i} held" for i in range(len(answers[0])))
    rows = "\n".join(
        f"| {c.case.flight} | " + " | ".join(f"{a:.4f}" for a in c.newest) + " |" for c in courses if c.newest
    )
    text = (
        "The answer to a lasting airspeed fault at the first active frame, with none, the newest, the two newest and"
        f" all three horizontal winds of the window held at the bound:\n\n| flight | {heads}"
        f" |\n|---|{'---|' * len(answers[0])}\n{rows}\n\nHolding the newest wind is enough, since the prediction rests"
        " on it alone; the others add nothing."
    )
    claim = "a larger number of active bounds gives a higher sensitivity"
    return Finding(PAPER, "Theorem 1", "the number of bounds", claim, verdict, "", text)
