"""What a demonstration found, as data: which sensors were isolated when, and how good the estimates are."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from saoflow import LoadedSheet
from saoflow.report import limits_of
from saoflow.scheduler.budget import BudgetReport
from verification.demo.scenario import FRAMES_SHOWN, WITHIN, Scenario
from verification.recordings.recording import Array, Recording

Arrays = dict[str, Array]

DEGREES = 180.0 / np.pi
SETTLED = 50
"""Frames after the start in which decisions are inhibited; errors are judged after them."""

WINDOW = 10
"""Frames that decide on a sensor: N_eval."""

TOLERANCES = {"alpha": 1e-3, "vc": 0.02}
"""Sheet with tables against the reference without, fault-free, closed loop: deg, kt."""

ROUNDING = {"alpha": 1e-9, "vc": 1e-9}
"""The same with exact functions in place of the tables: deg, kt."""


@dataclass(frozen=True)
class Confirmed:
    """A sensor confirmed faulty: "alpha" or "vc", its number from 1, and the frame."""

    sensor: str
    number: int
    frame: int


@dataclass(frozen=True)
class Errors:
    """Error of an estimate over some frames: root mean square and largest absolute value; deg or kt."""

    rms: float
    largest: float


@dataclass(frozen=True, eq=False)
class Method:
    """One estimator's part of the demonstration.

    ``outputs``: the sheet as it flies, with tables; ``exact``: the sheet with functions in place of its tables;
    ``reference``: the numpy reference. All (frames, *shape), in the same closed loop over the same readings.
    ``seconds``: of running the sheet.
    """

    sheet: LoadedSheet
    budget: BudgetReport
    outputs: Arrays
    exact: Arrays
    reference: Arrays
    seconds: float

    @property
    def label(self) -> str:
        """The sheet's name as the paper writes it."""
        return self.sheet.name.upper().replace("_", "-")

    @cached_property
    def confirmed(self) -> tuple[Confirmed, ...]:
        """Every sensor confirmed faulty, in order of time."""
        return confirmations(self.outputs)

    def difference(self, quantity: str, exact: bool) -> Array:
        """Distance of the estimate from the reference, (frames,); deg for "alpha", kt for "vc"."""
        own = self.exact if exact else self.outputs
        factor = DEGREES if quantity == "alpha" else 1.0
        return factor * np.abs(own[f"{quantity}_hat"] - self.reference[f"{quantity}_hat"])

    @cached_property
    def other_decisions(self) -> tuple[OtherDecision, ...]:
        """Sensors that the sheet with tables confirms at another frame than the reference."""
        limits = limits_of(self.sheet)
        thresholds = {"alpha": limits.alpha_threshold_deg, "vc": limits.vc_threshold_kt}
        found = []
        for sensor, number in sorted({(c.sensor, c.number) for c in (*self.confirmed, *confirmations(self.reference))}):
            own, other = (_frame(found_, sensor, number) for found_ in (self.confirmed, confirmations(self.reference)))
            if own == other:
                continue
            first = min(frame for frame in (own, other) if frame is not None)
            factor = DEGREES if sensor == "alpha" else 1.0
            rms = factor * self.reference[f"{sensor}_rms"][max(first - WINDOW, 0) : first + 1, number - 1]
            margin = float(np.abs(rms - (thresholds[sensor] or 0.0)).min())
            found.append(OtherDecision(sensor, number, own, other, margin))
        return tuple(found)

    @property
    def same_decisions(self) -> bool:
        """Whether sheet and reference decide alike.

        With exact functions: the same sensors at the same frames. With tables likewise, but where the rms came within
        the tables' tolerance of its threshold.
        """
        return confirmations(self.exact) == confirmations(self.reference) and all(
            other.margin <= TOLERANCES[other.sensor] for other in self.other_decisions
        )


@dataclass(frozen=True)
class OtherDecision:
    """A sensor confirmed by the sheet at ``own`` and by the reference at ``other`` (frames, None: never).

    ``margin``: how near the reference's rms came to the threshold in the frames that decided; deg or kt.
    """

    sensor: str
    number: int
    own: int | None
    other: int | None
    margin: float


