"""Algorithm 1 of paper 004: the primal barrier method for (42), four iterations.

Corrected: (46a,b) over all four entries; (46d) times Q_bar; (46e) with Delta x_i; kappa falls when
(j + 1) is a multiple of n_QP; the line search keeps strictly inside.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from verification.reference.arrays import Array
from verification.reference.barrier import Room, gradient, reach, room, root_hessian, strictly_inside
from verification.reference.linearisation import QuadraticProgram
from verification.reference.search_direction import EqualityProblem, search_direction
from verification.reference.tuning import Tuning


@dataclass(frozen=True)
class Iteration:
    """One pass of Algorithm 1 (or the one step of UMHE)."""

    kappa: float
    dx_before: Array  # (N, 4), Delta x^- at the start
    du_before: Array  # (N - 1, 4)
    direction_x: Array  # (N, 4), Delta^2 x
    direction_u: Array  # (N - 1, 4), Delta^2 u
    v: float  # the step length is the largest 2^-n with v 2^-n < 1
    s: float  # step length
    margin: float  # least |v / 2^n - 1|: how near the line search was to another step length
    dx: Array  # (N, 4), Delta x^- at the end
    du: Array  # (N - 1, 4)


def newton_problem(
    qp: QuadraticProgram, dx: Array, du: Array, kappa: float, rooms: tuple[Room, Room], tuning: Tuning
) -> EqualityProblem:
    """Return (45) with the quantities (46): the linearised KKT system of (43) at (dx, du)."""
    dx1, dx2 = rooms[0].distances(dx)
    du1, du2 = rooms[1].distances(du)
    g_x, g_u = gradient(dx1, dx2), gradient(du1, du2)  # (46a)
    L_x, L_u = root_hessian(dx1, dx2), root_hessian(du1, du2)  # (46b)
    root_kappa = np.sqrt(kappa)

    r_p = -qp.f - apply(qp.A, dx[:-1]) - tuning.t_s * du + dx[1:]  # (46c)
    Q_bar = 1.0 / (1.0 / tuning.Q + kappa * L_u**2)  # (46f)
    r_u = Q_bar * ((qp.r_u - du) / tuning.Q - kappa * g_u)  # (46d), times Q_bar
    r_y = np.hstack([qp.r_y - apply(qp.C, dx), -root_kappa * g_x / L_x])  # (46e), Delta x_i
    C_bar = np.concatenate([qp.C, root_kappa * L_x[:, :, None] * np.eye(4)], axis=1)
    R_bar = np.concatenate([tuning.R, np.ones(4)])  # (46f)
    return EqualityProblem(tuning.P, qp.A, tuning.t_s, C_bar, Q_bar, R_bar, -dx[0], r_u, r_y, r_p)


def apply(matrices: Array, vectors: Array) -> Array:
    """Return M_i v_i for a stack of matrices (n, m, 4) and of vectors (n, 4)."""
    product: Array = np.einsum("imn,in->im", matrices, vectors)
    return product


def line_search(direction: tuple[Array, Array], distances: list[tuple[Array, Array]], n_s_max: int) -> float:
    """Return the largest 2^-n, n = 0 to n_s_max, that keeps x and u strictly inside, or else 0."""
    for n in range(n_s_max + 1):
        s = 2.0**-n
        inside = (strictly_inside(s * d, *room) for d, room in zip(direction, distances, strict=True))
        if all(inside):
            return s
    return 0.0


def interior_point(qp: QuadraticProgram, tuning: Tuning) -> list[Iteration]:
    """Run Algorithm 1 on (42); the last iteration's (dx, du) is the solution handed on."""
    rooms = (
        room(qp.x, tuning.x_lower, tuning.x_upper, tuning.distance_floor),
        room(qp.u, tuning.u_lower, tuning.u_upper, tuning.distance_floor),
    )
    dx, du = np.zeros_like(qp.x), np.zeros_like(qp.u)
    kappa = tuning.kappa_init
    iterations = []
    for j in range(tuning.n_kappa * tuning.n_qp):
        problem = newton_problem(qp, dx, du, kappa, rooms, tuning)
        direction = search_direction(problem)
        distances = [rooms[0].distances(dx), rooms[1].distances(du)]
        v = max(reach(d, *room) for d, room in zip(direction, distances, strict=True))
        s = line_search(direction, distances, tuning.n_s_max)
        margin = float(np.abs(v * 2.0 ** -np.arange(tuning.n_s_max + 1.0) - 1.0).min())
        before = dx, du
        dx, du = dx + s * direction[0], du + s * direction[1]
        iterations.append(Iteration(kappa, *before, *direction, v, s, margin, dx, du))
        if (j + 1) % tuning.n_qp == 0:
            kappa *= tuning.kappa_factor
    return iterations
