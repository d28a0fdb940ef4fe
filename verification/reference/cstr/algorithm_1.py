"""Algorithm 1 of paper 001, step 1: the window by a fixed number of projected Gauss-Newton passes.

A component on a bound that the cost pushes it against is held; the step of the others is projected onto X. The
Gauss-Newton matrix is positive definite everywhere, which the Hessian is not.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from verification.reference.arrays import Array, Mask, saturate
from verification.reference.cstr.shooting import ShootingExpansion, expand_shooting
from verification.reference.cstr.tuning import Tuning
from verification.reference.cstr.window import Expansion, Information, expand, held, step_of


@dataclass(frozen=True)
class Pass:
    """One pass over the window."""

    at: Expansion
    hold: Mask  # (n, 2)
    x: Array  # (n, 2), after the pass


def estimate(x: Array, given: Information, tuning: Tuning, passes: int | None = None) -> list[Pass]:
    """Run the passes from the states x (n, 2); the last pass holds the estimates."""
    x = saturate(x, tuning.lower, tuning.upper)
    done = []
    for _ in range(tuning.n_GN if passes is None else passes):
        at = expand(x, given, tuning)
        hold = held(x, at.gradient, tuning)
        x = saturate(x + step_of(at.gauss_newton, -at.gradient, hold), tuning.lower, tuning.upper)
        done.append(Pass(at, hold, x))
    return done


@dataclass(frozen=True)
class DampedPass:
    """One pass for the first state of a window without noises."""

    at: ShootingExpansion  # at the trial of the pass before
    better: bool  # its cost is not above the best one
    best: ShootingExpansion
    hold: Mask  # (2,)
    damping: float
    trial: Array  # (2,), for the next pass


def estimate_first(first: Array, given: Information, tuning: Tuning, passes: int | None = None) -> list[DampedPass]:
    """Run damped passes (Levenberg, Marquardt) for the first state (2,); the last pass holds the best window.

    Without noises the cost is far from quadratic: where the reactor strays far, undamped passes lose a window now and
    then (`python -m verification.results.reactor_passes`).
    """
    trial = saturate(first, tuning.lower, tuning.upper)
    damping, done = tuning.damping, list[DampedPass]()
    for _ in range(tuning.n_GN_first if passes is None else passes):
        at = expand_shooting(trial, given, tuning)
        better = not done or done[-1].best.J * (1.0 + tuning.J_margin) >= at.J
        best = at if better else done[-1].best
        factor = tuning.relax if better else 1.0 / tuning.relax
        damping = float(saturate(np.array(damping * factor), tuning.damping_min, tuning.damping_max))
        hold = held(best.x[0], best.gradient, tuning)
        move = step_of(best.gauss_newton + damping * np.eye(2), -best.gradient, hold)
        trial = saturate(best.x[0] + move, tuning.lower, tuning.upper)
        done.append(DampedPass(at, better, best, hold, damping, trial))
    return done
