"""Every number of paper 003's estimators in one place, with its unit and its source or reason."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from verification.reference.arrays import DEGREE, KNOT, Array
from verification.reference.tuning import quantity

GRAVITY = 9.80665 / KNOT
"""Standard gravity in knots gained per second, which the paper writes kt/s^2: 19.0626."""

PAPER = "paper 003, "
CHOSEN = "chosen: "

Q_V_NOISE = 1.0 / (0.08 * 0.3215) ** 2
"""Q(2) of the noise of Table I, 1511.7 kt^-2: about 93 times less than printed."""

Q_V_PRINTED = 1.41e5
"""Q(2) as printed in section 5.2, kt^-2."""

OBSERVER_GAIN = (
    (-5.098e-06, -0.001282, 0.2621),
    (0.03271, -9.73e-05, -1.448),
    (-4.114e-06, 0.0004079, 0.4139),
)
"""L: rows alpha, V_t, theta, columns V_t, V_z, theta; printed by ``python -m verification.reference.mho.gain``."""


@dataclass(frozen=True)
class MhoTuning:
    """All parameters, in the unit stated. States are in the order (alpha, V_t, theta), outputs (V_t, V_z, theta)."""

    t_s: float = quantity(0.08, "s", PAPER + "5.2")
    N: int = quantity(4, "1", PAPER + "5.2: the horizon of Fig. 8, counted in transitions")

    # M, W and Q of 5.2 from the standard deviations that they are rounded from
    prior_alpha: float = quantity(5.0, "deg", PAPER + "5.2: M(1) = 131.31 is 1/(5 deg)^2")
    prior_v: float = quantity(5.0, "kt", PAPER + "5.2: M(2) = 0.04 is 1/(5 kt)^2")
    prior_theta: float = quantity(5.0, "deg", PAPER + "5.2: M(3) = 131.31 is 1/(5 deg)^2")
    noise_vt: float = quantity(0.7775, "kt", PAPER + "Table I")
    noise_vz: float = quantity(0.5832, "kt", PAPER + "Table I")
    noise_theta: float = quantity(0.1, "deg", PAPER + "Table I, 0.0017 rad; W(3) = 3.28e5 is 1/(0.1 deg)^2")
    noise_q: float = quantity(0.8, "deg/s", PAPER + "Table I, 0.0140 rad/s; Q(1) = Q(3) = 8.01e5 are 1/(t_s 0.8 deg/s)^2")
    q_v: float = quantity(Q_V_NOISE, "1/kt^2", PAPER + "Table I: 1/(t_s 0.3215 kt/s^2)^2; printed 1.41e5")
    L: tuple[tuple[float, ...], ...] = quantity(OBSERVER_GAIN, "1", "computed: python -m verification.reference.mho.gain")

    # Fault detection of Fig. 8
    n_eval: int = quantity(20, "1", PAPER + "5.2: the window [k - N_e, k] has 21 samples")
    alpha_threshold: float = quantity(0.0454, "rad", PAPER + "5.2")

    # Ranges of the inputs; what lies outside is missing
    vt_min: float = quantity(80.0, "kt", CHOSEN + "below any approach speed")
    vt_max: float = quantity(700.0, "kt", CHOSEN + "above cruise in warm air")
    vz_range: float = quantity(200.0, "kt", CHOSEN + "20 000 ft/min")
    theta_range: float = quantity(45.0, "deg", CHOSEN + "an airliner's attitude")
    q_range: float = quantity(1.0, "rad/s", CHOSEN + "an airliner's rate")
    ax_range: float = quantity(20.0, "kt/s^2", CHOSEN + "about 1 g")
    az_min: float = quantity(-70.0, "kt/s^2", CHOSEN + "about 3.7 g upward")
    az_max: float = quantity(30.0, "kt/s^2", CHOSEN + "about 1.6 g downward")
    alpha_range: float = quantity(60.0, "deg", CHOSEN + "a vane's range")

    # What stands in for an input before its first valid value
    vt_nominal: float = quantity(300.0, "kt", CHOSEN + "mid-range")
    theta_nominal: float = quantity(3.0, "deg", CHOSEN + "level flight")
    ax_nominal: float = quantity(1.0, "kt/s^2", CHOSEN + "g sin(theta), level flight")
    az_nominal: float = quantity(-19.04, "kt/s^2", CHOSEN + "-g cos(theta), level flight")

    # Wide limits of the a priori estimate, so that no run diverges for ever
    alpha_limit: float = quantity(45.0, "deg", CHOSEN + "wide; either direction")
    theta_limit: float = quantity(60.0, "deg", CHOSEN + "wide; either direction")
    w_angle_limit: float = quantity(0.2, "rad", CHOSEN + "wide: 2.5 rad/s times t_s")
    w_v_limit: float = quantity(20.0, "kt", CHOSEN + "wide: 13 g times t_s")
    angle_limit: float = quantity(90.0, "deg", CHOSEN + "ends of the sheets' tables of sine and cosine")

    @property
    def M(self) -> Array:
        """Diagonal of the arrival cost's weight, (3,)."""
        return np.array([self.prior_alpha * DEGREE, self.prior_v, self.prior_theta * DEGREE]) ** -2

    @property
    def W(self) -> Array:
        """Diagonal of the outputs' weight, (3,)."""
        return np.array([self.noise_vt, self.noise_vz, self.noise_theta * DEGREE]) ** -2

    @property
    def Q(self) -> Array:
        """Diagonal of the disturbances' weight, (3,)."""
        angle = (self.t_s * self.noise_q * DEGREE) ** -2
        return np.array([angle, self.q_v, angle])

    @property
    def gain(self) -> Array:
        """L, (3, 3)."""
        return np.array(self.L)

    @property
    def input_range(self) -> tuple[Array, Array]:
        """Least and largest valid (vt, vz, theta, q, ax, az) in port units, (6,) each."""
        theta = self.theta_range * DEGREE
        low = [self.vt_min, -self.vz_range, -theta, -self.q_range, -self.ax_range, self.az_min]
        high = [self.vt_max, self.vz_range, theta, self.q_range, self.ax_range, self.az_max]
        return np.array(low), np.array(high)

    @property
    def nominal(self) -> Array:
        """What stands in for (vt, vz, theta, q, ax, az) before the first valid value, (6,)."""
        return np.array([self.vt_nominal, 0.0, self.theta_nominal * DEGREE, 0.0, self.ax_nominal, self.az_nominal])

    @property
    def x_limits(self) -> tuple[Array, Array]:
        """Limits of the a priori estimate, (3,) each."""
        alpha, theta = self.alpha_limit * DEGREE, self.theta_limit * DEGREE
        return np.array([-alpha, self.vt_min, -theta]), np.array([alpha, self.vt_max, theta])

    @property
    def w_limit(self) -> Array:
        """Limit of the disturbances' first guess, either direction, (3,)."""
        return np.array([self.w_angle_limit, self.w_v_limit, self.w_angle_limit])
