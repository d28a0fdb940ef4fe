"""Algorithm 1 of paper 001, step 1: the window by a fixed number of projected Gauss-Newton passes.

A component on a bound that the cost pushes it against is held; the step of the others is projected onto X. The
Gauss-Newton matrix is positive definite everywhere, which the Hessian is not.
"""

from __future__ import annotations

from dataclasses import dataclass

from verification.reference.arrays import Array, Mask, saturate
from verification.reference.cstr.reactor import trajectory
from verification.reference.cstr.shooting import ShootingExpansion, expand_shooting
from verification.reference.cstr.tuning import Tuning
from verification.reference.cstr.window import Expansion, Information, expand, held, step_of


@dataclass(frozen=True)
class Pass:
    """One pass over the window."""

    at: Expansion | ShootingExpansion
    hold: Mask  # (n, 2), or (2,) without noises
    x: Array  # after the pass: (n, 2), or (2,) without noises


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


def estimate_first(first: Array, given: Information, tuning: Tuning, passes: int | None = None) -> list[Pass]:
    """Run the passes for the first state (2,) alone, without noises; the last pass holds its estimate."""
    first = saturate(first, tuning.lower, tuning.upper)
    done = []
    for _ in range(tuning.n_GN if passes is None else passes):
        at = expand_shooting(first, given, tuning)
        hold = held(first, at.gradient, tuning)
        first = saturate(first + step_of(at.gauss_newton, -at.gradient, hold), tuning.lower, tuning.upper)
        done.append(Pass(at, hold, first))
    return done


def window_of(first: Array, given: Information, tuning: Tuning) -> Array:
    """Return the states that follow from the first one, shape (n, 2)."""
    return trajectory(first, given.u, tuning)
