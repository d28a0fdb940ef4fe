"""Algorithm 1 of paper 003: one real-time iteration of the observer with pre-estimation.

With L = 0 it is the observer without disturbance estimates, (3). The matrices are built as (9) prints them: in every
product of Phi the later factor stands on the left, which the paper does not say. (14) runs to k - 1 (printed: to k).
The step length is 1: `line_search` is the paper's backtracking, and takes 1 in flight.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from verification.reference.arrays import Array
from verification.reference.mho.model import f, f_jacobian, h, h_jacobian
from verification.reference.mho.tuning import MhoTuning
from verification.reference.mho.window import Solution, Window


@dataclass(frozen=True)
class Linearised:
    """(6) to (9) along the pre-estimated states."""

    x_bar: Array  # (N + 1, 3)
    A: Array  # (N, 3, 3)
    C: Array  # (N + 1, 3, 3)
    Phi: Array  # (N, 3, 3)
    mu: Array  # (N, 3)
    tau: Array  # (N + 1, 3)


def estimated(x: Array, window: Window, L: Array, tuning: MhoTuning) -> Array:
    """Return the states from `x` on by (5) and (14), (N + 1, 3)."""
    states = [x]
    for i in range(len(window.u)):
        states.append(f(states[i], window.u[i], tuning) + L @ (window.y[i] - h(states[i], tuning)))
    return np.array(states)


def linearise(window: Window, L: Array, tuning: MhoTuning) -> Linearised:
    """Return step ii-1 of Algorithm 1."""
    x_bar = estimated(window.x_prior, window, L, tuning)  # (5)
    A = np.array([f_jacobian(x, u, tuning) for x, u in zip(x_bar[:-1], window.u, strict=True)])
    C = np.array([h_jacobian(x, tuning) for x in x_bar])
    Phi = A - L @ C[:-1]  # (7)
    mu = np.array([f(x, u, tuning) - a @ x for x, u, a in zip(x_bar[:-1], window.u, A, strict=True)])
    tau = np.array([h(x, tuning) - c @ x for x, c in zip(x_bar, C, strict=True)])
    return Linearised(x_bar, A, C, Phi, mu, tau)


def product(Phi: Array, first: int, last: int) -> Array:
    """Return Phi_last ... Phi_first, (3, 3), later factors on the left; the identity if last < first."""
    result = np.eye(3)
    for j in range(first, last + 1):
        result = Phi[j] @ result
    return result


def stacked_matrices(point: Linearised, L: Array) -> tuple[Array, Array, Array]:
    """Return F_k (3(N+1), 3), G_k (3(N+1), 3(N+1)) and H_k (3(N+1), 3(N+1)) of (9)."""
    n = len(point.C)
    F = np.zeros((3 * n, 3))
    G, H = np.zeros((3 * n, 3 * n)), np.eye(3 * n)
    for i in range(n):
        rows = slice(3 * i, 3 * i + 3)
        F[rows] = point.C[i] @ product(point.Phi, 0, i - 1)
        for j in range(i):
            columns = slice(3 * j, 3 * j + 3)
            G[rows, columns] = point.C[i] @ product(point.Phi, j + 1, i - 1)
            H[rows, columns] = -point.C[i] @ product(point.Phi, j + 1, i - 1) @ L
    return F, G, H


def condensed(window: Window, point: Linearised, L: Array) -> tuple[Array, Array]:
    """Return F_k and sigma_k - F_k x_bar of (11), (3(N+1), 3) and (3(N+1),)."""
    F, G, H = stacked_matrices(point, L)
    mu = np.append(point.mu, np.zeros(3))  # G's last block column is 0
    sigma = H @ window.y.ravel() - G @ mu - H @ point.tau.ravel()  # (8)
    return F, sigma - F @ point.x_bar[0]


def mho_pe(window: Window, tuning: MhoTuning) -> Solution:
    """Run one iteration of MHO-PE."""
    return with_gain(window, tuning.gain, tuning)


def mho_wod(window: Window, tuning: MhoTuning) -> Solution:
    """Run one iteration of MHO-woD, (3): MHO-PE without its observer."""
    return with_gain(window, np.zeros((3, 3)), tuning)


def with_gain(window: Window, L: Array, tuning: MhoTuning) -> Solution:
    """Run Algorithm 1 with the gain `L` (3, 3)."""
    point = linearise(window, L, tuning)  # ii-1
    F, residual = condensed(window, point, L)
    FW = F.T * np.tile(tuning.W, len(window.y))
    p = np.asarray(np.linalg.solve(np.diag(tuning.M) + FW @ F, FW @ residual), dtype=np.float64)  # (12)
    x = estimated(point.x_bar[0] + p, window, L, tuning)  # (13) with step length 1, and (14)
    return Solution(point.x_bar, p, x, np.zeros_like(window.u))
