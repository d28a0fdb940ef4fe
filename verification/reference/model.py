"""The aerodynamics-independent model: equations (11), (13) to (16), (20) and (23) of paper 004.

State x = (alpha, V_g, W_x, W_z), unknown input u = (u_alpha, u_v, u_wx, u_wz), outputs y = (V_g, V_z,
alpha, V_c), parameter Theta = (V_g,m, theta, q, A_x, A_z, z); SI. W_x is positive from the tail, W_z
positive down, V_z positive up. Every function takes one sample or a stack of them (leading axes).

Remark 1 of the paper: V_g,m, not the state V_g, stands in (11), (15), (16) and (20a).
"""

from __future__ import annotations

import numpy as np

from verification.reference.air_data import GRAVITY, calibrated_airspeed
from verification.reference.arrays import DEGREE, Array, saturate
from verification.reference.tuning import Tuning


def specific_forces(x: Array, theta: Array, tuning: Tuning) -> tuple[Array, Array]:
    """Return f_alpha and f_v, the functions below (9), in m/s^2."""
    limit = tuning.angle_limit * DEGREE
    alpha = saturate(x[..., 0], -limit, limit)
    path = saturate(x[..., 0] - theta[..., 1], -limit, limit)
    a_x, a_z = theta[..., 3], theta[..., 4]
    sin, cos = np.sin(alpha), np.cos(alpha)
    f_alpha = -a_x * sin + a_z * cos + GRAVITY * np.cos(path)
    f_v = a_x * cos + a_z * sin + GRAVITY * np.sin(path)
    return f_alpha, f_v


def transition(x: Array, u: Array, theta: Array, tuning: Tuning) -> Array:
    """Return F(x, u, Theta), the right-hand sides of (20a) to (20c), shape (..., 4)."""
    f_alpha, f_v = specific_forces(x, theta, tuning)
    v_gm, q = theta[..., 0], theta[..., 2]
    rates = u.copy()
    rates[..., 0] += f_alpha / v_gm + q  # (13)
    rates[..., 1] += f_v  # (14)
    following: Array = x + tuning.t_s * rates
    return following


def transition_jacobian(x: Array, theta: Array, tuning: Tuning) -> Array:
    """Return A of (23), shape (..., 4, 4): a12 = 0 by Remark 1. B is t_s times the identity."""
    f_alpha, f_v = specific_forces(x, theta, tuning)
    a = np.zeros((*x.shape, 4))
    a[..., range(4), range(4)] = 1.0
    a[..., 0, 0] -= tuning.t_s * f_v / theta[..., 0]  # d f_alpha/d alpha = -f_v
    a[..., 1, 0] = tuning.t_s * f_alpha  # d f_v/d alpha = f_alpha
    return a


def output(x: Array, theta: Array, tuning: Tuning) -> tuple[Array, Array]:
    """Return y = h(x, Theta) of (20d), shape (..., 4), and its Jacobian C of (23), shape (..., 4, 4).

    The vertical speed is (15) with -W_z: W_z is positive down in (5) to (11), V_z positive up.
    """
    limit = tuning.angle_limit * DEGREE
    path = saturate(x[..., 0] - theta[..., 1], -limit, limit)
    sin, cos = np.sin(path), np.cos(path)
    v_gm, w_x, w_z = theta[..., 0], x[..., 2], x[..., 3]

    v_t = saturate(v_gm - w_x * cos - w_z * sin, tuning.vt_min, tuning.vt_max)  # (11)
    v_c, slope = calibrated_airspeed(v_t, theta[..., 5])  # (16)
    y = np.stack([x[..., 1], -v_gm * sin - w_z, x[..., 0], v_c], axis=-1)

    c = np.zeros((*x.shape, 4))
    c[..., 0, 1] = 1.0
    c[..., 1, 0] = -v_gm * cos
    c[..., 1, 3] = -1.0
    c[..., 2, 0] = 1.0
    c[..., 3, 0] = slope * (w_x * sin - w_z * cos)
    c[..., 3, 2] = -slope * cos
    c[..., 3, 3] = -slope * sin
    return y, c
