"""Step 1 of paper 004, III-A: residuals (17), their rms (18), and the fault decision."""

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
    over: Mask  # (2, 3), above the threshold now
    bad: Mask  # (2, 3), above the threshold or missing now
    faulty: Mask  # (2, 3), confirmed, for good


def judge(
    inputs: Conditioned,
    prediction: Array,
    residuals: Array,
    bads: Mask,
    faulty: Mask,
    inhibit: bool,
    tuning: Tuning,
) -> Judgement:
    """Judge the sensors against the one-step-ahead prediction.

    Args:
        inputs: the conditioned inputs.
        prediction: alpha and V_c predicted from the last frame, shape (2,), SI.
        residuals: the last N_eval - 1 residuals, shape (N_eval - 1, 2, 3).
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
    bad = over | missing
    confirmed = bads.sum(axis=0) + bad >= tuning.n_detect
    return Judgement(residual, rms, over, bad, faulty | confirmed)
