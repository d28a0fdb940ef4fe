"""Algorithm 2 of paper 001, steps 2 and 3: the update of last frame's window by the new output, one step ahead.

The window of N + 2 samples ends with the prediction f(x_{t-1|t-1}, u_{t-1}), whose noise and whose innovation are zero
(Proposition 1). Corrected: K_t has a minus sign. A component on a bound that the cost pushes it against is held; the
updated window is projected onto X (Remark 1).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from verification.reference.arrays import Array, Mask, saturate
from verification.reference.cstr.reactor import step, trajectory
from verification.reference.cstr.shooting import expand_shooting, shooting_cost
from verification.reference.cstr.tuning import Tuning
from verification.reference.cstr.window import Information, cost, expand, free_gradient, held, reduced, step_of

PRINTED = -1.0
"""The sign of K_t as the paper prints it, against the right one."""


@dataclass(frozen=True)
class Update:
    """What Algorithm 2 makes of a window of n = N + 2 samples when its last output arrives."""

    reference: Array  # (n, 2), last frame's estimates and their prediction
    hold: Mask  # (n, 2), or (2,) without noises
    stationary: float  # largest free element of the gradient of J/2 at the reference: (24)
    curvature: float  # least eigenvalue of the free part of its Hessian: (25)
    updated: Array  # (n, 2), (26), projected
    J_reference: float
    J_updated: float
    second_order: bool  # (24) and (25) hold
    accepted: bool  # and (27)
    x: Array  # (n, 2), what step 3 takes


def update(
    last: Array, given: Information, tuning: Tuning, sign: float = 1.0, *, holding: bool = True
) -> Update:
    """Update the window `last` (N + 1, 2), with estimated noises, to the N + 2 outputs of `given`.

    Without ``holding`` every component moves by (26), as the paper prints it, and is projected afterwards.
    """
    reference = np.vstack([last, step(last[-1], given.u[-1], tuning)])
    y_bar = reference[-1, 1]
    at = expand(reference, replace(given, y=np.append(given.y[:-1], y_bar)), tuning)
    hold = held(reference, at.gradient, tuning) & holding
    push = np.zeros_like(reference)
    push[-1, 1] = sign * tuning.R * (given.y[-1] - y_bar)  # -1/2 of d2J/dx dy_t, times y_t - y_bar_t
    updated = saturate(reference + step_of(at.hessian, push, hold), tuning.lower, tuning.upper)
    stationary = free_gradient(at.gradient, hold)
    curvature = float(np.linalg.eigvalsh(reduced(at.hessian, hold))[0])
    costs = cost(reference, given, tuning), cost(updated, given, tuning)
    return _judge(reference, hold, stationary, curvature, updated, costs, tuning)


def update_first(last: Array, given: Information, tuning: Tuning, sign: float = 1.0) -> Update:
    """Update the window `last` (N + 1, 2), without noises: its first state, from which the others follow."""
    reference = np.vstack([last, step(last[-1], given.u[-1], tuning)])
    first, y_bar = reference[0], reference[-1, 1]
    at = expand_shooting(first, replace(given, y=np.append(given.y[:-1], y_bar)), tuning)
    hold = held(first, at.gradient, tuning)
    push = sign * tuning.R * (given.y[-1] - y_bar) * at.Phi[-1][1]
    moved = saturate(first + step_of(at.hessian, push, hold), tuning.lower, tuning.upper)
    updated = trajectory(moved, given.u, tuning)
    stationary = free_gradient(at.gradient, hold)
    curvature = float(np.linalg.eigvalsh(reduced(at.hessian, hold))[0])
    missed = tuning.R * (given.y[-1] - y_bar) ** 2  # the reference's last innovation is zero with y_bar
    costs = at.J + float(missed), shooting_cost(moved, given, tuning)
    return _judge(reference, hold, stationary, curvature, updated, costs, tuning)


def _judge(
    reference: Array,
    hold: Mask,
    stationary: float,
    curvature: float,
    updated: Array,
    costs: tuple[float, float],
    tuning: Tuning,
) -> Update:
    second_order = stationary <= tuning.optimal and curvature > 0.0
    accepted = second_order and costs[1] <= costs[0]  # (27)
    x = updated if accepted else reference
    return Update(reference, hold, stationary, curvature, updated, *costs, second_order, accepted, x)
