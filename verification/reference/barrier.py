"""The logarithmic barrier of (44): its gradient and the square root of its Hessian, (46a) and (46b).

No logarithm is ever evaluated. Every entry of x and u carries a barrier: j = 1 to 4, printed 1 to 3.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from verification.reference.arrays import Array


@dataclass(frozen=True)
class Room:
    """What is left to the bounds of (42b) from the point of linearisation, shape (n, 4) each."""

    lower: Array  # Delta x^LB = lb - x
    upper: Array  # Delta x^UB = ub - x
    floor: Array  # (4,), the least distance: a point nearer to a bound counts as this far inside

    def distances(self, step: Array) -> tuple[Array, Array]:
        """Return d1 = Delta x^UB - Delta x and d2 = Delta x - Delta x^LB, not below the floor."""
        d1: Array = np.maximum(self.upper - step, self.floor)
        d2: Array = np.maximum(step - self.lower, self.floor)
        return d1, d2


def room(point: Array, lower: Array, upper: Array, floor_fraction: float) -> Room:
    """Return the room around `point` (n, 4) inside the bounds (4,); the floor is a fraction of the width."""
    return Room(lower - point, upper - point, floor_fraction * (upper - lower))


def gradient(d1: Array, d2: Array) -> Array:
    """Return g of (46a): the derivative of -log(d1) - log(d2)."""
    return 1.0 / d1 - 1.0 / d2


def root_hessian(d1: Array, d2: Array) -> Array:
    """Return the diagonal of L of (46b): the square root of the second derivative."""
    root: Array = np.sqrt(1.0 / d1**2 + 1.0 / d2**2)
    return root


def reach(direction: Array, d1: Array, d2: Array) -> float:
    """Return v: a step s along `direction` stays strictly inside the bounds if and only if s v < 1."""
    return float(np.maximum(direction / d1, -direction / d2).max())


def strictly_inside(step: Array, d1: Array, d2: Array) -> bool:
    """Return whether `step` keeps every entry strictly inside: the barrier is infinite on the bound."""
    return bool((step < d1).all() and (-step < d2).all())
