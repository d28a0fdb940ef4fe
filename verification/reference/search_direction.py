"""Algorithm 2 of paper 004: the search direction, by a Riccati recursion over the window.

Corrected: the backward loop runs to l, not to 0, with the test i > l. The rest is right as printed.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from verification.reference.arrays import Array


@dataclass(frozen=True)
class EqualityProblem:
    """The linear least-squares problem (45), with N samples and m rows of C_bar.

    Diagonal matrices are given by their diagonals.
    """

    P: Array  # (4,)
    A: Array  # (N - 1, 4, 4)
    B: float  # B = t_s I
    C_bar: Array  # (N, m, 4)
    Q_bar: Array  # (N - 1, 4)
    R_bar: Array  # (m,)
    r_x: Array  # (4,)
    r_u: Array  # (N - 1, 4)
    r_y: Array  # (N, m)
    r_p: Array  # (N - 1, 4)


def search_direction(problem: EqualityProblem) -> tuple[Array, Array]:
    """Solve (45) by Algorithm 2; return (Delta^2 x, Delta^2 u), of shapes (N, 4) and (N - 1, 4)."""
    A, B, C = problem.A, problem.B, problem.C_bar
    last = len(C) - 1  # i = k; i = l is 0
    R_bar = np.diag(problem.R_bar)

    # Lines 1 to 9: Riccati recursion based factorization
    Pi, Omega, K, P_f = [], [], [], []
    P_hat = np.diag(problem.P)  # 2
    for i in range(last + 1):
        Pi.append(C[i] @ P_hat)  # 4
        Xi = np.linalg.inv(R_bar + Pi[i] @ C[i].T)
        Omega.append(C[i].T @ Xi)
        K.append(P_hat @ Omega[i])  # 5
        P_f.append(P_hat - K[i] @ Pi[i])
        if i < last:
            P_hat = A[i] @ P_f[i] @ A[i].T + np.diag(B * problem.Q_bar[i] * B)  # 7

    # Lines 10 to 18: forward recursion
    innovation, x, u = [], [], []
    x_hat = problem.r_x  # 11
    for i in range(last + 1):
        innovation.append(problem.r_y[i] - C[i] @ x_hat)  # 13
        x.append(x_hat + K[i] @ innovation[i])
        if i < last:
            u.append(problem.r_u[i])  # 15
            x_hat = -problem.r_p[i] + A[i] @ x[i] + B * u[i]  # 16

    # Lines 19 to 27: backward recursion
    multiplier = -Omega[last] @ innovation[last]  # 20
    for i in range(last - 1, -1, -1):
        xi = A[i].T @ multiplier  # 22
        u[i] = u[i] - problem.Q_bar[i] * B * multiplier
        x[i] = x[i] - P_f[i] @ xi  # 23
        if i > 0:
            multiplier = xi - Omega[i] @ (innovation[i] + Pi[i] @ xi)  # 25
    return np.array(x), np.array(u)
