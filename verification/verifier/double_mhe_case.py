"""The reference cases of paper 002's sheets: whole runs, every estimate of every window.

Half of the frames are the paper's example with several controls; half are measurements and controls far outside it,
which hold samples on their bounds.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from verification.plants.scalar_system import ScalarSystem
from verification.reference.double_mhe.estimators import run_convexified, run_double, run_linearised, run_nonlinear
from verification.verifier.case import Array, FunctionReference, Scenario

TOLERANCE = 1e-9
LEVELS = ((5.0, 10.0, 20.0), (0.5, 0.2, 0.1), (5.0, -5.0, 0.0))
N = 10


def runs(frames: int, seed: int) -> Sequence[Scenario]:
    """Scenarios of y and u."""
    each = max(1, frames // (2 * len(LEVELS)))
    made = []
    for levels in LEVELS:
        recording = ScalarSystem(levels, duration=each * 0.01).recording(seed)
        made.append(Scenario(f"u = {levels}", {"y": recording["y"], "u": recording["u"]}, fault_free=True))
    rest = max(1, frames - each * len(LEVELS))
    return [
        *made,
        Scenario("beyond the bounds", {"y": _beyond(rest, seed), "u": _generator(seed).normal(0.0, 30.0, rest)}),
    ]


def windows(frames: int, seed: int) -> Sequence[Scenario]:
    """Scenarios of whole windows for the linearised stage; the first windows are not yet full."""
    generator = _generator(seed)
    y = np.lib.stride_tricks.sliding_window_view(_beyond(frames + N - 1, seed), N).copy()
    present = np.ones((frames, N))
    for k in range(min(frames, N)):
        present[k, : N - 1 - k] = 0.0
    x_bar = np.clip(y + generator.normal(0.0, 0.1, y.shape), -1.0, 2.0)
    u = generator.normal(0.0, 30.0, (frames, N - 1))
    return [Scenario("windows", {"y": y, "u": u, "present": present, "x_bar": x_bar})]


def _generator(seed: int) -> np.random.Generator:
    return np.random.default_rng([seed, 5])


def _beyond(frames: int, seed: int) -> Array:
    """Measurements in steps of 25 samples, often outside [-1, 2], with noise."""
    generator = _generator(seed)
    steps = np.repeat(generator.normal(0.5, 1.5, frames // 25 + 1), 25)[:frames]
    noisy: Array = steps + generator.normal(0.0, 0.3, frames)
    return noisy


SIGMA = {"x": 1.0, "x_hat": 1.0, "x_bar": 1.0}
"""The state's bounds are -1 and 2."""

convexified_mhe = FunctionReference(run_convexified, runs, SIGMA, TOLERANCE)
linearised_mhe = FunctionReference(run_linearised, windows, SIGMA, TOLERANCE)
double_mhe = FunctionReference(run_double, runs, SIGMA, TOLERANCE)
nonlinear_mhe = FunctionReference(run_nonlinear, runs, SIGMA, TOLERANCE)
