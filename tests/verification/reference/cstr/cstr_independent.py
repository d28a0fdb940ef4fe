"""Independent solutions for paper 001: casadi's derivatives, IPOPT on the windows, the model written anew.

Nothing here uses the reference's formulas.
"""

from __future__ import annotations

import casadi as ca
import numpy as np

QUIET = {"ipopt.print_level": 0, "print_time": False, "ipopt.sb": "yes"}
TIGHT = {"ipopt.tol": 1e-10, "ipopt.constr_viol_tol": 1e-12, "ipopt.bound_relax_factor": 0.0, "ipopt.max_iter": 500}


def rates(x, u, sign=1.0, alpha=1.95e-4, theta=20.0):
    """The right-hand sides by Hicks and Ray; sign -1 gives those that paper 001 prints."""
    reaction = 300.0 * x[0] * ca.exp(-5.0 / x[1])
    dx1 = (1.0 - x[0]) / theta - reaction
    dx2 = (0.395 - x[1]) / theta + reaction - alpha * u * (x[1] - 0.38)
    return sign * ca.vertcat(dx1, dx2)


def half_cost(x, x_bar, y, u, tuning, noises=True):
    """J/2 of (3), (4) of the states x, a list of n symbols (2,), and the transitions' noises."""
    P, q, R = tuning.p, (tuning.sigma_w1**-2, tuning.sigma_w2**-2), tuning.sigma_y**-2
    J = 0.5 * P * ca.sumsqr(x[0] - x_bar)
    w = [(x[i + 1] - x[i]) / tuning.h - rates(x[i + 1], u[i]) for i in range(len(x) - 1)]
    if noises:
        J += sum(0.5 * (q[0] * w_i[0] ** 2 + q[1] * w_i[1] ** 2) for w_i in w)
    return J + sum(0.5 * R * (x_i[1] - y_i) ** 2 for x_i, y_i in zip(x, ca.vertsplit(ca.DM(y)), strict=True)), w


def derivatives(point, x_bar, y, u, tuning):
    """Value, gradient and Hessian of J/2 with noises by automatic differentiation, at states of shape (n, 2)."""
    n = len(point)
    z = ca.SX.sym("z", 2 * n)
    J, _ = half_cost(states(z, n), x_bar, y, u, tuning)
    H, g = ca.hessian(J, z)
    value, gradient, hessian = ca.Function("d", [z], [J, g, H])(np.ravel(point))
    return float(value), np.array(gradient).reshape(n, 2), np.array(hessian)


def states(z, n):
    return [z[2 * i : 2 * i + 2] for i in range(n)]


def euler_step(x, u, h):
    """x+ of implicit Euler by casadi's root finder on both equations together."""
    z, p = ca.SX.sym("z", 2), ca.SX.sym("p", 3)
    residual = z - p[:2] - h * rates(z, p[2])
    solver = ca.rootfinder("s", "newton", {"x": z, "p": p, "g": residual}, {"abstol": 1e-14})
    return np.array(solver(x, [*x, u])).ravel()


def shooting_half_cost(x_bar, y, u, tuning):
    """J/2 without noises as a casadi function of the first state, and its gradient and Hessian."""
    z, p = ca.SX.sym("z", 2), ca.SX.sym("p", 3)
    solver = ca.rootfinder(
        "s", "newton", {"x": z, "p": p, "g": z - p[:2] - tuning.h * rates(z, p[2])}, {"abstol": 1e-14}
    )
    first = ca.MX.sym("first", 2)
    x = [first]
    for u_i in u:
        x.append(solver(x[-1], ca.vertcat(x[-1], u_i)))
    J = 0.5 * tuning.p * ca.sumsqr(first - x_bar)
    J += sum(0.5 * tuning.sigma_y**-2 * (x_i[1] - float(y_i)) ** 2 for x_i, y_i in zip(x, y, strict=True))
    H, g = ca.hessian(J, first)
    return ca.Function("J", [first], [J, g, H])


def window_solver(n, tuning, noises=True):
    """Return a function from (guess, x_bar, y, u) to IPOPT's solution (n, 2) of the window of n samples."""
    z, x_bar, y, u = ca.SX.sym("z", 2 * n), ca.SX.sym("x_bar", 2), ca.SX.sym("y", n), ca.SX.sym("u", n - 1)
    x = states(z, n)
    P, q, R = tuning.p, (tuning.sigma_w1**-2, tuning.sigma_w2**-2), tuning.sigma_y**-2
    J = 0.5 * P * ca.sumsqr(x[0] - x_bar) + sum(0.5 * R * (x[i][1] - y[i]) ** 2 for i in range(n))
    w = [(x[i + 1] - x[i]) / tuning.h - rates(x[i + 1], u[i]) for i in range(n - 1)]
    problem = {"x": z, "p": ca.vertcat(x_bar, y, u), "f": J}
    bounded = n if noises else 1
    if noises:
        problem["f"] = J + sum(0.5 * (q[0] * w_i[0] ** 2 + q[1] * w_i[1] ** 2) for w_i in w)
    else:
        problem["g"] = ca.vertcat(*w)
    solver = ca.nlpsol("ipopt", "ipopt", problem, QUIET | TIGHT)
    lower = np.concatenate([np.tile([tuning.x1_min, tuning.x2_min], bounded), np.full(2 * (n - bounded), -np.inf)])
    upper = np.concatenate([np.tile([tuning.x1_max, tuning.x2_max], bounded), np.full(2 * (n - bounded), np.inf)])

    def solve(guess, x_bar_value, y_value, u_value):
        p = np.concatenate([x_bar_value, y_value, u_value])
        found = solver(x0=np.ravel(guess), p=p, lbx=lower, ubx=upper, lbg=0.0, ubg=0.0)
        assert solver.stats()["success"], solver.stats()["return_status"]
        return np.array(found["x"]).reshape(n, 2)

    return solve
