"""Independent solutions of paper 003's problems: casadi's derivatives, dense KKT systems, IPOPT."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache

import casadi as ca
import numpy as np

from verification.flights.true_airspeed import Biases, load_pulls, readings
from verification.reference.mho import estimator
from verification.reference.mho.estimator import Method, Step
from verification.reference.mho.tuning import MhoTuning
from verification.reference.mho.window import Window

TUNING = MhoTuning()
SIGMA_X = np.array([1e-3, 0.5, 1e-3])
"""Scales of the state: rad, kt, rad."""


@dataclass(frozen=True)
class SymbolicModel:
    f: ca.Function
    h: ca.Function
    A: ca.Function
    C: ca.Function


@cache
def symbolic_model(t_s: float) -> SymbolicModel:
    """The equations below (44) written down once more, with casadi's derivatives."""
    x, u = ca.SX.sym("x", 3), ca.SX.sym("u", 3)
    alpha, v, theta = x[0], x[1], x[2]
    a_x, a_z, q = u[0], u[1], u[2]
    g = 9.80665 * 3600 / 1852
    rate = ca.vertcat(
        1 / v * (-a_x * ca.sin(alpha) + a_z * ca.cos(alpha) + g * ca.cos(alpha - theta)) + q,
        a_x * ca.cos(alpha) + a_z * ca.sin(alpha) + g * ca.sin(alpha - theta),
        q,
    )
    f = x + t_s * rate
    h_ = ca.vertcat(v, -v * ca.sin(alpha - theta), theta)
    return SymbolicModel(
        ca.Function("f", [x, u], [f]),
        ca.Function("h", [x], [h_]),
        ca.Function("A", [x, u], [ca.jacobian(f, x)]),
        ca.Function("C", [x], [ca.jacobian(h_, x)]),
    )


def numbers(value: ca.DM) -> np.ndarray:
    return np.array(value, dtype=float)


def sparse_step(window: Window, x_bar: np.ndarray, L: np.ndarray, disturbed: bool, tuning: MhoTuning) -> tuple:
    """The Gauss-Newton step of (2) or (4) with all states kept: the dense KKT system with the constraints (6).

    Unknown are dx_k-N ... dx_k, and with ``disturbed`` dw_k-N ... dw_k-1; multipliers of the constraints. Returns dx
    (N + 1, 3) and dw (N, 3).
    """
    model, N = symbolic_model(tuning.t_s), len(window.u)
    M, W, Q = (np.diag(d) for d in (tuning.M, tuning.W, tuning.Q))
    n_x, n_w = 3 * (N + 1), 3 * N if disturbed else 0
    H, g = np.zeros((n_x + n_w, n_x + n_w)), np.zeros(n_x + n_w)
    E = np.zeros((3 * N, n_x + n_w))
    H[:3, :3] += M
    for i in range(N + 1):
        at = slice(3 * i, 3 * i + 3)
        C = numbers(model.C(x_bar[i]))
        e = window.y[i] - numbers(model.h(x_bar[i])).ravel()
        H[at, at] += C.T @ W @ C
        g[at] -= C.T @ W @ e
        if i < N:
            Phi = numbers(model.A(x_bar[i], window.u[i])) - L @ C
            E[at, at], E[at, 3 * i + 3 : 3 * i + 6] = -Phi, np.eye(3)
            if disturbed:
                of_w = slice(n_x + 3 * i, n_x + 3 * i + 3)
                H[of_w, of_w], E[at, of_w] = Q, -np.eye(3)
                g[of_w] = Q @ window.w_prior[i]
    scale = 1 / np.sqrt(np.diag(H) + 1e-12)  # so that the dense solution loses few digits
    H, g, E = H * np.outer(scale, scale), g * scale, E * scale
    kkt = np.block([[H, E.T], [E, np.zeros((3 * N, 3 * N))]])
    z = np.linalg.solve(kkt, np.concatenate([-g, np.zeros(3 * N)]))[: n_x + n_w] * scale
    return z[:n_x].reshape(-1, 3), z[n_x:].reshape(-1, 3)


def ipopt(window: Window, L: np.ndarray, disturbed: bool, tuning: MhoTuning) -> np.ndarray:
    """The states (N + 1, 3) that minimise (2) or (4) exactly, by IPOPT."""
    model, N = symbolic_model(tuning.t_s), len(window.u)
    x0, w = ca.SX.sym("x0", 3), ca.SX.sym("w", 3, N)
    x, states = window.x_prior + x0 * SIGMA_X, []
    cost = ca.dot(x0**2, tuning.M * SIGMA_X**2)
    for i in range(N + 1):
        states.append(x)
        e = window.y[i] - model.h(x)
        cost += ca.dot(e**2, tuning.W)
        if i < N:
            x = model.f(x, window.u[i]) + L @ e
            if disturbed:
                x += w[:, i] * SIGMA_X
                cost += ca.dot(w[:, i] ** 2, tuning.Q * SIGMA_X**2)
    unknown = ca.vertcat(x0, ca.vec(w)) if disturbed else x0
    options = {"print_time": 0, "ipopt": {"print_level": 0, "sb": "yes", "tol": 1e-11}}
    solver = ca.nlpsol("window", "ipopt", {"x": unknown, "f": cost}, options)
    best = solver(x0=np.zeros(unknown.shape[0]))["x"]
    trajectory = ca.Function("trajectory", [unknown], [ca.horzcat(*states)])
    return numbers(trajectory(best)).T


@cache
def flight_steps(name: str, method: Method, N: int, seed: int = 1, frames: int = 60, skip: int = 100) -> tuple[Step, ...]:
    """Frames of a flight with noise and input biases."""
    truth = load_pulls(name)
    rows = readings(truth, seed, biases=Biases(ax=0.4, az=0.4, q=0.01)).inputs()
    part = {port: values[skip : skip + frames] for port, values in rows.items()}
    return tuple(estimator.steps(part, replace(TUNING, N=N), method))
