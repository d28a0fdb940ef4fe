"""Runs of paper 003's estimators for their verification: parts of its flights, with noise, biases, faults and gaps."""

from __future__ import annotations

import numpy as np

from verification.flights.faults import Fault
from verification.flights.true_airspeed import INPUT_BIASES, NO_BIASES, PORTS, PULLS, load_pulls, readings
from verification.reference.arrays import DEGREE, Array
from verification.reference.mho.tuning import MhoTuning
from verification.verifier.case import Scenario

LENGTH = 400
"""About how many frames a run has (32 s)."""

KINDS = ("fault-free", "input biases", "gaps", "runaway", "edges of the ranges", "oscillation")
"""In this order, over and over."""


def mho_scenarios(frames: int, seed: int) -> tuple[Scenario, ...]:
    """Runs of ``frames`` frames in total, on both flights in turn."""
    generator = np.random.default_rng([seed, 30])
    count = max(1, round(frames / LENGTH), min(len(KINDS), frames // 60))
    found = []
    for i in range(count):
        length = frames // count + (i < frames % count)
        kind = KINDS[i % len(KINDS)]
        if kind == "edges of the ranges":
            found.append(Scenario(kind, edges(length, generator)))
            continue
        name = PULLS[(i + i // len(KINDS)) % len(PULLS)].name
        found.append(_flight(kind, name, length, generator))
    return tuple(found)


def _flight(kind: str, name: str, length: int, generator: np.random.Generator) -> Scenario:
    truth = load_pulls(name)
    length = min(length, len(truth))
    start = int(generator.integers(len(truth) - length + 1))
    onset = (start + 0.3 * length) * truth.period
    faults = {
        "runaway": (Fault("runaway", "alpha", (1,), rate=1.0, onset=onset),),
        "oscillation": (Fault("oscillation", "alpha", (1,), amplitude=5.0, frequency=0.5, onset=onset),),
    }
    biases = INPUT_BIASES if kind == "input biases" else NO_BIASES
    read = readings(truth, int(generator.integers(2**31)), biases=biases, faults=faults.get(kind, ())).inputs()
    part = {port: values[start : start + length] for port, values in read.items()}
    if kind == "gaps":
        for _ in range(8):
            first = int(generator.integers(length))
            port = PORTS[int(generator.integers(len(PORTS)))]
            part[port][first : first + int(generator.integers(1, 30))] = generator.choice([np.nan, np.inf, -np.inf])
    # Noise, biases and gaps are no matter for the tables: every run has to stay near the reference.
    return Scenario(f"{kind}: {name}", part, fault_free=True, first_frame=start)


def edges(length: int, generator: np.random.Generator) -> dict[str, Array]:
    """No flight: inputs drawn anew in every frame from their ranges, one of them just inside or outside an end.

    In the first frames all inputs are missing, so that what stands in for them is seen.
    """
    tuning = MhoTuning()
    alpha = tuning.alpha_range * DEGREE
    low, high = (np.append(ends, end) for ends, end in zip(tuning.input_range, (-alpha, alpha), strict=True))
    values = generator.uniform(low, high, (length, len(low)))
    for k in range(length):
        side, i = divmod(k % (4 * len(low)), len(low))
        beside = 1e-9 * (high[i] - low[i]) * (-1.0 if side & 1 else 1.0)
        values[k, i] = (high[i] if side & 2 else low[i]) + beside
    values[:3] = np.nan
    return dict(zip(PORTS, values.T, strict=True))
