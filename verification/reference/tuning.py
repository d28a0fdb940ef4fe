"""Every number of the estimator in one place, with its unit and its source or reason.

The paper gives few of them: N, N_eval, n_kappa, n_QP, the thresholds, p_w and q_w. The others are this
project's choice; `docs/corrections.md` says what the paper leaves open.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from verification.reference.arrays import DEGREE, KNOT, Array


def quantity(value: Any, unit: str, source: str) -> Any:
    """Return a dataclass field with default `value`, and its unit and source as metadata."""
    return field(default=value, metadata={"unit": unit, "source": source})


def count(value: int, source: str) -> Any:
    """Return a dataclass field for a number of frames, sensors or iterations."""
    return field(default=value, metadata={"unit": "1", "source": source})


PAPER = "paper 004, "
CHOSEN = "chosen: "


@dataclass(frozen=True)
class Tuning:
    """All parameters of CMHE-FTE, UMHE-FTE and EKF-FTE. `dataclasses.fields(Tuning)` carries unit and source of each.

    Scalars are in the unit stated; the properties below assemble them into SI arrays. States are in the
    order (alpha, V_g, W_x, W_z), outputs in the order (V_g, V_z, alpha, V_c).
    """

    # Time and lengths
    t_s: float = quantity(0.048, "s", PAPER + "VI-A: 370 samples in 17.76 s")
    n_horizon: int = count(3, PAPER + "V-C: N = 3, counted in samples")
    n_eval: int = count(10, PAPER + "V-C: N_eval")
    n_detect: int = count(5, CHOSEN + "n_D, half of N_eval")
    n_inhibit: int = count(50, CHOSEN + "2.4 s, the time the wind estimate needs to settle from zero")

    # Thresholds and the fusion
    alpha_threshold: float = quantity(2.9, "deg", PAPER + "VI-B: J_alpha,th")
    vc_threshold: float = quantity(12.0, "kt", PAPER + "VI-B: J_vc,th")
    alpha_floor: float = quantity(0.05, "deg", CHOSEN + "half the sensor noise; (19) divides by J^2")
    vc_floor: float = quantity(0.25, "kt", CHOSEN + "half the sensor noise; (19) divides by J^2")

    # Doubt, where the sensors of a kind disagree
    alpha_split: float = quantity(1.0, "deg", CHOSEN + "five times the sensor noise; agreeing sensors are nearer")
    vc_split: float = quantity(4.0, "kt", CHOSEN + "five times the sensor noise; agreeing sensors are nearer")
    doubt: float = quantity(0.8, "1", CHOSEN + "docs/detection.md; 0: as in the paper, no sensor is ever in doubt")
    doubt_limit: float = quantity(2.5, "1", CHOSEN + "docs/detection.md; times the threshold")

    # P, Q, R of (21a), (22)
    p_alpha: float = quantity(1e-6, "rad^2", CHOSEN + "smaller than R_alpha, as VI-A advises; see q_alpha")
    p_v: float = quantity(0.01, "m^2/s^2", CHOSEN + "smaller than R_vg, as VI-A advises")
    p_w: float = quantity(0.01, "m^2/s^2", PAPER + "Fig. 4, read in (m/s)^2")
    q_alpha: float = quantity(2e-4, "rad^2/s^2", CHOSEN + "(0.014 rad/s)^2, the noise of q in paper 003")
    q_v: float = quantity(0.09, "m^2/s^4", CHOSEN + "(0.3 m/s^2)^2")
    q_w: float = quantity(1.0, "m^2/s^4", PAPER + "Fig. 4, read in (m/s^2)^2")
    r_vg: float = quantity(0.04, "m^2/s^2", CHOSEN + "(0.2 m/s)^2")
    r_vz: float = quantity(0.20, "m^2/s^2", CHOSEN + "(0.45 m/s)^2")
    r_alpha: float = quantity(1.2e-5, "rad^2", CHOSEN + "(0.2 deg)^2")
    r_vc: float = quantity(0.16, "m^2/s^2", CHOSEN + "(0.4 m/s)^2")

    # Bounds of (21b)
    alpha_min: float = quantity(-15.0, "deg", CHOSEN + "beyond any normal flight")
    alpha_max: float = quantity(30.0, "deg", CHOSEN + "beyond the stall")
    vg_min: float = quantity(50.0, "m/s", CHOSEN + "below any approach speed")
    vg_max: float = quantity(350.0, "m/s", CHOSEN + "cruise in a jet stream")
    wx_max: float = quantity(60.0, "kt", CHOSEN + "the assumed weather; lower bound is -wx_max")
    wz_max: float = quantity(30.0, "kt", CHOSEN + "the assumed weather; lower bound is -wz_max")
    u_alpha_max: float = quantity(0.2, "rad/s", CHOSEN + "model error of (20a)")
    u_v_max: float = quantity(10.0, "m/s^2", CHOSEN + "model error of (20b)")
    u_w_max: float = quantity(15.0, "kt/s", PAPER + "VI-B: wind accelerations below 15 kt/s")

    # Algorithm 1
    kappa_init: float = quantity(1.0, "1", CHOSEN + "the barrier is weak against P away from a bound")
    kappa_factor: float = quantity(0.1, "1", PAPER + "Algorithm 1")
    n_kappa: int = count(2, PAPER + "V-C")
    n_qp: int = count(2, PAPER + "V-C")
    n_s_max: int = count(8, CHOSEN + "shortest step 1/256; at least 2")
    clip_margin: float = quantity(1e-3, "width", CHOSEN + "the warm start is clipped this far inside a bound")
    distance_floor: float = quantity(1e-9, "width", CHOSEN + "so that rounding on a bound makes no infinity")

    # Ranges of the input conditioning, closed, in the units of the ports
    alpha_valid: float = quantity(60.0, "deg", CHOSEN + "a vane's range, either side")
    vc_valid_min: float = quantity(20.0, "kt", CHOSEN + "an air data computer's range")
    vc_valid_max: float = quantity(600.0, "kt", CHOSEN + "an air data computer's range")
    vg_valid_min: float = quantity(100.0, "kt", CHOSEN + "airborne; inside the bounds of V_g")
    vg_valid_max: float = quantity(680.0, "kt", CHOSEN + "inside the bounds of V_g")
    vz_valid: float = quantity(200.0, "kt", CHOSEN + "20 000 ft/min, either direction")
    theta_valid: float = quantity(45.0, "deg", CHOSEN + "either direction")
    q_valid: float = quantity(1.0, "rad/s", CHOSEN + "either direction")
    ax_valid: float = quantity(20.0, "kt/s^2", CHOSEN + "about 1 g, either direction")
    az_valid_min: float = quantity(-70.0, "kt/s^2", CHOSEN + "about 3.7 g upward")
    az_valid_max: float = quantity(30.0, "kt/s^2", CHOSEN + "about 1.6 g downward")
    z_valid_min: float = quantity(-500.0, "m", CHOSEN + "the lowest airports, low pressure")
    z_valid_max: float = quantity(13000.0, "m", CHOSEN + "an airliner's ceiling")

    # What stands in for an inertial input before its first valid value
    vg_nominal: float = quantity(300.0, "kt", CHOSEN + "mid-range")
    vz_nominal: float = quantity(0.0, "kt", CHOSEN + "level flight")
    theta_nominal: float = quantity(3.0, "deg", CHOSEN + "level flight")
    q_nominal: float = quantity(0.0, "rad/s", CHOSEN + "level flight")
    ax_nominal: float = quantity(1.0, "kt/s^2", CHOSEN + "g sin(theta), level flight")
    az_nominal: float = quantity(-19.04, "kt/s^2", CHOSEN + "-g cos(theta), level flight")
    z_nominal: float = quantity(3000.0, "m", CHOSEN + "mid-range")

    # Ranges of function arguments (the tables of the sheets have them too)
    angle_limit: float = quantity(90.0, "deg", CHOSEN + "arguments alpha and alpha - theta, either side")
    vt_min: float = quantity(30.0, "m/s", CHOSEN + "true airspeed before (16)")
    vt_max: float = quantity(400.0, "m/s", CHOSEN + "true airspeed before (16)")

    # UMHE has no bounds; these wide limits of its warm start keep a diverging run finite
    umhe_alpha_max: float = quantity(45.0, "deg", CHOSEN + "either side")
    umhe_vg_min: float = quantity(10.0, "m/s", CHOSEN + "never met by a valid V_g")
    umhe_vg_max: float = quantity(700.0, "m/s", CHOSEN + "never met by a valid V_g")
    umhe_w_max: float = quantity(250.0, "m/s", CHOSEN + "room for Fig. 4, where W_x takes in the whole fault")
    umhe_u_factor: float = quantity(50.0, "1", CHOSEN + "times the bounds of u")

    # EKF-FTE has UMHE's limits, and one of the covariance
    ekf_p_factor: float = quantity(1e6, "1", CHOSEN + "times P; a larger variance starts the covariance anew")

    # Bounds of the outputs
    vc_out_max: float = quantity(800.0, "kt", CHOSEN + "V_c(vt_max) at sea level; lower bound 0")
    umhe_w_out_max: float = quantity(500.0, "kt", CHOSEN + "above umhe_w_max, either direction")
    alpha_rms_max: float = quantity(180.0, "deg", CHOSEN + "above any difference of valid values")
    vc_rms_max: float = quantity(1000.0, "kt", CHOSEN + "above any difference of valid values")

    @cached_property
    def P(self) -> Array:
        """Diagonal of P in (22), shape (4,)."""
        return np.array([self.p_alpha, self.p_v, self.p_w, self.p_w])

    @cached_property
    def Q(self) -> Array:
        """Diagonal of Q in (22), shape (4,)."""
        return np.array([self.q_alpha, self.q_v, self.q_w, self.q_w])

    @cached_property
    def R(self) -> Array:
        """Diagonal of R in (22), shape (4,): the printed R has three entries, y has four."""
        return np.array([self.r_vg, self.r_vz, self.r_alpha, self.r_vc])

    @cached_property
    def x_lower(self) -> Array:
        """Lower bound of x in (21b), shape (4,), SI."""
        return np.array([self.alpha_min * DEGREE, self.vg_min, -self.wx_max * KNOT, -self.wz_max * KNOT])

    @cached_property
    def x_upper(self) -> Array:
        """Upper bound of x in (21b), shape (4,), SI."""
        return np.array([self.alpha_max * DEGREE, self.vg_max, self.wx_max * KNOT, self.wz_max * KNOT])

    @cached_property
    def u_upper(self) -> Array:
        """Upper bound of u in (21b), shape (4,), SI."""
        return np.array([self.u_alpha_max, self.u_v_max, self.u_w_max * KNOT, self.u_w_max * KNOT])

    @cached_property
    def u_lower(self) -> Array:
        """Lower bound of u in (21b), shape (4,), SI."""
        return -self.u_upper

    @cached_property
    def umhe_x_upper(self) -> Array:
        """Upper limit of UMHE's warm start of x, shape (4,), SI."""
        return np.array([self.umhe_alpha_max * DEGREE, self.umhe_vg_max, self.umhe_w_max, self.umhe_w_max])

    @cached_property
    def umhe_x_lower(self) -> Array:
        """Lower limit of UMHE's warm start of x, shape (4,), SI."""
        return np.array([-self.umhe_alpha_max * DEGREE, self.umhe_vg_min, -self.umhe_w_max, -self.umhe_w_max])

    @cached_property
    def umhe_u_upper(self) -> Array:
        """Upper limit of UMHE's warm start of u, shape (4,), SI; the lower limit is its negative."""
        return self.umhe_u_factor * self.u_upper

    @cached_property
    def threshold(self) -> Array:
        """J_th of alpha and V_c, shape (2, 1), SI."""
        return np.array([[self.alpha_threshold * DEGREE], [self.vc_threshold * KNOT]])

    @cached_property
    def split(self) -> Array:
        """Largest difference between alpha or V_c sensors that agree, shape (2,), SI."""
        return np.array([self.alpha_split * DEGREE, self.vc_split * KNOT])

    @cached_property
    def floor(self) -> Array:
        """J_floor of alpha and V_c, shape (2, 1), SI."""
        return np.array([[self.alpha_floor * DEGREE], [self.vc_floor * KNOT]])

    @cached_property
    def sensor_range(self) -> Array:
        """Closed validity range of the alpha and V_c sensors, shape (2 limits, 2, 1), rad and kt."""
        alpha = self.alpha_valid * DEGREE
        return np.array([[[-alpha], [self.vc_valid_min]], [[alpha], [self.vc_valid_max]]])

    @cached_property
    def inertial_range(self) -> Array:
        """Closed validity range of (vg, vz, theta, q, ax, az, z), shape (2 limits, 7), port units."""
        theta = self.theta_valid * DEGREE
        lower = [self.vg_valid_min, -self.vz_valid, -theta, -self.q_valid]
        upper = [self.vg_valid_max, self.vz_valid, theta, self.q_valid]
        lower += [-self.ax_valid, self.az_valid_min, self.z_valid_min]
        upper += [self.ax_valid, self.az_valid_max, self.z_valid_max]
        return np.array([lower, upper])

    @cached_property
    def inertial_nominal(self) -> Array:
        """What stands in for (vg, vz, theta, q, ax, az, z) before a valid value, shape (7,), port units."""
        theta = self.theta_nominal * DEGREE
        speeds = [self.vg_nominal, self.vz_nominal]
        return np.array([*speeds, theta, self.q_nominal, self.ax_nominal, self.az_nominal, self.z_nominal])