def _frame(found: tuple[Confirmed, ...], sensor: str, number: int) -> int | None:
    return next((c.frame for c in found if (c.sensor, c.number) == (sensor, number)), None)


def confirmations(outputs: Arrays) -> tuple[Confirmed, ...]:
    """Every sensor confirmed faulty, in order of time."""
    found = []
    for sensor in ("alpha", "vc"):
        latched = outputs[f"{sensor}_faulty"] > 0.5
        for i in np.flatnonzero(latched.any(axis=0)):
            found.append(Confirmed(sensor, int(i) + 1, int(np.argmax(latched[:, i]))))
    return tuple(sorted(found, key=lambda c: (c.frame, c.sensor, c.number)))


@dataclass(frozen=True, eq=False)
class DemoResult:
    """The scenario, the readings with truth, and both estimators on them."""

    scenario: Scenario
    recording: Recording
    cmhe: Method
    umhe: Method

    @property
    def methods(self) -> tuple[Method, Method]:
        """CMHE-FTE, UMHE-FTE."""
        return self.cmhe, self.umhe

    @property
    def time(self) -> Array:
        """(frames,) [s]."""
        return self.recording["t"]

    def delays(self, method: Method) -> dict[int, int]:
        """Frames from onset to confirmation, by the number of the faulty sensor; only confirmed ones."""
        fault, onset = self.scenario.fault, self.scenario.onset_frame
        return {
            c.number: c.frame - onset
            for c in method.confirmed
            if c.sensor == fault.sensor and c.number in fault.which and c.frame >= onset
        }

    def isolated_frame(self, method: Method) -> int | None:
        """The frame in which the last faulty sensor was confirmed; None if one was not."""
        delays = self.delays(method)
        return (
            None if set(delays) != set(self.scenario.fault.which) else max(delays.values()) + self.scenario.onset_frame
        )

    def false_alarms(self, method: Method) -> tuple[Confirmed, ...]:
        """Sensors confirmed that were not faulty, or not yet."""
        right = self.delays(method)
        fault = self.scenario.fault
        return tuple(c for c in method.confirmed if c.sensor != fault.sensor or c.number not in right)

    def errors(self, method: Method, quantity: str, first: int, last: int) -> Errors:
        """Error of the estimate of "alpha" [deg] or "vc" [kt] over frames first to last - 1."""
        factor = DEGREES if quantity == "alpha" else 1.0
        error = factor * (method.outputs[f"{quantity}_hat"] - self.recording[f"{quantity}_true"])[first:last]
        return Errors(float(np.sqrt(np.mean(error**2))), float(np.abs(error).max()))

    def largest_difference(self, method: Method, quantity: str, exact: bool, fault_free: bool) -> float:
        """Largest distance from the reference before the onset (``fault_free``) or over the whole run."""
        distance = method.difference(quantity, exact)
        return float(distance[: self.scenario.onset_frame].max() if fault_free else distance.max())

    # -- what is checked

    @property
    def detected(self) -> bool:
        """CMHE-FTE confirms every faulty sensor within 6 s, and no other."""
        frame = self.isolated_frame(self.cmhe)
        on_time = frame is not None and (frame - self.scenario.onset_frame) * self.recording.period <= WITHIN
        return on_time and not self.false_alarms(self.cmhe)

    @property
    def not_by_umhe(self) -> bool:
        """UMHE-FTE confirms nothing within the 370 frames of the paper."""
        return all(c.frame - self.scenario.onset_frame >= FRAMES_SHOWN for c in self.umhe.confirmed)

    @property
    def equal(self) -> bool:
        """Both sheets equal the reference: fault-free within the tolerances, and every decision at the same frame."""
        return all(
            method.same_decisions
            and self.largest_difference(method, quantity, False, True) <= TOLERANCES[quantity]
            and self.largest_difference(method, quantity, True, True) <= ROUNDING[quantity]
            for method in self.methods
            for quantity in ("alpha", "vc")
        )

    @property
    def holds(self) -> bool:
        """Whether everything that the demonstration claims holds."""
        return self.detected and self.not_by_umhe and self.equal and not any(m.budget.over for m in self.methods)
