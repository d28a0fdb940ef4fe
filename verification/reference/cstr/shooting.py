"""The cost without estimated noises ("Algorithm 1 No Est", the estimator of the paper's reference [13]).

Only the first state of the window is estimated; the others follow by x_{i+1} = f(x_i, u_i). X bounds the first state;
the others stay in X because f maps into it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from verification.reference.arrays import Array
from verification.reference.cstr.reactor import jacobian, reaction_hessian, trajectory
from verification.reference.cstr.tuning import Tuning
from verification.reference.cstr.window import Information, solution


@dataclass(frozen=True)
class ShootingExpansion:
    """The cost of a window to second order in its first state."""

    x: Array  # (n, 2), the states
    J: float
    gradient: Array  # (2,), of J/2
    gauss_newton: Array  # (2, 2), Hessian of J/2 without second derivatives of the model
    hessian: Array  # (2, 2), of J/2
    Phi: Array  # (n, 2, 2), derivatives of the states by the first one


def shooting_cost(first: Array, given: Information, tuning: Tuning) -> float:
    """Return J of (3), (4) without its second term."""
    v = trajectory(first, given.u, tuning)[:, 1] - given.y
    arrival = first - given.x_bar
    return float(arrival @ tuning.P @ arrival + tuning.R * v @ v)


def expand_shooting(first: Array, given: Information, tuning: Tuning) -> ShootingExpansion:
    """Expand J at the first state: first derivatives forward, second by the multipliers of the transitions."""
    x = trajectory(first, given.u, tuning)
    n = len(x)
    M = [np.eye(2) / tuning.h - jacobian(x[i + 1], given.u[i], tuning) for i in range(n - 1)]
    Phi: list[Array] = [np.eye(2)]
    for M_i in M:
        Phi.append(solution(M_i, Phi[-1]) / tuning.h)
    r = tuning.R * (x[:, 1] - given.y)
    slopes = np.array([phi[1] for phi in Phi])  # of the outputs
    gradient = tuning.P @ (first - given.x_bar) + slopes.T @ r
    gauss_newton = tuning.P + tuning.R * slopes.T @ slopes
    curvature, pull = np.zeros((2, 2)), np.zeros(2)
    for i in range(n - 1, 0, -1):
        # Multiplier of (x_i - x_{i-1})/h = g(x_i, u_{i-1}): stationary in x_i
        pull = solution(M[i - 1].T, pull / tuning.h - np.array([0.0, r[i]]))
        curvature += (pull[0] - pull[1]) * Phi[i].T @ reaction_hessian(x[i], tuning) @ Phi[i]
    v = x[:, 1] - given.y
    arrival = first - given.x_bar
    J = float(arrival @ tuning.P @ arrival + tuning.R * v @ v)
    return ShootingExpansion(x, J, gradient, gauss_newton, gauss_newton + curvature, np.array(Phi))
