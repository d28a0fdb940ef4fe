"""Step 1 of paper 004, III-A: residuals (17), their rms (18), and the fault decision.

Beside it the doubt, which the paper does not know. Two faulty sensors that drift alike, or one that stands still while the
wind changes, can draw the prediction away from a healthy sensor. So, where the sensors of a kind disagree, the wind from
before is kept, and a sensor that fits it better than the prediction is not condemned: it is in doubt, and stays so while
its residual falls, as it does once the prediction is drawn back.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from verification.reference.arrays import Array, Mask
from verification.reference.conditioning import Conditioned
from verification.reference.tuning import Tuning


@dataclass(frozen=True)
class Judgement:
    """What Step 1 finds of the sensors, rows alpha and V_c, SI."""

    residual: Array  # (2, 3)
    rms: Array  # (2, 3)
    square_held: Array  # (2, 3), squared residuals against the prediction with the wind from before
    over: Mask  # (2, 3), above the threshold now
    doubtful: Mask  # (2, 3), above the threshold now, but in doubt
    bad: Mask  # (2, 3), above the threshold without doubt, or missing, now
    faulty: Mask  # (2, 3), confirmed, for good


def judge(
    inputs: Conditioned,
    prediction: Array,
    held: Array,
    residuals: Array,
    squares_held: Array,
    rms_before: Array,
    doubtful_before: Mask,
    bads: Mask,
    faulty: Mask,
    inhibit: bool,
    tuning: Tuning,
) -> Judgement:
    """Judge the sensors against the one-step-ahead prediction.

    Args:
        inputs: the conditioned inputs.
        prediction: alpha and V_c predicted from the last frame, shape (2,), SI.
        held: the same with the wind from before the sensors disagreed.
        residuals: the last N_eval - 1 residuals, shape (N_eval - 1, 2, 3).
        squares_held: the last N_eval - 1 values of `square_held`, same shape.
        rms_before: `rms` of the last frame, shape (2, 3).
        doubtful_before: `doubtful` of the last frame, shape (2, 3).
        bads: the last N_eval - 1 values of `bad`, same shape.
        faulty: confirmed faults up to the last frame, shape (2, 3).
        inhibit: no residual may be judged in this frame.
        tuning: the parameters.
    """
    missing = ~inputs.sensors_valid
    residual = np.where(missing, 0.0, inputs.sensors - prediction[:, None])  # (17)
    squares = (residuals**2).sum(axis=0) + residual**2
    rms = np.sqrt(squares / tuning.n_eval)  # (18)
    over = (rms > tuning.threshold) & (not inhibit)
    square_held = np.where(missing, 0.0, inputs.sensors - held[:, None]) ** 2
    sum_held = squares_held.sum(axis=0) + square_held
    small = sum_held <= (tuning.doubt_limit * tuning.threshold) ** 2 * tuning.n_eval
    near = small & (sum_held < tuning.doubt**2 * tuning.n_eval * rms**2)
    recovering = doubtful_before & (rms < rms_before)
    doubtful = over & (near | recovering)
    bad = (over & ~doubtful) | missing
    confirmed = bads.sum(axis=0) + bad >= tuning.n_detect
    return Judgement(residual, rms, square_held, over, doubtful, bad, faulty | confirmed)


@dataclass(frozen=True)
class HeldWind:
    """The wind against which sensors are doubted, and why it is kept or not; entries alpha and V_c."""

    apart: Mask  # (2,), the sensors in use are further apart than those that agree
    wind: Array  # (2,), W_z for alpha, W_x for V_c, m/s


def hold_wind(
    inputs: Conditioned,
    predicted: Array,
    held: Array,
    aparts: Mask,
    doubtful: Mask,
    faulty: Mask,
    tuning: Tuning,
) -> HeldWind:
    """Keep the wind from before while the sensors of a kind disagree, or while one of them is in doubt.

    Args:
        inputs: the conditioned inputs.
        predicted: W_z and W_x predicted from the last frame, shape (2,), m/s.
        held: the last value of `wind`.
        aparts: the last N_eval - 1 values of `apart`, shape (N_eval - 1, 2).
        doubtful: sensors in doubt in the last frame, shape (2, 3).
        faulty: confirmed faults up to the last frame, shape (2, 3).
        tuning: the parameters.
    """
    used = inputs.sensors_valid & ~faulty
    highest = np.where(used, inputs.sensors, -np.inf).max(axis=1)
    lowest = np.where(used, inputs.sensors, np.inf).min(axis=1)
    apart = highest - lowest > tuning.split
    disagree = aparts.sum(axis=0) + apart >= tuning.n_detect
    return HeldWind(apart, np.where(disagree | doubtful.any(axis=1), held, predicted))
