"""Step 0, before the paper's three: which inputs are valid, what replaces the others, when to start.

The paper supposes that every sample arrives. Here an input outside its physical range (NaN and infinity
are) is missing: an inertial one keeps its last valid value and its row of C is masked, an air-data one
leaves the fusion and counts against its sensor.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from verification.reference.arrays import KNOT, Array, Mask
from verification.reference.inputs import Inputs
from verification.reference.tuning import Tuning

SI = np.array([KNOT, KNOT, 1.0, 1.0, KNOT, KNOT, 1.0])
"""From port units to SI, for (vg, vz, theta, q, ax, az, z)."""

PARAMETERS = np.array([0, 2, 3, 4, 5, 6])
"""Where Theta = (V_g,m, theta, q, A_x, A_z, z) of (2) stands among the inertial inputs."""


@dataclass(frozen=True)
class Conditioned:
    """Finite inputs, and what is known of them."""

    sensors: Array  # (2, 3) SI; 0 where invalid
    sensors_valid: Mask  # (2, 3)
    held: Array  # (7,) inertial inputs in port units, the last valid ones
    inertial: Array  # (7,) the same in SI
    inertial_valid: Mask  # (7,)
    inertial_ok: bool  # all seven are valid

    @property
    def theta(self) -> Array:
        """Theta of (2), shape (6,), SI."""
        parameters: Array = self.inertial[PARAMETERS]
        return parameters


def condition(inputs: Inputs, held: Array, tuning: Tuning) -> Conditioned:
    """Return the conditioned inputs; `held` (7,) are the last valid inertial inputs, in port units."""
    low, high = tuning.inertial_range
    inertial_valid: Mask = (low <= inputs.inertial) & (inputs.inertial <= high)
    held = np.where(inertial_valid, inputs.inertial, held)
    low, high = tuning.sensor_range
    sensors_valid: Mask = (low <= inputs.sensors) & (inputs.sensors <= high)
    sensors = np.where(sensors_valid, inputs.sensors, 0.0) * np.array([[1.0], [KNOT]])
    return Conditioned(sensors, sensors_valid, held, held * SI, inertial_valid, bool(inertial_valid.all()))


@dataclass(frozen=True)
class StartUp:
    """Whether the estimator runs, and whether decisions are trusted yet."""

    started: bool
    load: bool  # this frame's inputs fill the estimator's memory
    inhibit: bool  # no residual may be judged in this frame
    inhibit_count: int


def start_up(inputs: Conditioned, started: bool, inhibit_count: int, faulty: Mask, tuning: Tuning) -> StartUp:
    """Decide on starting and on the inhibition of decisions.

    The estimator starts at the first frame with all inertial inputs and an angle of attack to start from,
    or none left to wait for (all three confirmed faulty, `faulty` (2, 3), up to the last frame). At the
    start the wind is unknown: judged at once, 30 kt of steady wind would condemn every airspeed sensor.
    So no residual is judged before the start, while an inertial input is missing, and for n_inhibit frames
    after either.
    """
    any_alpha = bool((inputs.sensors_valid[0] & ~faulty[0]).any()) or bool(faulty[0].all())
    now_started = started or (inputs.inertial_ok and any_alpha)
    reset = not now_started or not inputs.inertial_ok
    counting = inhibit_count > 0
    following = tuning.n_inhibit if reset else max(inhibit_count - 1, 0)
    return StartUp(now_started, load=not started, inhibit=reset or counting, inhibit_count=following)


def first_state(inputs: Conditioned, faulty: Mask) -> Array:
    """Return the state loaded at the start, shape (4,): measured alpha and V_g, no wind.

    Alpha is the mean of the usable sensors. Without any it is theta - V_z/V_g, which (15) gives for small
    angles and no vertical wind.
    """
    usable = inputs.sensors_valid[0] & ~faulty[0]
    v_g, v_z, pitch = inputs.inertial[:3]
    alpha = inputs.sensors[0][usable].mean() if usable.any() else pitch - v_z / v_g
    return np.array([alpha, v_g, 0.0, 0.0])
