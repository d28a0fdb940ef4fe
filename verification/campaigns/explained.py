"""What an estimator with wind in its state must make of a common fault: how far its prediction follows.

The window of paper 004, (21a), linearised around the truth and without the other measurements: a least-squares problem
that only wind (and, for alpha, the error of alpha) can answer. It is the paper's fault sensitivity of Section IV, (36) and
(39), of the tuning's P, Q and R: no solver, no fusion, no decision. Where the wind that would explain the fault leaves its
bounds, it stays on the bound, and what is left is solved again, as in (37).

Written in errors: an estimate minus the truth. SI.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from verification.recordings.recording import Array
from verification.reference.tuning import Tuning


@dataclass(frozen=True, eq=False)
class Window:
    """Least squares over n samples of d states, the last of them the wind; what every answer is linear in, side by side.

    ``free`` gives the states (n d,) from z = (prior d, measurements n m, model error (n - 1) d); ``others`` and
    ``by_wind`` give the states that are not wind from z and from the n winds when these are kept on their bound.
    """

    n: int
    d: int
    free: Array  # (n d, len(z))
    others: Array  # (n (d - 1), len(z))
    by_wind: Array  # (n (d - 1), n)
    wind_max: float  # m/s


def window(P: Array, Q: Array, R: Array, C: Array, n: int, wind_max: float) -> Window:
    """The window of random walks with arrival cost P (d,), steps Q (d,) and measurements C (m, d) with variances R (m,)."""
    d, m = len(P), len(R)
    H, right = np.zeros((n * d, n * d)), np.zeros((n * d, d + n * m + (n - 1) * d))
    H[:d, :d] = right[:d, :d] = np.diag(1.0 / P)
    for i in range(n):
        now = slice(i * d, (i + 1) * d)
        H[now, now] += C.T @ np.diag(1.0 / R) @ C
        right[now, d + i * m : d + (i + 1) * m] = C.T / R
    for i in range(n - 1):
        G = np.zeros((d, n * d))
        G[:, i * d : (i + 2) * d] = np.hstack([-np.eye(d), np.eye(d)])
        H += G.T @ np.diag(1.0 / Q) @ G
        error = d + n * m + i * d
        right[:, error : error + d] = G.T / Q
    winds = np.arange(n) * d + d - 1
    rest = np.setdiff1d(np.arange(n * d), winds)
    inner = H[np.ix_(rest, rest)]
    free: Array = np.asarray(np.linalg.solve(H, right), dtype=np.float64)
    others: Array = np.asarray(np.linalg.solve(inner, right[rest]), dtype=np.float64)
    by_wind: Array = np.asarray(-np.linalg.solve(inner, H[np.ix_(rest, winds)]), dtype=np.float64)
    return Window(n, d, free, others, by_wind, wind_max)


def airspeed_window(slope: float, tuning: Tuning) -> Window:
    """The window in which W_x answers a common error of V_c; ``slope`` dV_c/dV_t."""
    q, r = tuning.t_s**2 * tuning.q_w, tuning.r_vc / slope**2
    one = np.ones(1)
    return window(tuning.p_w * one, q * one, r * one, np.eye(1), tuning.n_horizon, float(tuning.x_upper[2]))


def alpha_window(v_g: float, tuning: Tuning) -> Window:
    """The window in which W_z, tied to alpha by V_z of (15), answers a common error of alpha; ``v_g`` [m/s]."""
    P = np.array([tuning.p_alpha, tuning.p_w])
    Q = tuning.t_s**2 * np.array([tuning.q_alpha, tuning.q_w])
    R = np.array([tuning.r_alpha, tuning.r_vz])
    C = np.array([[1.0, 0.0], [-v_g, -1.0]])
    return window(P, Q, R, C, tuning.n_horizon, float(tuning.x_upper[3]))


def followed(window: Window, wind: Array, measured: Array, drift: Array) -> Iterator[Array]:
    """The predicted states of every frame, one frame ahead, (d,): errors, but the wind itself for the wind.

    Args:
        window: the window.
        wind: the true wind (frames,), m/s.
        measured: what is measured (frames, m).
        drift: by how much the true first state falls behind its model from the last frame to this one (frames,).
    """
    n, d, m = window.n, window.d, measured.shape[1]
    prior = np.zeros(d)
    prior[-1] = wind[0]
    predicted = prior.copy()
    z = np.zeros(window.free.shape[1])
    start = np.zeros(m)
    start[-1] = measured[0, -1]  # before the first frame all is as at it, without a fault
    z[d : d + n * m] = np.tile(start, n)
    first = d + n * m
    for k in range(len(wind)):
        predicted[0] += drift[k]
        yield predicted
        z[:d] = prior
        z[d : first - m] = z[d + m : first]
        z[first - m : first] = measured[k]
        z[first:-d] = z[first + d :]
        z[-d] = drift[k]
        x = window.free @ z
        winds = x[d - 1 :: d]
        if np.abs(winds).max() > window.wind_max:
            winds = np.clip(winds, -window.wind_max, window.wind_max)
            rest = window.others @ z + window.by_wind @ winds
            x = np.column_stack([rest.reshape(n, d - 1), winds]).ravel()
        prior, predicted = x[d : 2 * d].copy(), x[-d:].copy()
