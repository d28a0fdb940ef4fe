"""Independent solutions to compare the reference with: casadi's derivatives, dense KKT systems, quadprog.

Nothing here uses the reference's formulas: the model is written again from the paper with casadi symbols,
the Newton step comes from the derivatives of the barrier problem (43), not from the least-squares form (45).
"""

from __future__ import annotations

import casadi as ca
import numpy as np
import quadprog
from flint import arb_mat, ctx

N, NX, NU = 3, 4, 4
SIZE = N * NX + (N - 1) * NU


# The model, from (11), (13) to (16), (20) of the paper, V_z = -V_g sin(alpha - theta) - W_z


def symbolic_model(t_s):
    """Return casadi functions F(x, u, Theta), h(x, Theta) and their Jacobians by automatic differentiation."""
    x, u, p = ca.SX.sym("x", 4), ca.SX.sym("u", 4), ca.SX.sym("p", 6)
    alpha, v_g, w_x, w_z = ca.vertsplit(x)
    v_gm, theta, q, a_x, a_z, z = ca.vertsplit(p)
    g = 9.80665
    f_alpha = -a_x * ca.sin(alpha) + a_z * ca.cos(alpha) + g * ca.cos(alpha - theta)
    f_v = a_x * ca.cos(alpha) + a_z * ca.sin(alpha) + g * ca.sin(alpha - theta)
    F = ca.vertcat(
        alpha + t_s * (f_alpha / v_gm + q) + t_s * u[0],
        v_g + t_s * f_v + t_s * u[1],
        w_x + t_s * u[2],
        w_z + t_s * u[3],
    )
    v_t = -w_x * ca.cos(alpha - theta) - w_z * ca.sin(alpha - theta) + v_gm
    R, T_0, gamma, L = 287.05287, 288.15, 1.4, -6.5e-3
    T = T_0 + L * z
    p_bar = (1 + L / T_0 * z) ** (g / (-R * L))
    pressure = ((1 + v_t**2 / (5 * gamma * R * T)) ** 3.5 - 1) * p_bar + 1
    v_c = ca.sqrt(5 * gamma * R * T_0) * ca.sqrt(pressure ** (1 / 3.5) - 1)
    h = ca.vertcat(v_g, -v_gm * ca.sin(alpha - theta) - w_z, alpha, v_c)
    return {
        "F": ca.Function("F", [x, u, p], [F]),
        "A": ca.Function("A", [x, u, p], [ca.jacobian(F, x)]),
        "B": ca.Function("B", [x, u, p], [ca.jacobian(F, u)]),
        "h": ca.Function("h", [x, p], [h]),
        "C": ca.Function("C", [x, p], [ca.jacobian(h, x)]),
    }


# The barrier problem (43)


def unpack(z):
    """Split (dx_l, dx_{l+1}, dx_k, du_l, du_{k-1}) into dx (3, 4) and du (2, 4)."""
    return np.reshape(z[:12], (3, 4)), np.reshape(z[12:], (2, 4))


def newton_system(qp, dx, du, kappa, tuning):
    """Return Hessian, gradient, Jacobian and value of the equality constraints of (43) at (dx, du)."""
    H, g = np.zeros((SIZE, SIZE)), np.zeros(SIZE)
    H[:4, :4] += np.diag(1 / tuning.P)
    g[:4] += dx[0] / tuning.P
    for i in range(N):
        s = slice(4 * i, 4 * i + 4)
        C_scaled = qp.C[i] / tuning.R[:, None]
        H[s, s] += qp.C[i].T @ C_scaled
        g[s] -= C_scaled.T @ (qp.r_y[i] - qp.C[i] @ dx[i])
        _add_barrier(H, g, s, qp.x[i], dx[i], tuning.x_lower, tuning.x_upper, kappa)
    for i in range(N - 1):
        s = slice(12 + 4 * i, 16 + 4 * i)
        H[s, s] += np.diag(1 / tuning.Q)
        g[s] -= (qp.r_u[i] - du[i]) / tuning.Q
        _add_barrier(H, g, s, qp.u[i], du[i], tuning.u_lower, tuning.u_upper, kappa)
    J, c = constraints(qp)
    return H, g, J, c + J @ np.concatenate([dx.ravel(), du.ravel()])


def _add_barrier(H, g, s, point, step, lower, upper, kappa):
    if kappa == 0.0:
        return
    above, below = (upper - point) - step, step - (lower - point)
    g[s] += kappa * (1 / above - 1 / below)
    H[s, s] += kappa * np.diag(1 / above**2 + 1 / below**2)


def constraints(qp, t_s=0.048):
    """Return J and c of the equality constraints J z + c = 0 of (42b)."""
    J, c = np.zeros((8, SIZE)), np.zeros(8)
    for i in range(N - 1):
        rows = slice(4 * i, 4 * i + 4)
        J[rows, 4 * i : 4 * i + 4] = qp.A[i]
        J[rows, 4 * i + 4 : 4 * i + 8] = -np.eye(4)
        J[rows, 12 + 4 * i : 16 + 4 * i] = t_s * np.eye(4)
        c[rows] = qp.f[i]
    return J, c


