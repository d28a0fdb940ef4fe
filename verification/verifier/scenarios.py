"""Runs of the estimator for its verification: parts of the shipped flights, with noise, faults and gaps by seed."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from verification.flights import KINDS, Fault, Missing, Recording, load_recording, random_fault, sensors
from verification.flights import shipped_recordings as names_of_recordings
from verification.reference.inputs import INERTIAL
from verification.reference.tuning import Tuning
from verification.verifier.case import Scenario

LENGTH = 400
"""About how many frames a run has (19.2 s)."""

SHORTEST = 120
"""With fewer frames a run would hardly see its fault: decisions are inhibited in the first 50."""

INPUTS = ("vg", "vz", "theta", "q", "ax", "az", "z", "alpha", "vc")

Events = tuple[tuple[Fault, ...], tuple[Missing, ...]]


def _no_fault(generator: np.random.Generator, onset: float, seconds: float) -> Events:
    return (), ()


def _vc_lost(generator: np.random.Generator, onset: float, seconds: float) -> Events:
    """All airspeed sensors run away together: configuration III, and the wind at its bound on the way."""
    # At the paper's 15 kt/s, or faster in a short run, so that the wind's bound of 60 kt is passed half-way.
    rate = max(15.0, 80.0 / (0.5 * (seconds - onset)))
    return (Fault("runaway", "vc", rate=rate * float(generator.choice([-1.0, 1.0])), onset=onset),), ()


def _alpha_lost(generator: np.random.Generator, onset: float, seconds: float) -> Events:
    return (Fault("runaway", "alpha", rate=float(generator.choice([-8.0, 8.0])), onset=onset),), ()


def _both_lost(generator: np.random.Generator, onset: float, seconds: float) -> Events:
    """Configuration IV: a large bias on every alpha sensor, then a runaway of every airspeed sensor."""
    runaway = _vc_lost(generator, onset + 0.2 * (seconds - onset), seconds)[0]
    return (Fault("bias", "alpha", amplitude=12.0, onset=onset), *runaway), ()


def _some_sensors(generator: np.random.Generator, onset: float, seconds: float) -> Events:
    """A fault of Table II, anywhere in its range, on one or two sensors of each kind."""
    faults = []
    for sensor in ("alpha", "vc"):
        which = tuple(sorted(int(i) for i in generator.permutation([1, 2, 3])[: generator.integers(1, 3)]))
        kind = KINDS[generator.integers(len(KINDS))]
        faults.append(random_fault(int(generator.integers(2**31)), kind, sensor, which, onset))
    return tuple(faults), ()


def _gaps(generator: np.random.Generator, onset: float, seconds: float) -> Events:
    """Missing samples, five times: any inputs, NaN or infinite, for 1 to 60 frames.

    With a kind of air-data sensor among them for 1 to 4: missing for n_D frames they would be faulty for good.
    """
    gaps = []
    for start in np.sort(generator.uniform(0.0, 0.8 * seconds, 5)):
        names = tuple(str(n) for n in generator.permutation(INPUTS)[: generator.integers(1, len(INPUTS))])
        longest = 4.9 if {"alpha", "vc"} & set(names) else 60.0
        frames = int(math.exp(generator.uniform(0.0, math.log(longest))))
        gaps.append(Missing(names, float(start), frames, str(generator.choice(["nan", "inf", "-inf"]))))
    return (), tuple(gaps)


def _faults_and_gaps(generator: np.random.Generator, onset: float, seconds: float) -> Events:
    return _vc_lost(generator, onset, seconds)[0], _gaps(generator, onset, seconds)[1]


Maker = Callable[[np.random.Generator, float, float], Events]

KINDS_OF_RUN: tuple[tuple[str, Maker | None], ...] = (
    ("fault-free", _no_fault),
    ("vc lost", _vc_lost),
    ("edges of the ranges", None),
    ("both lost", _both_lost),
    ("gaps", _gaps),
    ("fault-free", _no_fault),
    ("alpha lost", _alpha_lost),
    ("fault-free", _no_fault),
    ("some sensors", _some_sensors),
    ("vc lost, gaps", _faults_and_gaps),
)
"""In this order, over and over. None: no flight, but :func:`edge_frames`."""


def flight_scenarios(frames: int, seed: int) -> tuple[Scenario, ...]:
    """Runs of ``frames`` frames in total, on all shipped recordings in turn, fault-free and faulty."""
    generator = np.random.default_rng([seed, 20190])
    count = max(1, min(round(frames / LENGTH), frames // SHORTEST), min(5, frames // SHORTEST))
    names = names_of_recordings()
    first = int(generator.integers(len(names)))
    scenarios = []
    for i in range(count):
        length = frames // count + (i < frames % count)
        kind, make = KINDS_OF_RUN[i % len(KINDS_OF_RUN)]
        # One recording on at every run and one more at every round: each kind meets each recording.
        name = names[(first + i + i // len(KINDS_OF_RUN)) % len(names)]
        if make is None:
            scenarios.append(edge_frames(length, generator))
        else:
            scenarios.append(_scenario(f"{kind}: {name}", name, make, length, generator))
    return tuple(scenarios)


def edge_frames(length: int, generator: np.random.Generator) -> Scenario:
    """No flight: inputs drawn anew in every frame from their ranges, one of them just inside or outside an end.

    Input, end and side change from frame to frame: 52 frames have them all. In the first frames all inputs are missing,
    so that what stands in for them is seen.
    """
    tuning = Tuning()
    low = np.concatenate([tuning.inertial_range[0], np.repeat(tuning.sensor_range[0], 3)])
    high = np.concatenate([tuning.inertial_range[1], np.repeat(tuning.sensor_range[1], 3)])
    values = generator.uniform(low, high, (length, len(low)))
    for k in range(length):
        side, i = divmod(k % (4 * len(low)), len(low))
        beside = 1e-9 * (high[i] - low[i]) * (-1.0 if side & 1 else 1.0)
        values[k, i] = (high[i] if side & 2 else low[i]) + beside
    values[:3] = np.nan
    inputs = dict(zip(INERTIAL, values.T, strict=False)) | {"alpha": values[:, 7:10], "vc": values[:, 10:]}
    return Scenario("edges of the ranges", inputs)


def _scenario(title: str, name: str, make: Maker, length: int, generator: np.random.Generator) -> Scenario:
    recording = load_recording(name)
    length = min(length, len(recording))
    start = int(generator.integers(len(recording) - length + 1))
    part = _rows(recording, start, start + length)
    seconds = length * part.period
    # Soon after decisions are allowed (2.4 s), so that most of the run is faulty.
    onset = min(3.0 + float(generator.uniform(0.0, 1.0)), 0.5 * seconds)
    faults, gaps = make(generator, onset, seconds)
    read = sensors(part, int(generator.integers(2**31)), faults=faults, missing=gaps)
    return Scenario(title, read.inputs(), fault_free=make is _no_fault, first_frame=start)


def _rows(recording: Recording, start: int, stop: int) -> Recording:
    return Recording(recording.names, tuple(c[start:stop] for c in recording.columns), recording.period)
