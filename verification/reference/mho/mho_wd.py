"""One real-time iteration of the observer with disturbance estimates, (2) of paper 003, in condensed form.

The states are eliminated by forward prediction; unknown are the first state and all disturbances. The linear
least-squares problem is solved densely, from its whitened Jacobian. Correction: the first guess of the disturbances is
w_k-N|k-1 ... w_k-2|k-1, 0; the paper's w_k-1|k-1 does not exist.
"""

from __future__ import annotations

import numpy as np

from verification.reference.arrays import Array
from verification.reference.mho.model import f, f_jacobian, h, h_jacobian
from verification.reference.mho.tuning import MhoTuning
from verification.reference.mho.window import Solution, Window


def predicted(x: Array, w: Array, window: Window, tuning: MhoTuning) -> Array:
    """Return the states from `x` on with the disturbances `w` (N, 3), (N + 1, 3)."""
    states = [x]
    for i, w_i in enumerate(w):
        states.append(f(states[i], window.u[i], tuning) + w_i)
    return np.array(states)


def whitened(window: Window, x_bar: Array, tuning: MhoTuning) -> tuple[Array, Array]:
    """Return the Jacobian and the residual of (2) at the first guess, in standard deviations.

    Columns are (p, delta w_k-N ... delta w_k-1); rows arrival cost, disturbances, outputs: both have 3 + 3N + 3(N+1).
    """
    N = len(window.u)
    size = 3 + 3 * N
    sensitivity = np.eye(3, size)  # d x_i / d (p, delta w)
    rows, residuals = [], []
    for i in range(N + 1):
        rows.append(np.sqrt(tuning.W)[:, None] * (h_jacobian(x_bar[i], tuning) @ sensitivity))
        residuals.append(np.sqrt(tuning.W) * (window.y[i] - h(x_bar[i], tuning)))
        if i < N:
            sensitivity = f_jacobian(x_bar[i], window.u[i], tuning) @ sensitivity
            sensitivity[:, 3 + 3 * i : 6 + 3 * i] += np.eye(3)
    weights = np.sqrt(np.concatenate([tuning.M, np.tile(tuning.Q, N)]))
    first = np.concatenate([np.zeros(3), -window.w_prior.ravel()])
    return np.concatenate([np.diag(weights), *rows]), np.concatenate([weights * first, *residuals])


def mho_wd(window: Window, tuning: MhoTuning) -> Solution:
    """Run one iteration of MHO-wD."""
    x_bar = predicted(window.x_prior, window.w_prior, window, tuning)
    jacobian, residual = whitened(window, x_bar, tuning)
    scale = np.linalg.norm(jacobian, axis=0)
    step = np.linalg.lstsq(jacobian / scale, residual, rcond=None)[0] / scale
    p, w = step[:3], window.w_prior + step[3:].reshape(-1, 3)
    return Solution(x_bar, p, predicted(window.x_prior + p, w, window, tuning), w)
