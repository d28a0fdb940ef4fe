"""The backtracking line search of step ii-2: Algorithm 3.1 of Nocedal and Wright, Numerical Optimization, 2nd edition.

The estimators take the step length 1. `step_length` says what the search would have taken.
"""

from __future__ import annotations

import numpy as np

from verification.reference.arrays import Array
from verification.reference.mho.mho_pe import condensed, estimated, linearise
from verification.reference.mho.model import h
from verification.reference.mho.tuning import MhoTuning
from verification.reference.mho.window import Window

SUFFICIENT = 1e-4
"""c of the condition of sufficient decrease."""

CONTRACTION = 0.5
"""rho, by which the step length shrinks."""

SHORTEST = 2.0**-20
"""Where the search gives up."""


def cost(x: Array, window: Window, L: Array, tuning: MhoTuning) -> float:
    """Return J_k of (4) at x_k-N = `x`."""
    states = estimated(x, window, L, tuning)
    errors = window.y - np.array([h(state, tuning) for state in states])
    return float(tuning.M @ (x - window.x_prior) ** 2 + np.sum(errors**2 @ tuning.W))


def step_length(window: Window, L: Array, tuning: MhoTuning, p: Array) -> float:
    """Return the step length alpha_k along `p` (3,); 0 if none in 1, 1/2, ... SHORTEST decreases (4) enough."""
    F, residual = condensed(window, linearise(window, L, tuning), L)
    slope = -2.0 * float(residual * np.tile(tuning.W, len(window.y)) @ F @ p)  # at p = 0 the arrival cost is flat
    start = cost(window.x_prior, window, L, tuning)
    length = 1.0
    while length >= SHORTEST:
        if cost(window.x_prior + length * p, window, L, tuning) <= start + SUFFICIENT * length * slope:
            return length
        length *= CONTRACTION
    return 0.0
