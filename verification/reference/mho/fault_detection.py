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
class Judged:
    """One sensor over a run, one row a frame."""

    residual: Array  # (n,) rad
    rms: Array  # (n,) rad
    faulty: Mask  # (n,): above the threshold in this frame


def judge(recording: Mapping[str, npt.ArrayLike], alpha_hat: Array, tuning: MhoTuning) -> Judged:
    """Judge the readings `alpha` [rad] against the estimates `alpha_hat` (n,) [rad]."""
    alpha = np.asarray(recording["alpha"], dtype=np.float64)
    limit = tuning.alpha_range * DEGREE
    with np.errstate(invalid="ignore"):
        residual = np.where((-limit <= alpha) & (alpha <= limit), alpha - alpha_hat, 0.0)
    count = tuning.n_eval + 1
    past = np.concatenate([np.zeros(tuning.n_eval), residual])
    rms = np.array([np.sqrt(np.mean(past[k : k + count] ** 2)) for k in range(len(residual))])
    return Judged(residual, rms, rms > tuning.alpha_threshold)
