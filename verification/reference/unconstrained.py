"""The unconstrained counterpart of Algorithm 1: (42) without its inequalities, solved in one step.

Without bounds (42) is (45) with C_bar = C, R_bar = R, Q_bar = Q and residuals at (dx, du) = 0, so that
Algorithm 2 gives the exact minimiser and the full step is taken.
"""

from __future__ import annotations

import numpy as np

from verification.reference.interior_point import Iteration
from verification.reference.linearisation import QuadraticProgram
from verification.reference.search_direction import EqualityProblem, search_direction
from verification.reference.tuning import Tuning


def unconstrained(qp: QuadraticProgram, tuning: Tuning) -> list[Iteration]:
    """Return the one step of UMHE, as an iteration with kappa = 0, step length 1 and no margin to lose."""
    Q_bar = np.tile(tuning.Q, (len(qp.u), 1))
    problem = EqualityProblem(tuning.P, qp.A, tuning.t_s, qp.C, Q_bar, tuning.R, np.zeros(4), qp.r_u, qp.r_y, -qp.f)
    dx, du = search_direction(problem)
    start = np.zeros_like(dx), np.zeros_like(du)
    return [Iteration(0.0, *start, dx, du, 0.0, 1.0, np.inf, dx, du)]
