"""The reactor of paper 001, Section V: its right-hand sides, their derivatives, and one step of implicit Euler.

Corrected: the signs of both right-hand sides (the printed ones are those of reversed time), alpha and theta. The step:
x+ = x + h (g(x+, u) + w), where the noise w acts inside the right-hand sides, as the paper prints it.
"""

from __future__ import annotations

import math

import numpy as np

from verification.reference.arrays import Array
from verification.reference.cstr.tuning import Tuning


def limited(value: float, low: float, high: float) -> float:
    """Return the value limited to [low, high]; NaN comes out as `low`."""
    return low if not value > low else min(value, high)


def rate_constant(x2: float, tuning: Tuning) -> tuple[float, float, float]:
    """Return k = k_0 exp(-E_a/x2) and its first two derivatives; x2 is limited to the temperatures of X."""
    T = limited(x2, tuning.x2_min, tuning.x2_max)
    k = tuning.k_0 * math.exp(-tuning.E_a / T)
    slope = tuning.E_a / T**2
    return k, k * slope, k * slope * (slope - 2.0 / T)


def right_hand_side(x: Array, u: float, tuning: Tuning) -> Array:
    """Return g(x, u) = dx/dtau without noise, shape (2,)."""
    reaction = rate_constant(x[1], tuning)[0] * x[0]
    cooling = tuning.alpha * u * (x[1] - tuning.x_cw)
    return np.array([(1.0 - x[0]) / tuning.theta - reaction, (tuning.x_f - x[1]) / tuning.theta + reaction - cooling])


def jacobian(x: Array, u: float, tuning: Tuning) -> Array:
    """Return dg/dx, shape (2, 2)."""
    k, k_T, _ = rate_constant(x[1], tuning)
    leak = 1.0 / tuning.theta
    return np.array([[-leak - k, -k_T * x[0]], [k, -leak + k_T * x[0] - tuning.alpha * u]])


def reaction_hessian(x: Array, tuning: Tuning) -> Array:
    """Return the second derivatives of the reaction k(x2) x1, shape (2, 2): those of g_2, and of -g_1."""
    _, k_T, k_TT = rate_constant(x[1], tuning)
    return np.array([[0.0, k_T], [k_T, x[0] * k_TT]])


def step(x: Array, u: float, tuning: Tuning, w: Array | None = None, passes: int | None = None) -> Array:
    """Return f(x, u): one step of implicit Euler with n_f passes of Newton's method, shape (2,).

    The concentration follows from the temperature z, which solves a z - h k(z) x1(z) = b; it starts at the present
    temperature and stays in X.
    """
    h, leak = tuning.h, 1.0 + tuning.h / tuning.theta
    x1, x2 = (float(x_j) for x_j in (x if w is None else x + h * w))
    a = leak + h * tuning.alpha * u
    b = x2 + h * (tuning.x_f / tuning.theta + tuning.alpha * u * tuning.x_cw)
    inflow = x1 + h / tuning.theta
    z = limited(x2, tuning.x2_min, tuning.x2_max)
    for _ in range(tuning.n_f if passes is None else passes):
        k, k_T, _ = rate_constant(z, tuning)
        burnt = inflow / (leak + h * k)
        slope = a - h * k_T * burnt * leak / (leak + h * k)
        off = a * z - h * k * burnt - b
        before, z = z, limited(z - off / slope if slope else math.nan, tuning.x2_min, tuning.x2_max)
        if z == before:
            break  # no later pass would change a bit
    return np.array([inflow / (leak + h * rate_constant(z, tuning)[0]), z])


def trajectory(x: Array, u: Array, tuning: Tuning) -> Array:
    """Return x, f(x, u_0), f(f(x, u_0), u_1), ..., shape (len(u) + 1, 2)."""
    states = [x]
    for flow in u:
        states.append(step(states[-1], float(flow), tuning))
    return np.array(states)
