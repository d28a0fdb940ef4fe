"""The aerodynamics-independent longitudinal model of paper 003, section 5.1, and its Jacobians.

State x = (alpha, V_t, theta), input u = (A_x, A_z, q), output y = (V_t, V_z, theta); rad, kt, s. A_x and A_z are
specific forces (the paper calls them load factors) in knots gained per second. V_z is positive up.
"""

from __future__ import annotations

import numpy as np

from verification.reference.arrays import DEGREE, Array, saturate
from verification.reference.mho.tuning import GRAVITY, MhoTuning


def _angles(x: Array, tuning: MhoTuning) -> tuple[float, float]:
    """Return alpha and alpha - theta, inside the ends of the tables that the sheets have."""
    limit = tuning.angle_limit * DEGREE
    alpha, path = saturate(np.array([x[0], x[0] - x[2]]), -limit, limit)
    return float(alpha), float(path)


def specific_forces(x: Array, u: Array, tuning: MhoTuning) -> tuple[float, float]:
    """Return the braces of the equations of alpha and V_t below (44), in kt/s."""
    alpha, path = _angles(x, tuning)
    a_x, a_z = u[0], u[1]
    f_alpha = -a_x * np.sin(alpha) + a_z * np.cos(alpha) + GRAVITY * np.cos(path)
    f_v = a_x * np.cos(alpha) + a_z * np.sin(alpha) + GRAVITY * np.sin(path)
    return float(f_alpha), float(f_v)


def f(x: Array, u: Array, tuning: MhoTuning) -> Array:
    """Return f(x, u) of (1), (3,): one Euler step of (44) without noise."""
    f_alpha, f_v = specific_forces(x, u, tuning)
    return x + tuning.t_s * np.array([f_alpha / x[1] + u[2], f_v, u[2]])


def f_jacobian(x: Array, u: Array, tuning: MhoTuning) -> Array:
    """Return A = df/dx, (3, 3)."""
    f_alpha, f_v = specific_forces(x, u, tuning)
    _, path = _angles(x, tuning)
    g_sin, g_cos = GRAVITY * np.sin(path), GRAVITY * np.cos(path)
    rate = np.array(
        [
            [-f_v / x[1], -f_alpha / x[1] ** 2, g_sin / x[1]],  # d f_alpha/d alpha = -f_v
            [f_alpha, 0.0, -g_cos],  # d f_v/d alpha = f_alpha
            [0.0, 0.0, 0.0],
        ]
    )
    jacobian: Array = np.eye(3) + tuning.t_s * rate
    return jacobian


def h(x: Array, tuning: MhoTuning) -> Array:
    """Return h(x), (3,)."""
    _, path = _angles(x, tuning)
    return np.array([x[1], -x[1] * np.sin(path), x[2]])


def h_jacobian(x: Array, tuning: MhoTuning) -> Array:
    """Return C = dh/dx, (3, 3)."""
    _, path = _angles(x, tuning)
    v_cos = x[1] * np.cos(path)
    return np.array([[0.0, 1.0, 0.0], [-v_cos, -np.sin(path), v_cos], [0.0, 0.0, 1.0]])


def first_state(y: Array) -> Array:
    """Return the state that a run starts from, (3,): the measured V_t and theta, and alpha = theta - V_z/V_t.

    The paper leaves the start open. alpha is that of h for small angles.
    """
    return np.array([y[2] - y[1] / y[0], y[0], y[2]])
