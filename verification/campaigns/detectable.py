"""Whether a fault must be found: whether the residual that it makes has to exceed the threshold.

The rule looks at the fault's own signal (reading with the fault minus reading without it, no noise) and at the truth of
the flight, never at what an estimator made of them. The rms of the signal over the evaluation window must stay above
:data:`MARGIN` times the threshold for a whole window. Of three faulty sensors of a kind, what wind inside its bounds
can explain is taken away first: airspeeds that move together by no more than the horizontal wind may still change look
like wind, and so do angles of attack by the vertical wind over the airspeed.
"""

from __future__ import annotations

import numpy as np

from verification.flights import Fault
from verification.flights.faults import UNIT_IN_RECORDING
from verification.recordings import Recording
from verification.recordings.recording import Array
from verification.reference.tuning import Tuning

MARGIN = 1.25
"""Above the threshold: for sensor noise, and for what the fusion lets through."""


def detectable(fault: Fault, truth: Recording, tuning: Tuning) -> bool:
    """Whether ``fault`` on the flight ``truth`` must be found with ``tuning``."""
    signal = np.abs(signal_of(fault, truth))
    if len(fault.which) == 3:
        signal = np.maximum(signal - _room(fault, truth, tuning), 0.0)
    threshold = tuning.alpha_threshold if fault.sensor == "alpha" else tuning.vc_threshold
    n = tuning.n_eval
    if len(signal) < 2 * n:
        return False
    total = np.cumsum(np.concatenate([[0.0], signal**2]))
    above = np.sqrt((total[n:] - total[:-n]) / n) > MARGIN * threshold
    counts = np.cumsum(np.concatenate([[0], above]))
    return bool((counts[n:] - counts[:-n] == n).any())


def signal_of(fault: Fault, truth: Recording) -> Array:
    """What the fault adds to a noise-free reading from its onset on [deg or kt]; white noise by its standard deviation."""
    reading = truth[f"{fault.sensor}_true"]
    first = fault.onset_frame(truth.period)
    if fault.kind == "noise":
        return np.full(len(reading) - first, fault.amplitude or 0.0)
    faulty = fault.apply(reading, truth.period, np.random.default_rng(0))
    return (faulty - reading)[first:] / UNIT_IN_RECORDING[fault.sensor]


def _room(fault: Fault, truth: Recording, tuning: Tuning) -> Array | float:
    """How much of the signal wind inside its bounds explains [deg or kt]."""
    first = fault.onset_frame(truth.period)
    if fault.sensor == "vc":
        return tuning.wx_max + np.abs(truth["wx_true"][first:])
    return np.degrees((tuning.wz_max + np.abs(truth["wz_true"][first:])) / np.maximum(truth["vc_true"][first:], 50.0))
