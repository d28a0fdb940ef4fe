"""What the findings of paper 001 are computed from: the sheets on simulated reactors, and exact solutions of windows."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache

import numpy as np

import saoflow
from verification.plants.cstr import COOL, Run, SetPoint, simulate
from verification.reference.arrays import Array, Mask
from verification.reference.cstr.algorithm_1 import estimate
from verification.reference.cstr.estimator import ALGORITHM_1, ALGORITHM_2, frames
from verification.reference.cstr.sensitivity import update
from verification.reference.cstr.tuning import Tuning
from verification.reference.cstr.window import Information

NAMES = {
    "cstr_mhe": "Algorithm 1",
    "cstr_mhe_no_est": "Algorithm 1 No Est",
    "cstr_ahead": "Algorithm 2",
    "cstr_ahead_no_est": "Algorithm 2 No Est",
}
"""The sheets by the paper's names."""

ALGORITHMS = ("cstr_mhe", "cstr_ahead")
WITHOUT = {"cstr_mhe": "cstr_mhe_no_est", "cstr_ahead": "cstr_ahead_no_est"}

CONVERGED = 30
"""Passes after which a window with noises is at rounding."""


@dataclass(frozen=True, eq=False)
class Estimated:
    """What a sheet made of several runs, one row a run."""

    x_hat: Array  # (runs, 251, 2)
    window: Array  # (runs, 251, N + 1, 2)
    valid: Mask  # (runs, 251)
    accepted: Mask | None  # (runs, 251), Algorithm 2 only


@dataclass(frozen=True, eq=False)
class Horizon:
    """All sheets with one N on the same runs."""

    N: int
    x: Array  # (runs, 251, 2), the truth
    by_sheet: dict[str, Estimated]

    def error(self, sheet: str, first: int, last: int | None = None) -> Array:
        """Errors of the concentration from frame ``first`` on, up to ``last``, shape (runs, frames)."""
        difference: Array = (self.by_sheet[sheet].x_hat - self.x)[:, first:last, 0]
        return difference

    def distances(self, sheet: str, other: str, first: int) -> Array:
        """The paper's mean SSE of every run: the mean square difference of two sheets' concentrations, shape (runs,)."""
        a, b = self.by_sheet[sheet].x_hat, self.by_sheet[other].x_hat
        found: Array = np.mean((a - b)[:, first:, 0] ** 2, axis=1)
        return found

    def distance(self, sheet: str, other: str, first: int) -> float:
        """The same of all runs."""
        return float(np.mean(self.distances(sheet, other, first)))

    def nearer(self, first: int) -> tuple[float, float]:
        """Shares of runs in which Algorithm 2 with noises is nearer to Algorithm 1 than without: to the same without
        noises, and to Algorithm 1 with noises."""
        near = self.distances("cstr_ahead", "cstr_mhe", first)
        own = self.distances("cstr_ahead_no_est", "cstr_mhe_no_est", first)
        optimal = self.distances("cstr_ahead_no_est", "cstr_mhe", first)
        return float(np.mean(near < own)), float(np.mean(near < optimal))

    def at_bound(self, sheet: str) -> float:
        """Share of windows in which a concentration lies on its bound 0."""
        windows = self.by_sheet[sheet].window[:, self.N :, :, 0]
        return float(np.mean((windows <= 0.0).any(axis=-1)))


def rms(values: Array) -> float:
    """Root of the mean square of all elements."""
    return float(np.sqrt(np.mean(values**2)))


@cache
def _simulator(sheet: str, N: int) -> saoflow.Simulator:
    return saoflow.load(sheet, parameters={"N": N}).simulator(backend="c")


def run_sheets(seeds: Sequence[int], N: int, start: SetPoint = COOL, sheets: Sequence[str] = tuple(NAMES)) -> Horizon:
    """Run sheets with horizon N on the simulated reactor, one run for each seed."""
    runs = [simulate(seed, start=start) for seed in seeds]
    recordings = [run.recording for run in runs]
    inputs = {name: np.stack([recording[name] for recording in recordings]) for name in ("y", "u")}
    by_sheet = {}
    for sheet in sheets:
        simulator = _simulator(sheet, N)
        simulator.reset()
        out = simulator.run(inputs)
        accepted = out["accepted"] > 0.5 if "accepted" in out else None
        by_sheet[sheet] = Estimated(out["x_hat"], out["window"], out["valid"] > 0.5, accepted)
    return Horizon(N, np.stack([run.x for run in runs]), by_sheet)


