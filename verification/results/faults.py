"""The faults of Table II of paper 004 on a flight: detected or not, how soon, and what the estimates do meanwhile.

Ours is an open loop: the faulty readings do not feed back into the aircraft, as they do in the paper's benchmark.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from verification.flights import KINDS, Fault, load_recording, sensors, table_ii_levels
from verification.results.batch import Outcome, Progress, first_frame, run_batch

SENSORS = ("alpha", "vc")
LEVELS = ("low", "middle", "high")
WHICH = ((1,), (1, 2), (1, 2, 3))
SEEDS = (1, 2, 3)
ONSET = 12.0
"""[s] from the first frame: the wind estimate has long settled."""
DURATION = 55.0
"""[s]: the slowest runaway of Table II on V_c, 0.5 kt/s, passes the threshold of 12 kt after 24 s."""
SIGNED = ("jamming", "bias", "runaway")
"""Kinds that have a direction: negative with the second of every three seeds."""


@dataclass(frozen=True)
class Trial:
    """One kind of fault at one level on some sensors, with one noise seed."""

    fault: Fault
    level: str
    seed: int


@dataclass(frozen=True)
class Result:
    """What became of a trial."""

    trial: Trial
    confirmed: int
    """How many of the faulty sensors were confirmed by the end."""
    delay_s: float | None
    """From onset to the confirmation of the last faulty sensor [s]; None: not all were confirmed."""
    wrong: int
    """Healthy sensors, of either kind, that were confirmed at any time."""
    alpha_error: float
    """Largest error of the angle of attack after onset [deg]."""
    vc_error: float
    """Largest error of the airspeed after onset [kt]."""

    @property
    def found(self) -> bool:
        """All faulty sensors were confirmed."""
        return self.delay_s is not None


def trials(seeds: Sequence[int] = SEEDS, which: Sequence[tuple[int, ...]] = WHICH, onset: float = ONSET) -> list[Trial]:
    """Every fault of Table II at its low, middle and high end, on one, two and three sensors, once a seed."""
    made = []
    for sensor in SENSORS:
        for kind in KINDS:
            levels = table_ii_levels(kind, sensor)
            # Non-return-to-zero has one value only.
            distinct = dict(zip(LEVELS, levels, strict=True)) if len(set(levels)) > 1 else {"": levels[0]}
            for level, fault in distinct.items():
                for sensors_hit in which:
                    for number, seed in enumerate(seeds):
                        signed = _negative(fault) if kind in SIGNED and number % 3 == 1 else fault
                        made.append(Trial(replace(signed, which=sensors_hit, onset=onset), level, seed))
    return made


def _negative(fault: Fault) -> Fault:
    if fault.kind == "runaway":
        return replace(fault, rate=-(fault.rate or 0.0))
    return replace(fault, amplitude=-(fault.amplitude or 0.0))


def run_trials(
    flight: str,
    chosen: Sequence[Trial],
    sheet: str = "cmhe_fte",
    duration: float = DURATION,
    progress: Progress | None = None,
) -> list[Result]:
    """Fly every trial on a shipped recording, all side by side."""
    truth = load_recording(flight).part(0.0, duration)
    flights = [sensors(truth, trial.seed, faults=[trial.fault]) for trial in chosen]
    outcomes = run_batch(sheet, flights, progress)
    return [_result(trial, outcome, truth.period) for trial, outcome in zip(chosen, outcomes, strict=True)]


def _result(trial: Trial, outcome: Outcome, period: float) -> Result:
    onset = trial.fault.onset_frame(period)
    hit = np.zeros(3, dtype=bool)
    hit[[i - 1 for i in trial.fault.which]] = True
    mine = outcome.faulty(trial.fault.sensor)
    other = outcome.faulty("vc" if trial.fault.sensor == "alpha" else "alpha")
    # A sensor condemned before its fault is a false alarm, and no detection.
    early = int(mine[onset - 1][hit].sum())
    last = first_frame(mine[:, hit], int(hit.sum()))
    delay = (last - onset) * period if last is not None and not early else None
    return Result(
        trial,
        int(mine[-1][hit].sum()) - early,
        delay,
        int(mine[-1][~hit].sum()) + int(other[-1].sum()) + early,
        float(np.abs(outcome.alpha_error[onset:]).max()),
        float(np.abs(outcome.vc_error[onset:]).max()),
    )
