"""How many passes paper 001's estimators need: ``python -m verification.results.reactor_passes [--seeds 1 49] [--steps 250]``.

Every window of simulated runs is solved to rounding, and again with 1, 2, ... passes from the same start.
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from verification.plants.cstr import STEPS, simulate
from verification.reference.arrays import Array
from verification.reference.cstr.algorithm_1 import estimate, estimate_first
from verification.reference.cstr.reactor import step as predict
from verification.reference.cstr.shooting import shooting_cost
from verification.reference.cstr.tuning import Tuning
from verification.reference.cstr.window import Information, cost

CONVERGED = 60
"""Passes after which a window is at rounding, if it ever is."""

SEEDS = (1, 2, 49)
"""Two ordinary runs, and the one of 1 to 50 in which the reactor strays farthest."""

FAR = 1e-2
"""A window whose estimates end this far from the solution is lost: about a concentration's noise in a step."""


@dataclass(frozen=True)
class Distance:
    """Distances of the window from its solution after some passes."""

    passes: int
    typical: float  # the median over the windows of the largest of a window
    largest: float
    lost: int
    epsilon: float  # largest excess of the cost over the solution's: (8)


@dataclass(frozen=True)
class Method:
    """One way of passes: from (start, information, tuning, passes) to the window."""

    name: str
    solve: Callable[[Array, Information, Tuning, int], Array]
    exact: Callable[[Array, Information, Tuning, int], Array]
    """Gives the solution that the distance is measured from."""
    cost: Callable[[Array, Information, Tuning], float]
    """Of a window."""
    counts: tuple[int, ...]


def _noises(start: Array, given: Information, tuning: Tuning, passes: int) -> Array:
    return estimate(start, given, tuning, passes)[-1].x


def _damped(start: Array, given: Information, tuning: Tuning, passes: int) -> Array:
    return estimate_first(start[0], given, tuning, passes)[-1].best.x


def _undamped(start: Array, given: Information, tuning: Tuning, passes: int) -> Array:
    free = replace(tuning, damping=0.0, damping_min=0.0, J_margin=math.inf)
    return estimate_first(start[0], given, free, passes)[-1].best.x


def _cost_without(window: Array, given: Information, tuning: Tuning) -> float:
    return shooting_cost(window[0], given, tuning)


METHODS = (
    Method("with noises", _noises, _noises, cost, (1, 2, 3, 4, 6, 10)),
    Method("without, damped", _damped, _damped, _cost_without, (4, 6, 8, 10, 15)),
    Method("without, not damped", _undamped, _damped, _cost_without, (4, 6, 8, 10, 15)),
)


def distances(method: Method, seeds: Sequence[int], steps: int = STEPS, tuning: Tuning | None = None) -> list[Distance]:
    """Solve every window of a run, each from the solution before it, with every number of passes."""
    tuning = tuning or Tuning()
    found: list[list[float]] = [[] for _ in method.counts]
    excess = [0.0] * len(method.counts)
    for seed in seeds:
        run = simulate(seed, steps=steps, tuning=tuning)
        exact: Array | None = None
        for t in range(tuning.N, steps + 1):
            y, u = run.y[t - tuning.N : t + 1], run.u[t - tuning.N : t]
            if exact is None:
                start, x_bar = np.column_stack([np.full(len(y), tuning.x_bar_1), y]), tuning.x_bar_0
            else:
                start, x_bar = np.vstack([exact[1:], predict(exact[-1], float(u[-1]), tuning)]), exact[1]
            given = Information(x_bar, y, u)
            exact = method.exact(start, given, tuning, CONVERGED)
            least = method.cost(exact, given, tuning)
            for i, count in enumerate(method.counts):
                window = method.solve(start, given, tuning, count)
                found[i].append(float(np.abs(window - exact).max()))
                excess[i] = max(excess[i], method.cost(window, given, tuning) - least)
    return [
        Distance(count, float(np.median(column)), max(column), sum(value > FAR for value in column), more)
        for count, column, more in zip(method.counts, found, excess, strict=True)
    ]


def main(arguments: Sequence[str] | None = None) -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(prog="python -m verification.results.reactor_passes", description=__doc__)
    parser.add_argument("--seeds", type=int, nargs="+", default=SEEDS, help="the runs")
    parser.add_argument("--steps", type=int, default=STEPS, help="of each run")
    given = parser.parse_args(arguments)
    if given.steps <= Tuning().N:
        parser.error(f"--steps {given.steps} is no longer than a window: write more than {Tuning().N}")
    print("| passes | from the solution, median | largest | windows lost | largest excess of J |\n|---|---|---|---|---|")
    for method in METHODS:
        for row in distances(method, given.seeds, given.steps):
            print(f"| {method.name}: {row.passes} | {row.typical:.0e} | {row.largest:.0e} | {row.lost} | {row.epsilon:.0e} |")


if __name__ == "__main__":
    main()
