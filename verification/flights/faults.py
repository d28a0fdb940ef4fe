"""The sensor faults of Table II of paper 004, and missing samples.

A fault acts on the reading of a sensor (truth plus noise), from its onset to the end of the recording.
Readings are not limited to what a real sensor could give: a runaway airspeed may go below zero.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from saoflow.diagnosis import did_you_mean, refusal
from verification.recordings.recording import INERTIAL_INPUTS, Array

KINDS = ("oscillation", "jamming", "bias", "runaway", "non_return_to_zero", "noise")
SENSORS = ("alpha", "vc")
UNIT_IN_RECORDING = {"alpha": math.pi / 180.0, "vc": 1.0}
"""Factor from a fault's unit (deg, kt) to the recording's (rad, kt)."""

TABLE_II: tuple[tuple[str, str, str, float, float], ...] = (
    ("oscillation", "alpha", "amplitude", 0.5, 25.0),
    ("oscillation", "alpha", "frequency", 0.5, 1.0),
    ("oscillation", "vc", "amplitude", 10.0, 200.0),
    ("oscillation", "vc", "frequency", 0.5, 4.0),
    ("jamming", "alpha", "amplitude", 0.5, 25.0),
    ("jamming", "vc", "amplitude", 10.0, 200.0),
    ("bias", "alpha", "amplitude", 0.5, 25.0),
    ("bias", "vc", "amplitude", 10.0, 200.0),
    ("runaway", "alpha", "rate", 0.2, 25.0),
    ("runaway", "vc", "rate", 0.5, 50.0),
    ("non_return_to_zero", "alpha", "amplitude", 0.1, 0.1),
    ("non_return_to_zero", "vc", "amplitude", 0.1, 0.1),
    ("noise", "alpha", "amplitude", 1.0, 2.0),
    ("noise", "vc", "amplitude", 10.0, 20.0),
)
"""Paper 004, Table II: kind, sensor, field of :class:`Fault`, lowest, highest; deg, kt, deg/s, kt/s, Hz."""


@dataclass(frozen=True)
class Fault:
    """One fault on one, two or three sensors of a kind. Paper 004, Table II.

    ``sensor`` "alpha" or "vc"; ``which`` of 1, 2, 3; ``onset`` [s] from the first frame. By ``kind``, with r
    the reading without the fault (noise included), s the time since onset:

    - ``bias``: r + amplitude [deg or kt, signed];
    - ``runaway``: r + rate s [deg/s or kt/s, signed];
    - ``oscillation``: r + amplitude sin(2 pi frequency s) [deg or kt, Hz];
    - ``jamming``: stuck at the reading of the onset frame + amplitude [deg or kt, signed; 0: stuck where it
      is]. The paper gives an amplitude and no reference for it; a sensor stuck away from its last value is
      our reading;
    - ``non_return_to_zero``: amplitude times r [1, default 0.1]. The paper says "10 % x current value"; read
      here as: the reading falls to 10 % of the value, and does not reach zero. Amplitude 1.1 is the other
      reading (10 % added);
    - ``noise``: r + white noise of standard deviation ``amplitude`` [deg or kt], drawn by the seed of
      ``sensors``.

    Raises DiagnosisError E711 for anything else.
    """

    kind: str
    sensor: str
    which: tuple[int, ...] = (1, 2, 3)
    amplitude: float | None = None
    rate: float | None = None
    frequency: float | None = None
    onset: float = 20.0

    def __post_init__(self) -> None:
        if self.kind not in KINDS:
            self._refuse(
                f"no fault kind `{self.kind}`",
                f"kinds are {', '.join(KINDS)}",
                did_you_mean(self.kind, KINDS),
            )
        if self.sensor not in SENSORS:
            self._refuse(f"no sensor `{self.sensor}`", "sensors are alpha and vc", did_you_mean(self.sensor, SENSORS))
        object.__setattr__(self, "which", tuple(self.which))
        if not self.which or len(set(self.which)) != len(self.which) or not set(self.which) <= {1, 2, 3}:
            self._refuse(f"sensors {self.which}", "they are numbered 1, 2, 3; name at least one, each once")
        if self.kind == "non_return_to_zero" and self.amplitude is None:
            object.__setattr__(self, "amplitude", 0.1)
        needed = {"runaway": ("rate",), "oscillation": ("amplitude", "frequency")}.get(self.kind, ("amplitude",))
        for name in ("amplitude", "rate", "frequency"):
            value = getattr(self, name)
            if (value is not None) != (name in needed):
                self._refuse(
                    f"{self.kind} {'without' if value is None else 'with'} {name}",
                    f"{self.kind} takes {' and '.join(needed)}",
                )
            if value is not None and not math.isfinite(value):
                self._refuse(f"{name} = {value}", "it must be finite")
        if self.frequency is not None and self.frequency <= 0.0:
            self._refuse(f"frequency = {self.frequency}", "it must be above 0 Hz")
        if self.kind == "noise" and self.amplitude is not None and self.amplitude < 0.0:
            self._refuse(f"amplitude = {self.amplitude}", "a standard deviation is not negative")
        if not (math.isfinite(self.onset) and self.onset >= 0.0):
            self._refuse(f"onset = {self.onset}", "it must be 0 s or later")

    def _refuse(self, what: str, cause: str, near: str = "") -> None:
        remedy = near or "see Fault in verification.flights, or `saoflow fly --help`"
        raise refusal("E711", f"fault: {what}", cause=cause, remedy=remedy)

    def onset_frame(self, period: float) -> int:
        """Index of the first faulty frame: the first at or after the onset."""
        return math.ceil(self.onset / period - 1e-9)

    def apply(self, reading: Array, period: float, generator: np.random.Generator) -> Array:
        """``reading`` (n,) [rad or kt] with the fault; ``generator`` feeds the noise fault alone."""
        first = self.onset_frame(period)
        if first >= len(reading):
            self._refuse(f"onset = {self.onset:g} s", f"the recording ends at {(len(reading) - 1) * period:g} s")
        faulty = reading.copy()
        healthy = reading[first:]
        s = np.arange(len(reading) - first) * period + (first * period - self.onset)
        unit = UNIT_IN_RECORDING[self.sensor]
        amplitude, rate = self.amplitude or 0.0, self.rate or 0.0
        if self.kind == "bias":
            faulty[first:] = healthy + amplitude * unit
        elif self.kind == "runaway":
            faulty[first:] = healthy + rate * unit * s
        elif self.kind == "oscillation":
            faulty[first:] = healthy + amplitude * unit * np.sin(2 * np.pi * (self.frequency or 0.0) * s)
        elif self.kind == "jamming":
            faulty[first:] = healthy[0] + amplitude * unit
        elif self.kind == "non_return_to_zero":
            faulty[first:] = amplitude * healthy
        else:
            faulty[first:] = healthy + amplitude * unit * generator.standard_normal(len(healthy))
        return faulty


def table_ii_levels(kind: str, sensor: str) -> tuple[Fault, Fault, Fault]:
    """The fault at the low, the (geometrically) middle and the high end of its range in Table II, all
    sensors.
    """
    rows = [row for row in TABLE_II if row[:2] == (kind, sensor)]
    levels = []
    for share in (0.0, 0.5, 1.0):
        values = {field: low * (high / low) ** share for _, _, field, low, high in rows}
        levels.append(Fault(kind, sensor, **values))
    return levels[0], levels[1], levels[2]


def random_fault(seed: int, kind: str, sensor: str, which: tuple[int, ...] = (1, 2, 3), onset: float = 20.0) -> Fault:
    """A fault drawn by ``seed`` from its range in Table II, log-uniform, of random sign where it has one."""
    generator = np.random.default_rng([seed, KINDS.index(kind), SENSORS.index(sensor)])
    values: dict[str, float] = {}
    for _, _, field, low, high in (row for row in TABLE_II if row[:2] == (kind, sensor)):
        value = low * (high / low) ** generator.random()
        if field != "frequency" and kind in ("jamming", "bias", "runaway") and generator.random() < 0.5:
            value = -value
        values[field] = float(value)
    return Fault(kind, sensor, which, onset=onset, **values)


MISSING_VALUES = {"nan": math.nan, "inf": math.inf, "-inf": -math.inf}


@dataclass(frozen=True)
class Missing:
    """Missing samples: ``inputs`` read ``value`` ("nan", "inf", "-inf") for ``frames`` frames from ``onset``
    [s].

    ``inputs``: any of vg, vz, theta, q, ax, az, z, alpha, vc (all three sensors), alpha_1 ... vc_3.
    Raises DiagnosisError E714.
    """

    inputs: tuple[str, ...]
    onset: float
    frames: int
    value: str = "nan"

    def __post_init__(self) -> None:
        known = (*INERTIAL_INPUTS, *SENSORS, *(f"{sensor}_{i}" for sensor in SENSORS for i in (1, 2, 3)))
        object.__setattr__(self, "inputs", tuple(self.inputs))
        for name in self.inputs:
            if name not in known:
                self._refuse(f"no input `{name}`", f"inputs are {', '.join(known)}", did_you_mean(name, known))
        if not self.inputs:
            self._refuse("no inputs", "name at least one")
        if self.value not in MISSING_VALUES:
            self._refuse(f"value `{self.value}`", "a missing sample reads nan, inf or -inf")
        if self.frames < 1:
            self._refuse(f"{self.frames} frames", "at least 1")
        if not (math.isfinite(self.onset) and self.onset >= 0.0):
            self._refuse(f"onset = {self.onset}", "it must be 0 s or later")

    def _refuse(self, what: str, cause: str, near: str = "") -> None:
        raise refusal("E714", f"missing samples: {what}", cause=cause, remedy=near or "change it")

    def columns(self) -> tuple[str, ...]:
        """The columns concerned: alpha and vc stand for three each."""
        return tuple(
            column
            for name in self.inputs
            for column in ([f"{name}_{i}" for i in (1, 2, 3)] if name in SENSORS else [name])
        )

    def apply(self, reading: Array, period: float) -> Array:
        """``reading`` (n,) with the samples missing."""
        first = math.ceil(self.onset / period - 1e-9)
        if first >= len(reading):
            self._refuse(f"onset = {self.onset:g} s", f"the recording ends at {(len(reading) - 1) * period:g} s")
        gappy = reading.copy()
        gappy[first : first + self.frames] = MISSING_VALUES[self.value]
        return gappy
