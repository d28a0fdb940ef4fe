"""Which faults must be found: those whose residual has to exceed the threshold.

The rule looks at the fault's own signal e (the reading with the fault minus the one without it, no noise) and at the truth
of the flight, never at what an estimator made of them.

1. What reaches the estimator. The fusion weighs sensors by their residuals, so those that jump away from the prediction
   have no more than their share by number: a third of one, two thirds of two. Of two that run away alike it may let all
   through: they are the majority, they draw the prediction with them, and nothing in them tells who is wrong. Of three
   it always does.
2. What the estimator makes of that. What is let through is an airspeed or an angle of attack that wind could explain. How
   fast the wind estimate follows is given by the weights P, Q, R, as the paper's fault sensitivity (36) says, and how far
   by the bounds of wind, (39); the true wind of the flight uses up its part of them (`explained`).
3. What must be seen. The residual is e minus what the prediction followed; its rms J over the evaluation window, (18), must
   exceed the threshold by :data:`MARGIN` in n_D of N_eval frames.
4. When. A runaway may take all flight. The other kinds begin at full size: they count by what they are within
   :data:`FIRST_S` of the onset, one period of Table II's slowest oscillation. A sensor that jams near its true value, or
   one that does not return to zero near zero, is wrong by little then; it may be found later, when the flight has made more
   of it (`after` says from when it has to be). It is counted apart, as are all others, found or not.

White noise is its own rms: no wind explains it, and the prediction does not know it.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from verification.campaigns.explained import airspeed_window, alpha_window, followed
from verification.flights import Fault
from verification.flights.faults import UNIT_IN_RECORDING
from verification.recordings import Recording
from verification.recordings.recording import Array
from verification.reference.air_data import calibrated_airspeed
from verification.reference.arrays import DEGREE, KNOT
from verification.reference.tuning import Tuning

MARGIN = 1.1
"""Above the threshold, for noise: that of a sensor and of the prediction moves an rms of 10 samples by 2.5 % of either
threshold (one standard deviation)."""

JUMP = {1: 1.0 / 3.0, 2: 2.0 / 3.0, 3: 1.0}
"""The share of a fault of so many sensors that the fusion may let through, if it begins at full size."""

DRIFT = {1: 1.0 / 3.0, 2: 1.0, 3: 1.0}
"""The same of a runaway."""

FIRST_S = 2.0
"""[s]: within this time of the onset a fault that begins at full size shows what it is."""

SETTLED = 60
"""Frames before the onset from which the wind is followed: several times as long as the estimate needs to settle."""


def detectable(fault: Fault, truth: Recording, tuning: Tuning) -> bool:
    """Whether ``fault`` on the flight ``truth`` must be found with ``tuning``."""
    return after(fault, truth, tuning, None if fault.kind == "runaway" else FIRST_S) is not None


def after(fault: Fault, truth: Recording, tuning: Tuning, within: float | None = None) -> float | None:
    """The time from onset until ``fault`` must have been found [s]; None: never, or not ``within`` [s] of the onset."""
    signal = signal_of(fault, truth)
    if within is not None:
        signal = signal[: round(within / truth.period) + 1]
    alpha = fault.sensor == "alpha"
    limit = (MARGIN * (tuning.alpha_threshold if alpha else tuning.vc_threshold)) ** 2 * tuning.n_eval
    if fault.kind == "noise":
        residual: Iterator[float] = iter(signal)
    elif signal.size == 0 or np.abs(signal).max() ** 2 * tuning.n_eval <= limit / 4.0:
        return None  # far below: not even a residual that wind doubles
    else:
        residual = _residual_alpha(fault, signal, truth, tuning) if alpha else _residual_vc(fault, signal, truth, tuning)
    squares, above = [0.0] * tuning.n_eval, [False] * tuning.n_eval
    for k, value in enumerate(residual):
        squares[k % tuning.n_eval] = value * value
        above[k % tuning.n_eval] = sum(squares) > limit
        if sum(above) >= tuning.n_detect:
            return k * truth.period
    return None


def signal_of(fault: Fault, truth: Recording) -> Array:
    """What the fault adds to a noise-free reading from its onset on [deg or kt]; white noise by its standard deviation."""
    reading = truth[f"{fault.sensor}_true"]
    first = fault.onset_frame(truth.period)
    if fault.kind == "noise":
        return np.full(len(reading) - first, fault.amplitude or 0.0)
    faulty = fault.apply(reading, truth.period, np.random.default_rng(0))
    return (faulty - reading)[first:] / UNIT_IN_RECORDING[fault.sensor]


def _residual_vc(fault: Fault, signal: Array, truth: Recording, tuning: Tuning) -> Iterator[float]:
    """The residual of a faulty airspeed sensor from the onset on [kt]."""
    first, past, flown = _frames(fault, signal, truth)
    wind, let = truth["wx_true"][flown] * KNOT, _let_through(fault, signal, past) * KNOT
    v_t = (truth["vg"][first] - truth["wx_true"][first]) * KNOT
    slope = float(calibrated_airspeed(np.array(max(v_t, tuning.vt_min)), truth["z"][first])[1])
    # Tail wind lowers the airspeed: the wind that would explain the reading is lower by what is added to it.
    predicted = followed(airspeed_window(slope, tuning), wind, (wind - let / slope)[:, None], np.zeros(len(wind)))
    for k, x in enumerate(predicted):
        if k >= past:
            yield float(signal[k - past] + slope * (x[0] - wind[k]) / KNOT)


def _residual_alpha(fault: Fault, signal: Array, truth: Recording, tuning: Tuning) -> Iterator[float]:
    """The residual of a faulty angle-of-attack sensor from the onset on [deg]."""
    first, past, flown = _frames(fault, signal, truth)
    wind, let = truth["wz_true"][flown] * KNOT, _let_through(fault, signal, past) * DEGREE
    v_g = float(truth["vg"][first]) * KNOT
    # (8): rising vertical wind turns the air away under the model, which does not know it.
    drift = np.diff(wind, prepend=wind[0]) / v_g
    predicted = followed(alpha_window(v_g, tuning), wind, np.column_stack([let, -wind]), drift)
    for k, x in enumerate(predicted):
        if k >= past:
            yield float(signal[k - past] - x[0] / DEGREE)


def _frames(fault: Fault, signal: Array, truth: Recording) -> tuple[int, int, slice]:
    """The frame of the onset, how many frames before it are followed, and all that are."""
    first = fault.onset_frame(truth.period)
    past = min(first, SETTLED)
    return first, past, slice(first - past, first + len(signal))


def _let_through(fault: Fault, signal: Array, past: int) -> Array:
    share = DRIFT if fault.kind == "runaway" else JUMP
    return share[len(fault.which)] * np.concatenate([np.zeros(past), signal])
