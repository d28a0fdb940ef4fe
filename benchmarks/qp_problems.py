"""Quadratic programs (42) of paper 004 as the flagship's numpy reference meets them, and as solvers want them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from verification.flights import load_recording, sensors
from verification.reference import cmhe_fte as reference
from verification.reference.inputs import frames
from verification.reference.linearisation import QuadraticProgram
from verification.reference.tuning import Tuning

FIRST, EVERY, LAST = 60, 1, 460
"""Frames taken: after the start has settled."""
ONSET, RATE = 100, 5.0
"""Frame from which all three airspeeds run away together, kt/s: the wind is pulled to its bounds."""


@dataclass(frozen=True, slots=True)
class Dense:
    """min 1/2 s' H s + g' s, ``equal`` s = b, low <= s <= high, low_rows <= rows s <= high_rows; s in widths of bounds."""

    H: np.ndarray
    g: np.ndarray
    equal: np.ndarray
    b: np.ndarray
    low: np.ndarray
    high: np.ndarray
    rows: np.ndarray
    low_rows: np.ndarray
    high_rows: np.ndarray


def flagship_problems(tuning: Tuning) -> tuple[list[QuadraticProgram], list[QuadraticProgram]]:
    """Problems of a flight in turbulence without faults, and of one whose airspeeds run away together."""
    recording = sensors(load_recording("a320_turbulence_280kt_20000ft"), seed=1).inputs()
    faulty = dict(recording)
    time = tuning.t_s * np.maximum(np.arange(len(recording["vc"])) - ONSET, 0)
    faulty["vc"] = recording["vc"] + RATE * time[:, None]
    return _problems(recording, tuning), _problems(faulty, tuning)


def _problems(recording: dict[str, np.ndarray], tuning: Tuning) -> list[QuadraticProgram]:
    found: list[QuadraticProgram] = []
    state = reference.initial_state(tuning)
    for k, inputs in enumerate(frames({name: array[:LAST] for name, array in recording.items()})):
        done = reference.step(state, inputs, tuning)
        state = done.state
        if k >= FIRST and not k % EVERY and bool((done.trace.window.row_mask == 1).all()):
            found.append(done.trace.qp)
    return found


def widths(tuning: Tuning) -> np.ndarray:
    """(20,): of the bounds of dx_l ... dx_k, du_l ... du_(k-1), in which solvers count."""
    x, u = tuning.x_upper - tuning.x_lower, tuning.u_upper - tuning.u_lower
    return np.concatenate([np.tile(x, tuning.n_horizon), np.tile(u, tuning.n_horizon - 1)])


def full(qp: QuadraticProgram, tuning: Tuning) -> Dense:
    """All of dx and du as unknowns, the transitions as equations."""
    n, m = len(qp.x), 4 * len(qp.x)
    size = m + 4 * (n - 1)
    H, g = np.zeros((size, size)), np.zeros(size)
    for i, (C, r) in enumerate(zip(qp.C, qp.r_y, strict=True)):
        at = slice(4 * i, 4 * i + 4)
        H[at, at] = C.T @ (C / tuning.R[:, None])
        g[at] = -C.T @ (r / tuning.R)
    H[:4, :4] += np.diag(1.0 / tuning.P)
    H[m:, m:] = np.diag(np.tile(1.0 / tuning.Q, n - 1))
    g[m:] = -(qp.r_u / tuning.Q).ravel()
    equal = np.zeros((4 * (n - 1), size))
    for i, A in enumerate(qp.A):
        at = slice(4 * i, 4 * i + 4)
        equal[at, 4 * i : 4 * i + 4] = -A
        equal[at, 4 * i + 4 : 4 * i + 8] = np.eye(4)
        equal[at, m + 4 * i : m + 4 * i + 4] = -tuning.t_s * np.eye(4)
    low = np.concatenate([(tuning.x_lower - qp.x).ravel(), (tuning.u_lower - qp.u).ravel()])
    high = np.concatenate([(tuning.x_upper - qp.x).ravel(), (tuning.u_upper - qp.u).ravel()])
    w = widths(tuning)
    per = np.repeat(w[:4], n - 1).reshape(4, n - 1).T.ravel()
    none = np.zeros((0, size)), np.zeros(0), np.zeros(0)
    return Dense(w[:, None] * H * w, w * g, equal * w / per[:, None], qp.f.ravel() / per, low / w, high / w, *none)


def condensed(whole: Dense) -> tuple[Dense, np.ndarray, np.ndarray]:
    """dx_l and du as the only unknowns v: the others follow. Also (T, t) of s = T v + t."""
    size = len(whole.g)
    kept = np.r_[0:4, size - len(whole.b) : size]
    gone = np.setdiff1d(np.arange(size), kept)
    T, t = np.zeros((size, len(kept))), np.zeros(size)
    T[kept, np.arange(len(kept))] = 1.0
    T[gone] = -np.linalg.solve(whole.equal[:, gone], whole.equal[:, kept])
    t[gone] = np.linalg.solve(whole.equal[:, gone], whole.b)
    H = T.T @ whole.H @ T
    none = np.zeros((0, len(kept))), np.zeros(0)
    rows = T[gone], whole.low[gone] - t[gone], whole.high[gone] - t[gone]
    g = T.T @ (whole.g + whole.H @ t)
    return Dense((H + H.T) / 2, g, *none, whole.low[kept], whole.high[kept], *rows), T, t
