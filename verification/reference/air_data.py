"""From true to calibrated airspeed: equation (16) of paper 004.

The constants are those of the International Standard Atmosphere. Printed: L in K/km and R in (m/s)^2 K;
used here: L in K/m and R in (m/s)^2/K.
"""

from __future__ import annotations

import numpy as np

from verification.reference.arrays import Array

GRAVITY = 9.80665  # m/s^2
R_AIR = 287.05287  # (m/s)^2/K
GAMMA = 1.4
T_0 = 288.15  # K
LAPSE = -0.0065  # K/m


def temperature(z: Array) -> Array:
    """Return T = T_0 + L z in K; z is the pressure altitude in m."""
    return T_0 + LAPSE * z


def pressure_ratio(z: Array) -> Array:
    """Return p_bar = (1 + (L/T_0) z)^(g/(-R L)): static pressure over its value at z = 0."""
    ratio: Array = (1.0 + LAPSE / T_0 * z) ** (GRAVITY / (-R_AIR * LAPSE))
    return ratio


def calibrated_airspeed(v_t: Array, z: Array) -> tuple[Array, Array]:
    """Return V_c of (16) and its derivative with respect to V_t.

    Args:
        v_t: true airspeed, m/s, positive.
        z: pressure altitude, m, of the same shape.

    Returns:
        V_c in m/s, and dV_c/dV_t (no unit), as the chain rule through (16) gives it.
    """
    t, p_bar = temperature(z), pressure_ratio(z)
    x = v_t**2 / (5.0 * GAMMA * R_AIR * t)
    impact = ((1.0 + x) ** 3.5 - 1.0) * p_bar
    v_c: Array = np.sqrt(5.0 * GAMMA * R_AIR * T_0 * ((1.0 + impact) ** (1.0 / 3.5) - 1.0))
    slope = T_0 / t * p_bar * (v_t / v_c) * (1.0 + x) ** 2.5 * (1.0 + impact) ** (-2.5 / 3.5)
    return v_c, slope
