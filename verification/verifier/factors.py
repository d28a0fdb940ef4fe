"""What the reference's Algorithm 2 holds inside: recomputed from its trace, for comparison with the sheets' wires.

The reference hands out what each pass of Algorithm 1 begins and ends with. The gains and covariances between are
computed here once more from (45), with the plain inverse instead of the sheets' inverse by blocks.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from verification.reference.arrays import Array
from verification.reference.barrier import room
from verification.reference.estimator import Trace
from verification.reference.interior_point import newton_problem
from verification.reference.search_direction import EqualityProblem
from verification.reference.tuning import Tuning


@dataclass(frozen=True)
class Factors:
    """The factorization of (45), Algorithm 2 lines 1 to 9, for samples l to k."""

    C_bar: Array  # (N, 8, 4)
    r_y: Array  # (N, 8)
    Q_bar: Array  # (N - 1, 4)
    r_u: Array  # (N - 1, 4)
    r_p: Array  # (N - 1, 4)
    Pi: Array  # (N, 8, 4)
    K: Array  # (N, 4, 8)
    P_f: Array  # (N, 4, 4)


def factors(problem: EqualityProblem) -> Factors:
    """Return the factorization of one problem (45)."""
    P_hat = np.diag(problem.P)
    Pi, K, P_f = [], [], []
    for i, C in enumerate(problem.C_bar):
        Pi.append(C @ P_hat)
        K.append(np.linalg.solve(np.diag(problem.R_bar) + Pi[i] @ C.T, Pi[i]).T)
        P_f.append(P_hat - K[i] @ Pi[i])
        if i < len(problem.A):
            A = problem.A[i]
            P_hat = A @ P_f[i] @ A.T + np.diag(problem.B**2 * problem.Q_bar[i])
    return Factors(
        np.asarray(problem.C_bar),
        problem.r_y,
        problem.Q_bar,
        problem.r_u,
        problem.r_p,
        np.array(Pi),
        np.array(K),
        np.array(P_f),
    )


def constrained_factors(trace: Trace, tuning: Tuning) -> list[Factors]:
    """Return the factorization of every pass of Algorithm 1."""
    qp = trace.qp
    rooms = (
        room(qp.x, tuning.x_lower, tuning.x_upper, tuning.distance_floor),
        room(qp.u, tuning.u_lower, tuning.u_upper, tuning.distance_floor),
    )
    problems = (newton_problem(qp, i.dx_before, i.du_before, i.kappa, rooms, tuning) for i in trace.iterations)
    return [factors(problem) for problem in problems]


def unconstrained_factors(trace: Trace, tuning: Tuning) -> list[Factors]:
    """Return the factorization of UMHE's one step, with rows of 0 where CMHE's barriers stand, as in the sheet."""
    qp = trace.qp
    Q_bar = np.tile(tuning.Q, (len(qp.u), 1))
    C_bar = np.concatenate([qp.C, np.zeros_like(qp.C)], axis=1)
    R_bar = np.concatenate([tuning.R, np.ones(4)])
    r_y = np.hstack([qp.r_y, np.zeros_like(qp.r_y)])
    problem = EqualityProblem(tuning.P, qp.A, tuning.t_s, C_bar, Q_bar, R_bar, np.zeros(4), qp.r_u, r_y, -qp.f)
    return [factors(problem)]