def solve_kkt(H, g, J, c, digits=40):
    """Solve the dense KKT system of a quadratic program with equalities, in `digits`-digit ball arithmetic."""
    n, m = len(g), len(c)
    K = np.block([[H, J.T], [J, np.zeros((m, m))]])
    ctx.prec = int(3.33 * digits)
    solution = arb_mat(K.tolist()).solve(arb_mat([[-float(v)] for v in np.concatenate([g, c])]))
    return unpack(np.array([float(solution[i, 0]) for i in range(n)]))


def newton_step(qp, dx, du, kappa, tuning):
    """Return the Newton step of (43) at (dx, du), from a dense KKT system at 40 digits."""
    return solve_kkt(*newton_system(qp, dx, du, kappa, tuning))


def symbolic_barrier_derivatives(qp, dx, du, kappa, tuning):
    """Return Hessian and gradient of (43), with its logarithms, by automatic differentiation."""
    z = ca.SX.sym("z", SIZE)
    cost = 0.5 * ca.dot(z[:4] / tuning.P, z[:4])
    phi = 0
    for i in range(N):
        x = z[4 * i : 4 * i + 4]
        r = qp.r_y[i] - qp.C[i] @ x
        cost += 0.5 * ca.dot(r / tuning.R, r)
        phi -= ca.sum1(ca.log(tuning.x_upper - qp.x[i] - x) + ca.log(x - (tuning.x_lower - qp.x[i])))
    for i in range(N - 1):
        u = z[12 + 4 * i : 16 + 4 * i]
        r = qp.r_u[i] - u
        cost += 0.5 * ca.dot(r / tuning.Q, r)
        phi -= ca.sum1(ca.log(tuning.u_upper - qp.u[i] - u) + ca.log(u - (tuning.u_lower - qp.u[i])))
    H, g = ca.hessian(cost + kappa * phi, z)
    function = ca.Function("d", [z], [H, g])
    H, g = function(np.concatenate([dx.ravel(), du.ravel()]))
    return np.array(H), np.array(g).ravel()


# The quadratic program (42)


def condensed(qp, tuning):
    """Return z = S w + s0 with the free w = (dx_l, du_l, du_{k-1}): (42b)'s equalities eliminated."""
    S, s0 = np.zeros((SIZE, 12)), np.zeros(SIZE)
    S[:4, :4] = np.eye(4)
    S[12:, 4:] = np.eye(8)
    for i in range(N - 1):
        now, after, u = slice(4 * i, 4 * i + 4), slice(4 * i + 4, 4 * i + 8), slice(12 + 4 * i, 16 + 4 * i)
        S[after] = qp.A[i] @ S[now] + tuning.t_s * S[u]
        s0[after] = qp.A[i] @ s0[now] + qp.f[i]
    return S, s0


def bounds(qp, tuning):
    """Return the bounds of z in (42b)."""
    lower = np.concatenate([(tuning.x_lower - qp.x).ravel(), (tuning.u_lower - qp.u).ravel()])
    upper = np.concatenate([(tuning.x_upper - qp.x).ravel(), (tuning.u_upper - qp.u).ravel()])
    return lower, upper


def solve_inequality_qp(qp, tuning):
    """Solve (42) with all its bounds by quadprog (Goldfarb-Idnani); return dx, du and the active bounds."""
    zero = np.zeros((3, 4)), np.zeros((2, 4))
    H, g, _, _ = newton_system(qp, *zero, 0.0, tuning)
    S, s0 = condensed(qp, tuning)
    lower, upper = bounds(qp, tuning)
    scale = np.concatenate([np.sqrt(tuning.P), np.sqrt(tuning.Q), np.sqrt(tuning.Q)])
    T = S * scale
    G = np.vstack([T, -T])
    b = np.concatenate([lower - s0, s0 - upper])
    rows = np.linalg.norm(G, axis=1)
    used = rows > 0
    w, *_, active = quadprog.solve_qp(
        T.T @ H @ T, -T.T @ (g + H @ s0), (G[used] / rows[used, None]).T, b[used] / rows[used]
    )
    chosen = np.flatnonzero(used)[active[active > 0] - 1]
    return (*unpack(T @ w + s0), {int(i) % SIZE for i in chosen})


def least_squares(qp, tuning):
    """Solve (42) without inequalities as one whitened dense least-squares problem (numpy's lstsq)."""
    S, s0 = condensed(qp, tuning)
    rows, right = [np.eye(SIZE)[:4] / np.sqrt(tuning.P)[:, None]], [np.zeros(4)]
    for i in range(N):
        block = np.zeros((4, SIZE))
        block[:, 4 * i : 4 * i + 4] = qp.C[i]
        rows.append(block / np.sqrt(tuning.R)[:, None])
        right.append(qp.r_y[i] / np.sqrt(tuning.R))
    for i in range(N - 1):
        block = np.eye(SIZE)[12 + 4 * i : 16 + 4 * i]
        rows.append(block / np.sqrt(tuning.Q)[:, None])
        right.append(qp.r_u[i] / np.sqrt(tuning.Q))
    M, r = np.vstack(rows), np.concatenate(right)
    scale = np.concatenate([np.sqrt(tuning.P), np.sqrt(tuning.Q), np.sqrt(tuning.Q)])
    w = np.linalg.lstsq(M @ S * scale, r - M @ s0, rcond=None)[0]
    return unpack(S @ (scale * w) + s0)
