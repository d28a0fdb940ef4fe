"""Every step of the reference against independent solutions."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from independent_solution import (
    least_squares,
    newton_step,
    newton_system,
    solve_inequality_qp,
    symbolic_barrier_derivatives,
    symbolic_model,
)
from reference_cases import (
    SIGMA_U,
    SIGMA_X,
    TUNING,
    error,
    random_point,
    random_qp,
    random_theta,
    realistic_traces,
    step_error,
)

from verification.reference import umhe_fte
from verification.reference.interior_point import interior_point
from verification.reference.model import output, transition, transition_jacobian
from verification.reference.unconstrained import unconstrained


def test_model_and_jacobians_equal_automatic_differentiation():
    generator = np.random.default_rng(5)
    model = symbolic_model(TUNING.t_s)
    x = random_point(generator, TUNING.x_lower, TUNING.x_upper, 200)
    x[:, 2:] *= 0.9
    u = random_point(generator, TUNING.u_lower, TUNING.u_upper, 200)
    theta = random_theta(generator, 200)
    F, A = transition(x, u, theta, TUNING), transition_jacobian(x, theta, TUNING)
    h, C = output(x, theta, TUNING)
    inside = 0
    for i in range(200):
        v_t = theta[i, 0] - np.hypot(*x[i, 2:])
        assert error(F[i], np.array(model["F"](x[i], u[i], theta[i])).ravel(), 1e-3) < 1e-12
        assert error(A[i], np.array(model["A"](x[i], u[i], theta[i])), 1e-3) < 1e-12
        np.testing.assert_allclose(np.array(model["B"](x[i], u[i], theta[i])), TUNING.t_s * np.eye(4))
        if v_t > TUNING.vt_min and theta[i, 0] + np.hypot(*x[i, 2:]) < TUNING.vt_max:  # not saturated
            inside += 1
            assert error(h[i], np.array(model["h"](x[i], theta[i])).ravel(), 1e-3) < 1e-12
            assert error(C[i], np.array(model["C"](x[i], theta[i])), 1e-3) < 1e-11
    assert inside > 150


@pytest.mark.parametrize("seed", range(4))
def test_the_newton_system_is_that_of_the_logarithmic_barrier(seed):
    qp = random_qp(seed)
    dx, du = np.zeros((3, 4)), np.zeros((2, 4))
    H, g, _, _ = newton_system(qp, dx, du, 0.1, TUNING)
    H_ad, g_ad = symbolic_barrier_derivatives(qp, dx, du, 0.1, TUNING)
    assert np.abs(H - H_ad).max() <= 1e-9 * np.abs(H_ad).max()
    np.testing.assert_allclose(np.diag(H), np.diag(H_ad), rtol=1e-9)
    np.testing.assert_allclose(g, g_ad, rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize("seed", range(16))
def test_interior_point_steps_equal_dense_newton_steps_at_random_states(seed):
    qp = random_qp(seed)
    for iteration in interior_point(qp, TUNING):
        right = newton_step(qp, iteration.dx_before, iteration.du_before, iteration.kappa, TUNING)
        assert step_error((iteration.direction_x, iteration.direction_u), right) < 1e-9


def test_interior_point_steps_equal_dense_newton_steps_on_flights():
    configurations, active, checked = set(), 0, 0
    for trace in realistic_traces():
        configurations.add(trace.fused.configuration)
        width = TUNING.x_upper - TUNING.x_lower
        gap = np.minimum(TUNING.x_upper - trace.x, trace.x - TUNING.x_lower) / width
        active += bool((gap < 1e-3).any())
        for iteration in trace.iterations:
            right = newton_step(trace.qp, iteration.dx_before, iteration.du_before, iteration.kappa, TUNING)
            assert step_error((iteration.direction_x, iteration.direction_u), right) < 1e-9
            checked += 1
    assert configurations == {1, 2, 3, 4}
    assert active >= 10
    assert checked >= 150


def test_the_line_search_takes_the_longest_step_strictly_inside():
    halved = 0
    for qp in [random_qp(seed) for seed in range(40)]:
        for it in interior_point(qp, TUNING):
            room = [
                ((TUNING.x_upper - qp.x, TUNING.x_lower - qp.x), it.dx_before, it.direction_x),
                ((TUNING.u_upper - qp.u, TUNING.u_lower - qp.u), it.du_before, it.direction_u),
            ]
            steps = [
                s
                for s in 0.5 ** np.arange(TUNING.n_s_max + 1)
                if all(((a + s * d < ub) & (a + s * d > lb)).all() for (ub, lb), a, d in room)
            ]
            assert it.s == max(steps, default=0.0)
            assert it.margin > 0.0
            lengths = [1.0 if it.v < 1.0 else 0.0] + [2.0**-n for n in range(1, 9) if it.v < 2.0**n]
            assert it.s == max(lengths)  # the form of the sheet: a hold-left table over v
            np.testing.assert_array_equal(it.dx, it.dx_before + it.s * it.direction_x)
            np.testing.assert_array_equal(it.du, it.du_before + it.s * it.direction_u)
            halved += it.s < 1.0
    assert halved >= 20


def test_many_iterations_converge_to_the_solution_of_the_quadratic_program():
    patient = replace(TUNING, kappa_factor=0.4, n_kappa=20, n_qp=6, n_s_max=40, distance_floor=1e-15)
    active_bounds = set()
    for trace in realistic_traces()[5::3][:10]:
        dx, du, active = solve_inequality_qp(trace.qp, TUNING)
        last = interior_point(trace.qp, patient)[-1]
        # where a bound is only just active the barrier keeps away from it by about sigma sqrt(kappa)
        assert error(last.dx, dx, SIGMA_X) < 2 * np.sqrt(last.kappa)
        assert error(last.du, du, SIGMA_U) < 2 * np.sqrt(last.kappa)
        active_bounds |= active
    assert {10} <= active_bounds  # W_x of the newest sample, at least, was at its bound


def test_four_iterations_come_near_the_solution_of_the_quadratic_program():
    errors = []
    for trace in realistic_traces():
        dx, _, _ = solve_inequality_qp(trace.qp, TUNING)
        errors.append(error(trace.iterations[-1].dx, dx, SIGMA_X))
    assert np.median(errors) < 0.02
    assert np.quantile(errors, 0.9) < 1.0


@pytest.mark.parametrize("seed", range(8))
def test_umhe_step_equals_dense_least_squares_at_random_states(seed):
    qp = random_qp(seed)
    (iteration,) = unconstrained(qp, TUNING)
    assert step_error((iteration.dx, iteration.du), least_squares(qp, TUNING)) < 1e-9


def test_umhe_step_equals_dense_least_squares_on_flights():
    configurations = set()
    for trace in realistic_traces(umhe_fte):
        configurations.add(trace.fused.configuration)
        (iteration,) = trace.iterations
        assert step_error((iteration.dx, iteration.du), least_squares(trace.qp, TUNING)) < 1e-9
    assert configurations >= {1, 2}


def test_the_linearised_window_is_that_of_the_nonlinear_problem():
    model = symbolic_model(TUNING.t_s)
    for trace in realistic_traces()[::6]:
        qp, theta = trace.qp, trace.window.theta
        for i in range(2):
            defect = np.array(model["F"](qp.x[i], qp.u[i], theta[i])).ravel() - qp.x[i + 1]
            np.testing.assert_allclose(qp.f[i], defect, atol=1e-12)
            np.testing.assert_allclose(qp.A[i], np.array(model["A"](qp.x[i], qp.u[i], theta[i])), atol=1e-12)
        for i in range(3):
            mask = trace.window.row_mask[i]
            np.testing.assert_allclose(qp.C[i], mask[:, None] * np.array(model["C"](qp.x[i], theta[i])), atol=1e-10)
            residual = trace.window.y[i] - np.array(model["h"](qp.x[i], theta[i])).ravel()
            np.testing.assert_allclose(qp.r_y[i], mask * residual, atol=1e-10)
