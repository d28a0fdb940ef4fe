"""The recorder's pilot: wings level, altitude, airspeed and pitch held by plain PI and PD loops.

It is no model of a real flight-control law; it only has to fly the commands smoothly in any of the winds. It
takes the true state, so that sensor faults never feed back into the flight (an open loop, unlike the paper's
Fig. 6).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

FT_PER_S_IN_KT = 0.3048 * 3600 / 1852
QBAR_REFERENCE = 250.0  # [psf], about 275 kt: where the gains were chosen; they scale with 1/qbar


@dataclass(frozen=True)
class Command:
    """What is to be flown: altitude [ft], climb [ft/s], calibrated airspeed [kt], added pitch [rad]."""

    altitude_ft: float
    climb_fps: float
    cas_kt: float
    pitch_rad: float


@dataclass(frozen=True)
class Motion:
    """The true motion: angles [rad], rates [rad/s], altitude [ft], climb [ft/s], speeds [kt, ft/s], qbar
    [psf].
    """

    theta: float
    phi: float
    psi: float
    p: float
    q: float
    altitude_ft: float
    climb_fps: float
    cas_kt: float
    cas_rate_kt_s: float
    speed_fps: float
    qbar_psf: float


@dataclass(frozen=True)
class Surfaces:
    """Normalised commands: elevator, aileron (-1 to 1), throttle (0 to 1)."""

    elevator: float
    aileron: float
    throttle: float


class Autopilot:
    """Holds :class:`Command`. ``step`` once a simulation step of ``dt`` [s]; starts from a trimmed
    aircraft.
    """

    def __init__(self, trim: Surfaces, theta_trim: float, psi: float, dt: float) -> None:
        self._trim = trim
        self._psi = psi
        self._dt = dt
        self._theta_ref = theta_trim
        self._theta_cmd = theta_trim
        self._pitch_sum = 0.0
        self._throttle = trim.throttle

    def step(self, command: Command, motion: Motion) -> Surfaces:
        """The surface commands for the next step."""
        return Surfaces(self._elevator(command, motion), self._aileron(motion), self._autothrottle(command, motion))

    def _elevator(self, command: Command, motion: Motion) -> float:
        climb = command.climb_fps + _limit(0.12 * (command.altitude_ft - motion.altitude_ft), 20.0)
        gamma_error = (climb - motion.climb_fps) / motion.speed_fps
        # The slow integral finds the pitch attitude that flies level in this wind and at this speed.
        self._theta_ref += 0.25 * gamma_error * self._dt
        wish = self._theta_ref + 0.8 * gamma_error
        self._theta_cmd += _limit(wish - self._theta_cmd, math.radians(2.0) * self._dt)
        error = self._theta_cmd + command.pitch_rad - motion.theta
        scale = QBAR_REFERENCE / motion.qbar_psf
        self._pitch_sum += 4.0 * error * self._dt
        return _limit(self._trim.elevator - scale * (8.0 * error + self._pitch_sum - 6.0 * motion.q), 1.0)

    def _aileron(self, motion: Motion) -> float:
        drift = math.remainder(self._psi - motion.psi, 2 * math.pi)
        phi_cmd = _limit(0.5 * drift, math.radians(2.0))
        scale = QBAR_REFERENCE / motion.qbar_psf
        return _limit(scale * (1.0 * (phi_cmd - motion.phi) - 1.0 * motion.p), 1.0)

    def _autothrottle(self, command: Command, motion: Motion) -> float:
        error = command.cas_kt - motion.cas_kt
        self._throttle += _limit(0.004 * error - 0.06 * motion.cas_rate_kt_s, 0.06) * self._dt
        self._throttle = min(max(self._throttle, 0.05), 1.0)
        return min(max(self._throttle + 0.01 * error, 0.0), 1.0)


def _limit(value: float, bound: float) -> float:
    return min(max(value, -bound), bound)
