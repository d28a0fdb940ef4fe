"""The formulas of paper 004 as printed, where they are wrong. Used to show that they disagree, nowhere else."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from verification.reference import model
from verification.reference.barrier import gradient, root_hessian
from verification.reference.interior_point import newton_problem


def output_15(x, theta, tuning):
    """(15) with + W_z."""
    y, C = model.output(x, theta, tuning)
    y, C = y.copy(), C.copy()
    y[..., 1] += 2.0 * x[..., 3]
    C[..., 1, 3] = 1.0
    return y, C


def defect_42(x, u, theta, tuning):
    """f_i below (42): x_i - x_{i+1} + t_s F(x_i, u_i, Theta_i), with F the discrete map of (20)."""
    return x[:-1] - x[1:] + tuning.t_s * model.transition(x[:-1], u, theta[:-1], tuning)


def newton_problem_46ab(qp, dx, du, kappa, rooms, tuning):
    """(46a), (46b) with j = 1, 2, 3: the fourth entries have no barrier."""
    problem = newton_problem(qp, dx, du, kappa, rooms, tuning)
    C_bar, r_y = problem.C_bar.copy(), problem.r_y.copy()
    C_bar[:, 7, 3], r_y[:, 7] = 0.0, 0.0
    Q_bar, r_u = problem.Q_bar.copy(), problem.r_u.copy()
    Q_bar[:, 3] = tuning.Q[3]
    r_u[:, 3] = qp.r_u[:, 3] - du[:, 3]
    return replace(problem, C_bar=C_bar, r_y=r_y, Q_bar=Q_bar, r_u=r_u)


def newton_problem_46d(qp, dx, du, kappa, rooms, tuning):
    """(46d) without Q_bar."""
    problem = newton_problem(qp, dx, du, kappa, rooms, tuning)
    return replace(problem, r_u=problem.r_u / problem.Q_bar)


def newton_problem_46e(qp, dx, du, kappa, rooms, tuning):
    """(46e) with C_i Delta x_l."""
    problem = newton_problem(qp, dx, du, kappa, rooms, tuning)
    d1, d2 = rooms[0].distances(dx)
    lower = -np.sqrt(kappa) * gradient(d1, d2) / root_hessian(d1, d2)
    return replace(problem, r_y=np.hstack([qp.r_y - np.einsum("imn,n->im", qp.C, dx[0]), lower]))


def kappas_algorithm_1(kappa_init, n_kappa, n_qp):
    """kappa of each iteration, falling after every j that is a multiple of n_kappa."""
    kappa, kappas = kappa_init, []
    for j in range(n_kappa * n_qp):
        kappas.append(kappa)
        if j % n_kappa == 0:
            kappa *= 0.1
    return kappas


def inside_algorithm_1(step, d1, d2):
    """The line search's test with <=."""
    return bool((step <= d1).all() and (-step <= d2).all())


def backward_recursion_algorithm_2(first, last, A, Q_bar, B, P_f, Omega, Pi, innovation, x, u):
    """Lines 20 to 27, in the absolute index i = l ... k of the paper; dictionaries hold what exists."""
    multiplier = -Omega[last] @ innovation[last]
    for i in range(last - 1, first - 1, -1):
        xi = A[i].T @ multiplier
        u[i] = u[i] - Q_bar[i] * B * multiplier
        x[i] = x[i] - P_f[i] @ xi
        if i > first:
            multiplier = xi - Omega[i] @ (innovation[i] + Pi[i] @ xi)
    return x, u


def gauss_newton_hessian_31(J1, V):
    """H = J1' V J1, below (31)."""
    return J1.T @ (V[:, None] * J1)