@dataclass(frozen=True, eq=False)
class Updates:
    """Updates (26) beside exact solutions of the same windows of N + 2 samples, one row a window."""

    innovation: Array  # y_t - y_bar_t
    before: Array  # concentration at t, reference less exact
    after: Array  # x^u less exact
    plain: Array  # the same without holding components
    held: Mask  # a component of the reference is held
    changed: Mask  # the exact solution holds other components than the reference
    stationary: Array  # largest free element of the gradient of J/2 at the reference
    curvature: Array  # least eigenvalue of the free part of its Hessian there

    def left(self, rows: Mask, *, plain: bool = False) -> float:
        """What the update leaves of the distance to the exact solution, as a ratio of rms."""
        return rms((self.plain if plain else self.after)[rows]) / rms(self.before[rows])

    def worse(self, rows: Mask, *, plain: bool = False) -> float:
        """Share of windows that the update takes farther from the exact solution."""
        after = self.plain if plain else self.after
        return float(np.mean(np.abs(after[rows]) > np.abs(self.before[rows])))


def updates(seeds: Sequence[int], steps: int, tuning: Tuning) -> Updates:
    """Update every window of some runs, from converged estimates, and solve it exactly."""
    rows = []
    for seed in seeds:
        run = simulate(seed, steps=steps)
        followed = frames(run.recording, replace(tuning, n_GN=CONVERGED), ALGORITHM_1)
        for t in range(tuning.N + 1, steps + 1):
            rows.append(_update(run, t, followed[t - 1].x, followed[t - 1].x_bar, tuning))
    columns = list(zip(*rows, strict=True))
    numbers = [np.array(column, dtype=np.float64) for column in columns]
    flags = numbers[4] > 0.5, numbers[5] > 0.5
    return Updates(numbers[0], numbers[1], numbers[2], numbers[3], *flags, numbers[6], numbers[7])


def _update(run: Run, t: int, last: Array, x_bar: Array, tuning: Tuning) -> tuple[float, ...]:
    samples = tuning.N + 2
    given = Information(x_bar, run.y[t - samples + 1 : t + 1], run.u[t - samples + 1 : t])
    made, plain = (update(last, given, tuning, holding=holding) for holding in (True, False))
    exact = estimate(made.reference, given, tuning, CONVERGED)[-1]
    now = (made.reference[-1, 0], made.updated[-1, 0], plain.updated[-1, 0])
    distances = tuple(float(x - exact.x[-1, 0]) for x in now)
    changed = float((exact.hold != made.hold).any())
    return float(run.y[t] - made.reference[-1, 1]), *distances, float(made.hold.any()), changed, made.stationary, made.curvature


@dataclass(frozen=True)
class Refusals:
    """Updates with one sign of K_t."""

    failed: float  # share of them, (24) and (25) satisfied, that fail test (27)
    concentration: float  # rms errors of x^+
    temperature: float
    windows: int


def refusals(seeds: Sequence[int], steps: int, tuning: Tuning, sign: float) -> Refusals:
    """Run Algorithm 2 with one sign of K_t: 1 is right, -1 is printed."""
    failed, errors = [], []
    for seed in seeds:
        run = simulate(seed, steps=steps)
        for x, frame in list(zip(run.x, frames(run.recording, tuning, replace(ALGORITHM_2, sign=sign)), strict=True))[
            tuning.N + 1 :
        ]:
            assert frame.update is not None
            errors.append(frame.x_hat - x)
            if frame.update.second_order:
                failed.append(not frame.update.accepted)
    concentration, temperature = np.sqrt(np.mean(np.square(errors), axis=0))
    return Refusals(float(np.mean(failed)), float(concentration), float(temperature), len(failed))


@dataclass(frozen=True)
class Operations:
    """Operations of a frame of an Algorithm 2."""

    exact: int  # a frame of the Algorithm 1 that it stands for
    frame: int
    ahead: int  # of the update, from last frame's solution to x^+
    waiting: int  # those of them that need y_t
    minimisation: int  # of all passes


WITHOUT_Y = ("cost", "free", "curved", "D_later", "back")
"""Blocks of an update that do not need y_t."""


def operations(sheet: str, N: int) -> Operations:
    """Count the operations of cstr_ahead or cstr_ahead_no_est."""
    exact = saoflow.load(sheet.replace("ahead", "mhe"), parameters={"N": N}).budget().total
    tree = saoflow.load(sheet, parameters={"N": N}).budget().tree
    ahead = tree.parts["ahead"]
    early = sum(part.total for name, part in ahead.parts.items() if name.split("[")[0] in WITHOUT_Y)
    passes = sum(part.total for name, part in tree.parts.items() if name.startswith("passes"))
    return Operations(exact, tree.total, ahead.total, ahead.total - early, passes)
