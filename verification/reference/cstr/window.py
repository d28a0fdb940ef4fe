"""The cost (3) of a window with its quadratic arrival cost (4): value, gradient and Hessian. J/2 throughout.

The estimated noise of a transition is w_i = (x_{i+1} - x_i)/h - g(x_{i+1}, u_i), which is implicit Euler solved for the
noise: no equation has to be solved to evaluate the cost.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from verification.reference.arrays import Array, Mask
from verification.reference.cstr.reactor import jacobian, reaction_hessian, right_hand_side
from verification.reference.cstr.tuning import Tuning


@dataclass(frozen=True)
class Information:
    """What a window is estimated from: x_bar and the information vector (2)."""

    x_bar: Array  # (2,), prediction of the first state
    y: Array  # (n,), outputs
    u: Array  # (n - 1,), inputs


@dataclass(frozen=True)
class Expansion:
    """The cost of a window to second order in the stacked states."""

    J: float
    """The cost itself, not its half."""
    gradient: Array  # (n, 2), of J/2
    gauss_newton: Array  # (2 n, 2 n), Hessian of J/2 without second derivatives of the model; positive definite
    hessian: Array  # (2 n, 2 n), of J/2


def noise(x: Array, u: Array, tuning: Tuning) -> Array:
    """Return the noises w that take the states x (n, 2) from one to the next, shape (n - 1, 2)."""
    moved = [right_hand_side(x[i + 1], u[i], tuning) for i in range(len(u))]
    return np.diff(x, axis=0) / tuning.h - np.reshape(moved, (-1, 2))


def cost(x: Array, given: Information, tuning: Tuning) -> float:
    """Return J of (3), (4)."""
    arrival, w, v = x[0] - given.x_bar, noise(x, given.u, tuning), x[:, 1] - given.y
    return float(arrival @ tuning.P @ arrival + np.sum((w @ tuning.Q) * w) + tuning.R * v @ v)


def expand(x: Array, given: Information, tuning: Tuning) -> Expansion:
    """Expand J at the states x, shape (n, 2), by the Jacobian of all weighted residuals."""
    n = len(x)
    w = noise(x, given.u, tuning)
    weighted = w @ tuning.Q
    rows = np.zeros((2 * n - 2, 2 * n))  # dw/dx
    curvature = np.zeros((2 * n, 2 * n))
    for i in range(n - 1):
        mine, following = slice(2 * i, 2 * i + 2), slice(2 * i + 2, 2 * i + 4)
        rows[mine, mine] = -np.eye(2) / tuning.h
        rows[mine, following] = np.eye(2) / tuning.h - jacobian(x[i + 1], given.u[i], tuning)
        curvature[following, following] = (weighted[i, 0] - weighted[i, 1]) * reaction_hessian(x[i + 1], tuning)
    gradient = (rows.T @ weighted.ravel()).reshape(n, 2)
    gradient[0] += tuning.P @ (x[0] - given.x_bar)
    gradient[:, 1] += tuning.R * (x[:, 1] - given.y)
    normal = rows.T @ np.kron(np.eye(n - 1), tuning.Q) @ rows
    normal[:2, :2] += tuning.P
    normal += np.kron(np.eye(n), np.diag([0.0, tuning.R]))
    return Expansion(cost(x, given, tuning), gradient, normal, normal + curvature)


def held(x: Array, gradient: Array, tuning: Tuning) -> Mask:
    """Return which components are on a bound of X that the cost pushes them against, of the shape of x."""
    pushed: Mask = ((x <= tuning.lower) & (gradient > tuning.push_min)) | ((x >= tuning.upper) & (gradient < -tuning.push_min))
    return pushed


def reduced(matrix: Array, hold: Mask) -> Array:
    """Return the matrix with the rows and columns of held components replaced by those of the identity."""
    free = 1.0 - hold.ravel().astype(np.float64)
    return free[:, None] * matrix * free + np.diag(1.0 - free)


def solution(matrix: Array, rhs: Array) -> Array:
    """Return matrix^-1 rhs."""
    found: Array = np.asarray(np.linalg.solve(matrix, rhs), dtype=np.float64)
    return found


def step_of(matrix: Array, rhs: Array, hold: Mask) -> Array:
    """Solve for a step of the shape of rhs whose held components are zero."""
    free = 1.0 - hold.ravel().astype(np.float64)
    return solution(reduced(matrix, hold), free * rhs.ravel()).reshape(rhs.shape)


def free_gradient(gradient: Array, hold: Mask) -> float:
    """Return the largest magnitude among the free components of the gradient, 0 where none is free."""
    return float(np.max(np.where(hold, 0.0, np.abs(gradient))))
