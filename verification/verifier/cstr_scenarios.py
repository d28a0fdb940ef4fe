"""Runs of the reactor for the verification of its estimators: closed loops by seed, gaps, outliers, any inputs."""

from __future__ import annotations

import numpy as np

from verification.plants.cstr import STEPS, simulate
from verification.reference.cstr.tuning import Tuning
from verification.verifier.case import Array, Scenario


def reactor_scenarios(frames: int, seed: int) -> tuple[Scenario, ...]:
    """Return runs of at most 251 frames, ``frames`` in total: of every four, two undisturbed, one with gaps and
    outliers in the measured temperature, one with inputs anywhere in and beyond their ranges."""
    length = STEPS + 1
    count = max(1, -(-frames // length), min(4, frames // 20))
    scenarios, left = [], frames
    for number in range(count):
        rows = -(-left // (count - number))
        left -= rows
        generator = np.random.default_rng([seed, number, 11])
        kind = ("closed loop", "gaps and outliers", "any inputs", "closed loop")[number % 4]
        recording = simulate(int(generator.integers(2**31)), steps=rows).recording
        inputs = {name: column[:rows].copy() for name, column in recording.items()}
        if kind == "gaps and outliers":
            _disturb(inputs["y"], generator)
        elif kind == "any inputs":
            inputs = _any_inputs(rows, generator)
        scenarios.append(Scenario(f"{kind}, {number + 1}", inputs, fault_free=kind == "closed loop"))
    return tuple(scenarios)


def _disturb(y: Array, generator: np.random.Generator) -> None:
    hit = generator.random(len(y)) < 0.05
    y[hit] = generator.choice([np.nan, np.inf, -np.inf, 0.0, 0.6, 0.9, 3.0], size=int(hit.sum()))


def _any_inputs(rows: int, generator: np.random.Generator) -> dict[str, Array]:
    tuning = Tuning()
    y = generator.uniform(tuning.x2_min - 0.1, tuning.x2_max + 0.1, rows)
    u = generator.uniform(-100.0, tuning.u_max + 100.0, rows)
    # Some of them stand still for a while
    hold = np.maximum.accumulate(np.where(generator.random(rows) < 0.4, np.arange(rows), 0))
    return {"y": y[hold], "u": u[hold]}
