"""How many passes and linearisations paper 002's sheets need.

    python -m verification.results.active_set_passes [--frames 600]

The windows are those of `saoflow verify`: the paper's example, on which no bound is reached, and measurements far
outside it.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from verification.reference.double_mhe.estimators import convexified_stage, nonlinear, over_run
from verification.reference.double_mhe.model import Array, Window, convexified, linearised
from verification.reference.double_mhe.quadratic_program import active_set, hessian_and_gradient
from verification.reference.double_mhe.tuning import PAPER, Tuning
from verification.verifier.case import Scenario
from verification.verifier.double_mhe_case import runs

SOLVED = 1e-9
"""A window is solved when its estimates are this near to the solution."""

LEAST_FRAMES = 30
"""Of all scenarios together; each has windows then."""

ENOUGH = 3 * PAPER.n
"""Passes after which nothing changes any more."""


@dataclass(frozen=True)
class Unsolved:
    """One scenario: windows, those with a sample on a bound, and those not solved after 1, 2, ... passes, by stage."""

    scenario: str
    stage: str
    windows: int
    held: int
    after: tuple[int, ...]


def programs(scenario: Scenario, tuning: Tuning) -> Iterator[tuple[str, Array, Array]]:
    """Stage, H and F/2 of every window of a run of double MHE."""
    exact = replace(tuning, passes=ENOUGH)
    for window, x in over_run(scenario.inputs["y"], scenario.inputs["u"], convexified_stage, exact):
        yield "convexified", *hessian_and_gradient(convexified(window, tuning.t_s), window, tuning.first)
        about = Window(window.y, window.u, float(x[0]))
        yield "linearised", *hessian_and_gradient(linearised(about, x, tuning.t_s), about, tuning.second)


def unsolved(scenarios: Sequence[Scenario], passes: int = 5, tuning: Tuning = PAPER) -> tuple[Unsolved, ...]:
    """Count the windows that are not solved after 1 to ``passes`` passes."""
    found = []
    for scenario in scenarios:
        counts = {stage: np.zeros(passes + 2, int) for stage in ("convexified", "linearised")}
        for stage, h, half_f in programs(scenario, tuning):
            solution = active_set(h, half_f, replace(tuning, passes=ENOUGH))
            counts[stage][0] += 1
            counts[stage][1] += bool(np.any((solution <= tuning.low) | (solution >= tuning.high)))
            for p in range(passes):
                x = active_set(h, half_f, replace(tuning, passes=p + 1))
                counts[stage][p + 2] += bool(np.abs(x - solution).max() > SOLVED)
        found += [
            Unsolved(scenario.name, s, int(n[0]), int(n[1]), tuple(int(c) for c in n[2:])) for s, n in counts.items()
        ]
    return tuple(found)


def iteration_errors(scenario: Scenario, most: int = 6, tuning: Tuning = PAPER) -> tuple[float, ...]:
    """Largest difference of nonlinear MHE's newest estimates from converged ones after 1 to ``most`` linearisations."""

    def newest(iterations: int) -> Array:
        chosen = replace(tuning, iterations=iterations)
        return np.array([x[-1] for _, x in over_run(scenario.inputs["y"], scenario.inputs["u"], nonlinear, chosen)])

    converged = newest(4 * most)
    return tuple(float(np.abs(newest(i) - converged).max()) for i in range(1, most + 1))


def main(arguments: Sequence[str] | None = None) -> None:
    """Print both tables."""
    parser = argparse.ArgumentParser(prog="python -m verification.results.active_set_passes")
    parser.add_argument("--frames", type=int, default=600, help="of all scenarios together")
    frames = parser.parse_args(arguments).frames
    if frames < LEAST_FRAMES:
        parser.error(f"--frames {frames} leaves scenarios without a window: write at least {LEAST_FRAMES}")
    scenarios = runs(frames, seed=3)
    print("windows not solved after 1, 2, ... active-set passes")
    for row in unsolved(scenarios):
        print(f"{row.scenario:22} {row.stage:12} {row.windows:4} windows, {row.held:3} on a bound: {row.after}")
    print("nonlinear MHE, largest difference from converged after 1, 2, ... linearisations")
    for scenario in scenarios[:-1]:
        print(f"{scenario.name:22} " + ", ".join(f"{e:.0e}" for e in iteration_errors(scenario)))


if __name__ == "__main__":
    main()
