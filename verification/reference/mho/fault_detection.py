"""Fault detection of paper 003, section 5.2 and Fig. 8: one angle-of-attack sensor against its estimate.

r_k = alpha_m,k - alpha_hat_k; its root mean square over the sliding window [k - N_e, k], which has N_e + 1 samples,
against a threshold. A missing reading enters the window as 0, and so do the samples before the first frame.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from verification.reference.arrays import DEGREE, Array, Mask
from verification.reference.mho.tuning import MhoTuning


@dataclass(frozen=True)
class Detection:
    """What one frame says of the sensor."""

    residual: float  # rad
    rms: float  # rad
    faulty: bool  # above the threshold in this frame
    past: Array  # (N_e,): the residuals that the next frame begins with


def detect(alpha: float, alpha_hat: float, past: Array, tuning: MhoTuning) -> Detection:
    """Judge the reading `alpha` [rad] against the estimate; `past` (N_e,) are the residuals before, oldest first."""
    limit = tuning.alpha_range * DEGREE
    residual = float(alpha - alpha_hat) if -limit <= alpha <= limit else 0.0
    window = np.append(past, residual)
    rms = float(np.sqrt(np.mean(window**2)))
    return Detection(residual, rms, rms > tuning.alpha_threshold, window[1:])


@dataclass(frozen=True)
class Judged:
    """One sensor over a run, one row a frame."""

    residual: Array  # (n,) rad
    rms: Array  # (n,) rad
    faulty: Mask  # (n,)


def judge(recording: Mapping[str, npt.ArrayLike], alpha_hat: Array, tuning: MhoTuning) -> Judged:
    """Judge the readings `alpha` [rad] against the estimates `alpha_hat` (n,) [rad]."""
    past, found = np.zeros(tuning.n_eval), []
    for alpha, estimate in zip(np.asarray(recording["alpha"], dtype=np.float64), alpha_hat, strict=True):
        found.append(detect(float(alpha), float(estimate), past, tuning))
        past = found[-1].past
    return Judged(*(np.array([getattr(one, name) for one in found]) for name in ("residual", "rms", "faulty")))
