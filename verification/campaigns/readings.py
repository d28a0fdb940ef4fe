"""The sensor readings of a chunk of runs, stacked: the bits of `verification.flights.sensors`, run by run."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from verification.campaigns.cases import Case
from verification.flights.faults import SENSORS
from verification.flights.sensors import TABLE_I, Noise
from verification.recordings.recording import INERTIAL_INPUTS, Array, Recording


@dataclass(frozen=True, eq=False)
class Flight:
    """A run with the truth of the part that it flies."""

    case: Case
    name: str
    aircraft: str
    start: int
    truth: Recording


def stacked_readings(flights: Sequence[Flight], noise: Noise = TABLE_I) -> dict[str, Array]:
    """Inputs of a batch: ``alpha``, ``vc`` (flights, frames, 3), the others (flights, frames).

    A shorter flight repeats its last frame. Raises DiagnosisError E711 for a fault that starts after the end.
    """
    frames = max(len(flight.truth) for flight in flights)
    inputs: dict[str, Array] = {name: np.empty((len(flights), frames)) for name in INERTIAL_INPUTS}
    inputs |= {sensor: np.empty((len(flights), frames, 3)) for sensor in SENSORS}
    for row, flight in enumerate(flights):
        for name, column in _readings(flight, noise).items():
            sensor, _, number = name.partition("_")
            target = inputs[sensor][row] if not number else inputs[sensor][row, :, int(number) - 1]
            target[: len(column)] = column
            target[len(column) :] = column[-1]
    return inputs


def _readings(flight: Flight, noise: Noise) -> dict[str, Array]:
    """As `sensors` makes them, without the checks and copies of a recording."""
    truth, n = flight.truth, len(flight.truth)
    streams = (*INERTIAL_INPUTS, *(f"{sensor}_{i}" for sensor in SENSORS for i in (1, 2, 3)))
    readings: dict[str, Array] = {}
    for stream, column in enumerate(streams):
        quantity = column.partition("_")[0]
        draw = np.random.default_rng([flight.case.seed, 0, stream]).standard_normal(n)
        draw *= getattr(noise, quantity)
        draw += truth[f"{quantity}_true" if quantity in SENSORS else column]
        readings[column] = draw
    for number, fault in enumerate(flight.case.faults, start=1):
        for i in fault.which:
            generator = np.random.default_rng([flight.case.seed, number, i])
            column = f"{fault.sensor}_{i}"
            readings[column] = fault.apply(readings[column], truth.period, generator)
    return readings
