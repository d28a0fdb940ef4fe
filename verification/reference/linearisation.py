"""The quadratic program (42): the window linearised at the warm start."""

from __future__ import annotations

from dataclasses import dataclass

from verification.reference.arrays import Array
from verification.reference.model import output, transition, transition_jacobian
from verification.reference.tuning import Tuning


@dataclass(frozen=True)
class Window:
    """What Step 3 knows of the samples l to k = l + N - 1."""

    theta: Array  # (N, 6)
    y: Array  # (N, 4)
    row_mask: Array  # (N, 4), 1 where a row of C counts


@dataclass(frozen=True)
class QuadraticProgram:
    """The quantities of (42), noted at the point (x, u)."""

    x: Array  # (N, 4), the point
    u: Array  # (N - 1, 4)
    A: Array  # (N - 1, 4, 4)
    C: Array  # (N, 4, 4), rows masked
    f: Array  # (N - 1, 4)
    r_u: Array  # (N - 1, 4)
    r_y: Array  # (N, 4), rows masked


def linearise(x: Array, u: Array, window: Window, tuning: Tuning) -> QuadraticProgram:
    """Return (42) at the point x (N, 4), u (N - 1, 4).

    f_i = F(x_i, u_i, Theta_i) - x_{i+1}: F is the discrete map already, so the printed t_s F is not added
    to x_i. A masked row of C and its residual are zero, which takes that output out of the problem
    without changing a size (V-C): at all samples when its sensors are lost (configurations II to IV),
    at one sample when it is missing there.
    """
    y, C = output(x, window.theta, tuning)
    mask = window.row_mask
    theta = window.theta[:-1]
    return QuadraticProgram(
        x=x,
        u=u,
        A=transition_jacobian(x[:-1], theta, tuning),
        C=mask[:, :, None] * C,
        f=transition(x[:-1], u, theta, tuning) - x[1:],
        r_u=-u,
        r_y=mask * (window.y - y),
    )
