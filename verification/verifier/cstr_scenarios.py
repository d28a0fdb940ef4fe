"""Runs of the reactor for the verification of its estimators: closed loops by seed, gaps, outliers, any inputs."""

from __future__ import annotations

import numpy as np

from verification.plants.cstr import STEPS, simulate
from verification.reference.cstr.tuning import Tuning
from verification.verifier.case import Array, Scenario


def reactor_scenarios(frames: int, seed: int) -> tuple[Scenario, ...]:
    """Return runs of at most 251 frames, ``frames`` in total: of every four, two undisturbed, one with gaps and
    outliers in the measured temperature, one with inputs anywhere in and beyond their ranges."""
    return _scenarios(frames, seed, ("closed loop", "gaps and outliers", "any inputs", "closed loop"))


def plausible_scenarios(frames: int, seed: int) -> tuple[Scenario, ...]:
    """Return such runs without any inputs, gaps and temperatures that no reactor has: outliers of 0.6 and 0.9 only.

    Without noises, such samples put a window on the edge of a jump of implicit Euler (its equation
    has three roots there, two of which meet), which multiplies rounding a million times.
    """
    return _scenarios(frames, seed, ("closed loop", "outliers", "closed loop"))


def _scenarios(frames: int, seed: int, kinds: tuple[str, ...]) -> tuple[Scenario, ...]:
    length = STEPS + 1
    count = max(1, -(-frames // length), min(4, frames // 20))
    scenarios, left = [], frames
    for number in range(count):
        rows = -(-left // (count - number))
        left -= rows
        generator = np.random.default_rng([seed, number, 11])
        kind = kinds[number % len(kinds)]
        recording = simulate(int(generator.integers(2**31)), steps=rows).recording
        inputs = {name: column[:rows].copy() for name, column in recording.items()}
        if kind == "gaps and outliers":
            _disturb(inputs["y"], generator, (np.nan, np.inf, -np.inf, 0.0, 0.6, 0.9, 3.0))
        elif kind == "outliers":
            _disturb(inputs["y"], generator, (0.6, 0.9))
        elif kind == "any inputs":
            inputs = _any_inputs(rows, generator)
        scenarios.append(Scenario(f"{kind}, {number + 1}", inputs, fault_free=kind == "closed loop"))
    return tuple(scenarios)


def _disturb(y: Array, generator: np.random.Generator, values: tuple[float, ...]) -> None:
    hit = generator.random(len(y)) < 0.05
    y[hit] = generator.choice(values, size=int(hit.sum()))


def _any_inputs(rows: int, generator: np.random.Generator) -> dict[str, Array]:
    tuning = Tuning()
    y = generator.uniform(tuning.x2_min - 0.1, tuning.x2_max + 0.1, rows)
    u = generator.uniform(-100.0, tuning.u_max + 100.0, rows)
    # Some of them stand still for a while
    hold = np.maximum.accumulate(np.where(generator.random(rows) < 0.4, np.arange(rows), 0))
    return {"y": y[hold], "u": u[hold]}
