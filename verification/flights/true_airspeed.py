"""Flights and sensor readings as paper 003 has them: a true-airspeed sensor, a frame of 0.08 s, no wind.

from verification.flights.true_airspeed import PULLS, load_pulls, readings

truth = load_pulls("a320_pulls_280kt_10000ft")
inputs = readings(truth, seed=1).inputs()          # vt, vz, theta, q, ax, az, alpha

The paper's two scenarios are not published; angle of attack, altitude and A_z change much in them, as in the two
flights here. ``python -m verification.flights.true_airspeed [FOLDER]`` records them anew (extra ``saoflow[flights]``).
"""

from __future__ import annotations

import math
import sys
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from saoflow.diagnosis import unknown_name
from verification.flights.faults import Fault
from verification.flights.plan import AltitudeChange, FlightPlan, PitchDoublet, SpeedChange
from verification.flights.record import record
from verification.flights.sensors import TABLE_I, Noise
from verification.recordings import FOLDER, SUFFIX, read_recording, write_recording
from verification.recordings.recording import Array, Recording

PERIOD = 0.08
"""Frame period [s]: paper 003, section 5.2."""

PULLS: tuple[FlightPlan, ...] = (
    FlightPlan(
        "a320_pulls_280kt_10000ft",
        "A320",
        280.0,
        10000.0,
        100.0,
        (
            PitchDoublet(8.0, 4.0, 6.0),
            AltitudeChange(18.0, 1500.0, 3000.0),
            PitchDoublet(30.0, -5.0, 6.0),
            PitchDoublet(48.0, 5.0, 5.0),
            AltitudeChange(60.0, -2000.0, 3500.0),
            PitchDoublet(85.0, -5.0, 6.0),
        ),
        doc="Pull-ups and push-overs up to 0 and 1.8 g, climb and descent, calm.",
    ),
    FlightPlan(
        "787_pulls_250kt_20000ft",
        "787-8",
        250.0,
        20000.0,
        100.0,
        (
            SpeedChange(5.0, -25.0, 1.0),
            PitchDoublet(10.0, 4.0, 8.0),
            AltitudeChange(25.0, 1500.0, 2000.0),
            PitchDoublet(52.0, -4.0, 8.0),
            AltitudeChange(66.0, -2000.0, 3000.0),
            PitchDoublet(84.0, 4.0, 7.0),
        ),
        doc="Slower, at up to 11 deg angle of attack, climb and descent, calm.",
    ),
)

COLUMNS = ("vt_true", "vz", "theta", "q", "ax", "az", "alpha_true")
"""What such a recording holds besides t; units as in :data:`verification.flights.COLUMNS`."""

PORTS = ("vt", "vz", "theta", "q", "ax", "az", "alpha")
"""The columns of readings, in the order of :data:`COLUMNS`."""

HOME = FOLDER / "true_airspeed"


@dataclass(frozen=True)
class Biases:
    """Constant errors of the measured inputs, added to the noise. Table I has none."""

    ax: float = 0.0  # [kt/s^2]
    az: float = 0.0  # [kt/s^2]
    q: float = 0.0  # [rad/s]


NO_BIASES = Biases()

INPUT_BIASES = Biases(ax=0.4, az=0.4, q=math.radians(0.5))
"""With these the paper's ranking of the EKF shows; they are ours, about as large as the noise."""


def resampled(recording: Recording, period: float = PERIOD) -> Recording:
    """A smooth recording at another frame period [s], by cubic interpolation between four samples.

    Columns :data:`COLUMNS` and t. Every sample that falls on one of the recording's is that one.
    """
    n = len(recording)
    t: Array = np.arange(math.floor((n - 1) * recording.period / period + 1e-9) + 1, dtype=np.float64) * period
    at = t / recording.period
    first = np.clip(np.floor(at).astype(int) - 1, 0, n - 4)
    s = at - first
    # Lagrange's polynomials on 0, 1, 2, 3
    weights = np.array(
        [
            -(s - 1) * (s - 2) * (s - 3) / 6,
            s * (s - 2) * (s - 3) / 2,
            -s * (s - 1) * (s - 3) / 2,
            s * (s - 1) * (s - 2) / 6,
        ]
    )
    nearest = first[:, None] + np.arange(4)
    columns = (np.sum(weights * recording[name][nearest].T, axis=0) for name in COLUMNS)
    return Recording(("t", *COLUMNS), (t, *columns), period)


@dataclass(frozen=True, eq=False)
class Readings:
    """Sensor readings of one flight, one row a frame, beside the truth."""

    truth: Recording
    values: tuple[Array, ...]
    """In the order of :data:`PORTS`: kt, kt, rad, rad/s, kt/s^2, kt/s^2, rad; each (n,)."""

    def inputs(self) -> dict[str, Array]:
        """The readings by port, as simulators take them."""
        return dict(zip(PORTS, self.values, strict=True))


def readings(
    truth: Recording,
    seed: int,
    noise: Noise = TABLE_I,
    biases: Biases = NO_BIASES,
    faults: Iterable[Fault] = (),
) -> Readings:
    """What the sensors of a flight in calm air would have read.

    The same arguments give the same bits; every sensor has a random stream of its own. There is one angle-of-attack
    sensor: ``faults`` act on it whatever sensors they name. Raises DiagnosisError E711 for a fault after the end.
    """
    values: list[Array] = []
    for stream, (column, port) in enumerate(zip(COLUMNS, PORTS, strict=True)):
        # Table I's V_t is what `Noise` has for the calibrated airspeed.
        deviation = noise.vc if port == "vt" else float(getattr(noise, port))
        draw = np.random.default_rng([seed, 3, stream]).standard_normal(len(truth))
        values.append(truth[column] + getattr(biases, port, 0.0) + deviation * draw)
    for number, fault in enumerate(faults, start=1):
        values[-1] = fault.apply(values[-1], truth.period, np.random.default_rng([seed, 3, 100 + number]))
    return Readings(truth, tuple(values))


def load_pulls(name: str) -> Recording:
    """The shipped recording ``name`` of :data:`PULLS`. Raises DiagnosisError E721 (unknown name), E501 (damaged file)."""
    names = [plan.name for plan in PULLS]
    if name not in names:
        message = f"no shipped recording `{name}` with true airspeed"
        raise unknown_name("E721", message, name, names, what="shipped", otherwise="name one of them")
    return read_recording(HOME / f"{name}{SUFFIX}", PERIOD)


def ship(folder: Path) -> None:
    """Records both flights into ``folder``."""
    for plan in PULLS:
        write_recording(resampled(record(plan)), folder / f"{plan.name}{SUFFIX}")


if __name__ == "__main__":
    ship(Path(sys.argv[1]) if len(sys.argv) > 1 else HOME)
