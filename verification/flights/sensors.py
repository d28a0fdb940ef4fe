"""Sensor readings from a flight's truth: noise, faults and missing samples, by seed."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, fields, replace

import numpy as np

from saoflow.diagnosis import refusal
from verification.flights.faults import SENSORS, Fault, Missing
from verification.recordings.recording import INERTIAL_INPUTS, Array, Recording


@dataclass(frozen=True)
class Noise:
    """Standard deviations of white Gaussian measurement noise, each sensor and frame on its own.

    The defaults are paper 003, Table I, which gives A_x, A_z, q, V_t, V_z and theta. Assumed where it is
    silent: vc has V_t's (0.4 m/s), for it is what an air-data computer measures; vg 0.2 m/s, half of it, as
    of an inertial system; alpha 0.2 deg, as the paper's weight R_alpha of about (0.2 deg)^2 suggests; z 1 m.
    Raises DiagnosisError E713 for a negative or infinite one.
    """

    alpha: float = math.radians(0.2)  # [rad] assumed
    vc: float = 0.7775  # [kt] V_t of Table I
    vg: float = 0.2 * 3600 / 1852  # [kt] assumed
    vz: float = 0.5832  # [kt] Table I
    theta: float = 0.0017  # [rad] Table I
    q: float = 0.0140  # [rad/s] Table I
    ax: float = 0.3215  # [kt/s^2] Table I
    az: float = 0.3215  # [kt/s^2] Table I
    z: float = 1.0  # [m] assumed

    def __post_init__(self) -> None:
        for field in fields(self):
            value = getattr(self, field.name)
            if not (math.isfinite(value) and value >= 0.0):
                raise refusal(
                    "E713",
                    f"sensor noise: {field.name} = {value}",
                    cause="a standard deviation is 0 or more",
                    remedy="change it",
                )

    def scaled(self, factor: float) -> Noise:
        """All standard deviations times ``factor``."""
        return replace(self, **{field.name: factor * getattr(self, field.name) for field in fields(self)})


TABLE_I = Noise()
"""Paper 003, Table I, completed."""

NO_NOISE = Noise().scaled(0.0)


def sensors(
    recording: Recording,
    seed: int,
    noise: Noise = TABLE_I,
    faults: Iterable[Fault] = (),
    missing: Iterable[Missing] = (),
) -> Recording:
    """What the sensors of the flight would have read.

    Replaces the inertial columns by noisy ones and adds ``alpha_1..3`` [rad] and ``vc_1..3`` [kt] made from
    ``alpha_true`` and ``vc_true``; all other columns stay. The same arguments give the same bits; every
    sensor has a random stream of its own, so adding a fault changes nothing but the sensors it names. Faults
    act in the order given, missing samples last. Raises DiagnosisError E711 or E714 for one that starts
    after the end, E713 for a bad seed.
    """
    if not isinstance(seed, int | np.integer) or seed < 0:
        raise refusal("E713", f"seed {seed}", cause="seeds are whole numbers from 0", remedy="choose another")
    n = len(recording)
    streams = (*INERTIAL_INPUTS, *(f"{sensor}_{i}" for sensor in SENSORS for i in (1, 2, 3)))
    readings: dict[str, Array] = {}
    for stream, column in enumerate(streams):
        quantity = column.rstrip("_123")
        truth = recording[f"{quantity}_true" if quantity in SENSORS else column]
        draw = np.random.default_rng([seed, 0, stream]).standard_normal(n)
        readings[column] = truth + getattr(noise, quantity) * draw
    for number, fault in enumerate(faults, start=1):
        for i in fault.which:
            generator = np.random.default_rng([seed, number, i])
            column = f"{fault.sensor}_{i}"
            readings[column] = fault.apply(readings[column], recording.period, generator)
    for gap in missing:
        for column in gap.columns():
            readings[column] = gap.apply(readings[column], recording.period)
    return recording.with_columns(readings)
