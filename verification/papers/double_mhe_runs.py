"""Paper 002's estimators on its scalar example: Table I's sums, a solver that stops early, all minima of a window."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

import saoflow
from verification.plants.scalar_system import ScalarSystem, absolute_error
from verification.reference.double_mhe.estimators import nonlinear, over_run
from verification.reference.double_mhe.model import Array, Window, f, linearised
from verification.reference.double_mhe.quadratic_program import estimate
from verification.reference.double_mhe.tuning import PAPER, Tuning

SHEETS = ("nonlinear_mhe", "convexified_mhe", "double_mhe")
"""In the order of Table I: NMHE, CMHE, DMHE."""

TRUE, WRONG = 0.0, -1.0
"""The two guesses of x_0."""

LEVELS = ((5.0, 10.0, 20.0), (1.0, 5.0, 10.0), (5.0, -5.0, 0.0), (0.5, 0.2, 0.1))
"""Controls that are tried, strong to weak; the paper gives none."""

STOP = 1e-6
"""A usual default: a solver stops when the cost falls by less."""


@dataclass(frozen=True, eq=False)
class Run:
    """One sheet over one recording."""

    sheet: str
    guess: float
    x_hat: Array  # (frames,)
    truth: Array  # (frames,)

    @property
    def error(self) -> float:
        """Table I's sum of absolute errors."""
        return absolute_error(self.x_hat, self.truth)

    @property
    def bias(self) -> float:
        """Mean error after the first tenth."""
        return float(np.mean((self.x_hat - self.truth)[len(self.truth) // 10 :]))


def run_sheets(system: ScalarSystem, guess: float, seed: int) -> dict[str, Run]:
    """Every sheet of Table I on one recording."""
    recording = system.recording(seed)
    inputs = {"y": recording["y"], "u": recording["u"]}
    runs = {}
    for sheet in SHEETS:
        simulator = saoflow.load(sheet, parameters={"x_0": guess}).simulator()
        runs[sheet] = Run(sheet, guess, simulator.run(inputs)["x_hat"], recording["x_true"])
    return runs


def sums(system: ScalarSystem, guess: float, seeds: Sequence[int]) -> dict[str, float]:
    """Table I's sums, the mean over noise seeds."""
    every = [run_sheets(system, guess, seed) for seed in seeds]
    return {sheet: float(np.mean([runs[sheet].error for runs in every])) for sheet in SHEETS}


def contraction(system: ScalarSystem) -> float:
    """How fast two trajectories of the system approach each other, mean over the run [1/s]."""
    x = system.states()
    slope = 1.0 + 0.01 * (20.0 * x - 60.0 * x**2)
    return float(-np.log(np.abs(slope)).mean() / 0.01)


def cost(x: Array, window: Window, tuning: Tuning = PAPER) -> float:
    """(4a) with the nonlinear system and the second stage's weights, as the paper states it: not scaled."""
    weights = tuning.second
    moved = x[1:] - f(x[:-1], window.u, tuning.t_s)
    return float(
        weights.p * (x[0] - window.s) ** 2 + weights.q * moved @ moved + weights.r * np.sum((window.y - x) ** 2)
    )


def stopping_early(window: Window, warm: Array, tuning: Tuning) -> Array:
    """The nonlinear window by a solver that ends when an iteration would lower the cost by less than :data:`STOP`."""
    x = warm
    for _ in range(20):
        new = estimate(linearised(window, x, tuning.t_s), window, tuning.second, tuning)
        if cost(x, window, tuning) - cost(new, window, tuning) < STOP:
            break
        x = new
    return x


def stopped_sum(system: ScalarSystem, guess: float, seed: int) -> float:
    """Table I's sum for that solver."""
    recording = system.recording(seed)
    frames = over_run(recording["y"], recording["u"], stopping_early, replace(PAPER, guess=guess))
    return absolute_error([x[-1] for _, x in frames], recording["x_true"])


def windows(system: ScalarSystem, guess: float, seed: int, every: int) -> list[tuple[Window, Array]]:
    """Windows of the nonlinear estimator and its estimates, each so-many-th frame."""
    recording = system.recording(seed)
    frames = over_run(recording["y"], recording["u"], nonlinear, replace(PAPER, guess=guess, iterations=6))
    return frames[::every]


@dataclass(frozen=True, eq=False)
class Profile:
    """The least cost of a window as a function of its newest state, all other states free: by dynamic programming."""

    x: Array
    cost: Array

    @property
    def minima(self) -> int:
        """Local minima between -1 and 2, ends included."""
        falls = np.diff(self.cost) < 0.0
        turns = int(np.sum(falls[:-1] & ~falls[1:]))
        return turns + int(not falls[0]) + int(falls[-1])

    @property
    def at(self) -> float:
        """Where it is least."""
        return float(self.x[np.argmin(self.cost)])


def profile(window: Window, points: int = 601, tuning: Tuning = PAPER) -> Profile:
    """Every trajectory on a grid of states is considered, so no local minimum can hide the global one."""
    weights, x = tuning.second, np.linspace(tuning.low, tuning.high, points)
    value = weights.p * (x - window.s) ** 2 + weights.r * (window.y[0] - x) ** 2
    for i in range(len(window.u)):
        reached = f(x, window.u[i : i + 1], tuning.t_s)
        value = np.min(value[:, None] + weights.q * (x[None, :] - reached[:, None]) ** 2, axis=0)
        value = value + weights.r * (window.y[i + 1] - x) ** 2
    return Profile(x, value)


def distinct_minima(window: Window, starts: int, seed: int, tuning: Tuning = PAPER) -> int:
    """Different trajectories in which a damped Gauss-Newton method ends from random ones."""
    generator = np.random.default_rng([seed, 11])
    found: list[Array] = []
    for _ in range(starts):
        x = _descended(generator.uniform(tuning.low, tuning.high, len(window.y)), window, tuning)
        if not any(np.abs(x - other).max() < 1e-3 for other in found):
            found.append(x)
    return len(found)


def _descended(x: Array, window: Window, tuning: Tuning) -> Array:
    least = cost(x, window, tuning)
    for _ in range(200):
        direction = estimate(linearised(window, x, tuning.t_s), window, tuning.second, tuning) - x
        step = 1.0
        while step > 1e-6 and cost(x + step * direction, window, tuning) > least:
            step /= 2.0
        if step <= 1e-6 or np.abs(direction).max() < 1e-9:
            return x
        x = x + step * direction
        least = cost(x, window, tuning)
    return x
