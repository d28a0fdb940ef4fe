"""(5) of paper 002 with dense matrices, and a fixed number of active-set passes over its bounds."""

from __future__ import annotations

import numpy as np

from verification.reference.double_mhe.model import Array, LinearModel, Window
from verification.reference.double_mhe.tuning import Tuning, Weights


def residuals(model: LinearModel, window: Window, weights: Weights) -> tuple[Array, Array]:
    """G and g with cost |G X - g|^2: the terms of (4a) one below the other, each over the root of R.

    The weights of the second stage are 1e-4 and 1e-5; divided by R the cost is of the size of 1.
    """
    n = len(window.y)
    p, q = np.sqrt(weights.p / weights.r), np.sqrt(weights.q / weights.r)
    arrival = np.zeros((1, n))
    arrival[0, 0] = p
    move = np.zeros((n - 1, n))
    move[:, 1:] += q * np.eye(n - 1)
    move[:, :-1] -= q * np.diag(model.a)
    left = np.vstack([arrival, move, np.diag(model.c)])
    return left, np.concatenate([[p * window.s], q * model.b, window.y - model.d])


def hessian_and_gradient(model: LinearModel, window: Window, weights: Weights) -> tuple[Array, Array]:
    """H and F/2 of (5), over R: the cost is X'HX + F'X + E. Printed is 1/2 X'HX, with these same H and F."""
    left, right = residuals(model, window, weights)
    return left.T @ left, -left.T @ right


def active_set(h: Array, half_f: Array, tuning: Tuning) -> Array:
    """Minimise X'HX + F'X with bounds: a fixed number of primal-dual active-set passes (Hintermueller et al., 2003)."""
    n = len(half_f)
    at_low, at_high = np.zeros(n, bool), np.zeros(n, bool)
    x = np.zeros(n)
    for _ in range(tuning.passes):
        held = at_low | at_high
        free = ~held
        x = np.where(at_high, tuning.high, tuning.low)
        if free.any():
            x[free] = np.linalg.solve(h[np.ix_(free, free)], -half_f[free] - h[np.ix_(free, held)] @ x[held])
        pull = -half_f - h @ x
        at_high, at_low = (
            (free & (x > tuning.high)) | (at_high & (pull > 0.0)),
            (free & (x < tuning.low)) | (at_low & (pull < 0.0)),
        )
    return np.clip(x, tuning.low, tuning.high)


def estimate(model: LinearModel, window: Window, weights: Weights, tuning: Tuning) -> Array:
    """The estimates of the window's samples, (n,)."""
    return active_set(*hessian_and_gradient(model, window, weights), tuning)
