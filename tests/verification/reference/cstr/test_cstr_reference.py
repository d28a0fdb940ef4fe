"""Paper 001's reference against independent solutions: derivatives by casadi, minima by IPOPT, its neighbours by differences."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from cstr_independent import derivatives, euler_step, rates, shooting_half_cost, window_solver

from verification.plants.cstr import COOL, HOT, simulate
from verification.reference.cstr.algorithm_1 import estimate, estimate_first
from verification.reference.cstr.estimator import (
    ALGORITHM_1,
    ALGORITHM_1_WITHOUT,
    ALGORITHM_2,
    ALGORITHM_2_WITHOUT,
    frames,
)
from verification.reference.cstr.reactor import jacobian, right_hand_side, step, trajectory
from verification.reference.cstr.sensitivity import update, update_first
from verification.reference.cstr.shooting import expand_shooting, shooting_cost
from verification.reference.cstr.tuning import Tuning
from verification.reference.cstr.window import Information, cost, expand, noise

TUNING = Tuning()
CONVERGED = 60
"""Passes after which an estimate is at rounding."""


@cache
def run(seed=3, steps=120):
    return simulate(seed, steps=steps)


@cache
def estimates(method, seed=3, steps=120):
    return frames(run(seed, steps).recording, TUNING, method)


def information(t, x_bar, samples=TUNING.N + 1, seed=3):
    made = run(seed)
    return Information(x_bar, made.y[t - samples + 1 : t + 1], made.u[t - samples + 1 : t])


def random_window(generator, n=5):
    x = np.column_stack([generator.uniform(0.02, 0.6, n), generator.uniform(0.5, 0.9, n)])
    given = Information(generator.normal([0.15, 0.7], 0.05), generator.normal(x[:, 1], 0.02), generator.uniform(0, 900, n - 1))
    return x, given


# The model


def test_the_right_hand_sides_are_those_of_hicks_and_ray():
    generator = np.random.default_rng(1)
    for x, u in zip(generator.uniform([0, 0.3], [1, 1.2], (50, 2)), generator.uniform(0, 1500, 50), strict=True):
        np.testing.assert_allclose(right_hand_side(x, u, TUNING), np.array(rates(x, u)).ravel(), rtol=1e-13, atol=1e-15)
        difference = [
            (right_hand_side(x + e, u, TUNING) - right_hand_side(x - e, u, TUNING)) / 2e-6
            for e in 1e-6 * np.eye(2)
        ]
        np.testing.assert_allclose(jacobian(x, u, TUNING), np.transpose(difference), rtol=1e-7, atol=1e-7)


def test_a_step_solves_implicit_euler():
    """Both equations together by casadi's root finder; five Newton passes are enough on a run."""
    made = run()
    for t in range(0, 120, 7):
        right = euler_step(made.x[t], made.u[t], TUNING.h)
        np.testing.assert_allclose(step(made.x[t], made.u[t], TUNING), right, rtol=1e-9, atol=1e-12)
        np.testing.assert_allclose(step(made.x[t], made.u[t], TUNING, passes=60), right, rtol=1e-11)
    # and the plant: its noise is what the window's cost calls noise
    np.testing.assert_allclose(noise(made.x, made.u, TUNING), made.w, atol=1e-11)


def test_the_controller_holds_the_set_points_without_noise():
    quiet = simulate(1, noise=0.0)
    for point, t in ((HOT, 124), (COOL, 250)):
        np.testing.assert_allclose(quiet.x[t], [point.concentration, point.temperature], atol=2e-3)
    assert quiet.x[0] == pytest.approx([COOL.concentration, COOL.temperature])


# The cost


def test_the_cost_and_its_derivatives_equal_automatic_differentiation():
    generator = np.random.default_rng(2)
    for _ in range(8):
        x, given = random_window(generator)
        value, gradient, hessian = derivatives(x, given.x_bar, given.y, given.u, TUNING)
        at = expand(x, given, TUNING)
        assert pytest.approx(2 * value, rel=1e-12) == at.J
        assert cost(x, given, TUNING) == at.J
        np.testing.assert_allclose(at.gradient, gradient, rtol=1e-10, atol=1e-10 * np.abs(gradient).max())
        np.testing.assert_allclose(at.hessian, hessian, rtol=1e-10, atol=1e-10 * np.abs(hessian).max())
        assert np.linalg.eigvalsh(at.gauss_newton)[0] > 0.0


def test_the_hessian_is_not_positive_definite_everywhere():
    """Why the passes are Gauss-Newton: away from a solution it is indefinite, at one it is not."""
    generator = np.random.default_rng(3)
    assert max(np.linalg.eigvalsh(expand(*random_window(generator), TUNING).hessian)[0] for _ in range(20)) < 0.0
    found = [np.linalg.eigvalsh(expand(estimates(ALGORITHM_1)[t].x, information(t, estimates(ALGORITHM_1)[t].x_bar), TUNING).hessian)[0] for t in range(3, 121)]
    assert min(found) > 0.0


def test_the_cost_without_noises_and_its_derivatives():
    generator = np.random.default_rng(4)
    for _ in range(4):
        first = np.array([generator.uniform(0.05, 0.3), generator.uniform(0.65, 0.85)])
        u = generator.uniform(0, 900, 4)
        y = trajectory(first, u, TUNING)[:, 1] + generator.normal(0, 0.03, 5)
        given = Information(np.array([0.15, 0.7]), y, u)
        value, gradient, hessian = shooting_half_cost(given.x_bar, y, u, TUNING)(first)
        at = expand_shooting(first, given, TUNING)
        assert pytest.approx(2 * float(value), rel=1e-8) == at.J
        assert shooting_cost(first, given, TUNING) == pytest.approx(at.J, rel=1e-14)
        np.testing.assert_allclose(at.gradient, np.array(gradient).ravel(), rtol=1e-6, atol=1e-3)
        np.testing.assert_allclose(at.hessian, np.array(hessian), rtol=1e-6, atol=1e-3)


# Algorithm 1


def test_converged_estimates_equal_ipopts():
    """Every fifth window of a run, and those with a held concentration."""
    solve = window_solver(TUNING.N + 1, TUNING)
    held = 0
    for t in range(TUNING.N, 121):
        frame = estimates(ALGORITHM_1)[t]
        touches = bool((frame.x[:, 0] <= 0.0).any())
        if t % 5 and not touches:
            continue
        held += touches
        given = information(t, frame.x_bar)
        right = solve(frame.warm, given.x_bar, given.y, given.u)
        found = estimate(frame.warm, given, TUNING, CONVERGED)[-1].x
        np.testing.assert_allclose(found, right, atol=2e-9)
        # As the sheet runs it, with 4 passes
        np.testing.assert_allclose(frame.x, right, atol=3e-4)
    assert held >= 5


def test_converged_estimates_without_noises_equal_ipopts():
    solve = window_solver(TUNING.N + 1, TUNING, noises=False)
    held = 0
    for t in range(TUNING.N, 121, 4):
        frame = estimates(ALGORITHM_1_WITHOUT)[t]
        given = information(t, frame.x_bar)
        right = solve(frame.warm, given.x_bar, given.y, given.u)
        found = estimate_first(frame.warm[0], given, TUNING, CONVERGED)[-1].best.x
        held += bool(found[0, 0] <= 0.0)
        np.testing.assert_allclose(found, right, atol=2e-8)
    assert held >= 3


def test_a_longer_window_equals_ipopts_too():
    tuning = replace(TUNING, N=8)
    solve = window_solver(9, tuning)
    for t in (8, 40, 90):
        given = information(t, np.array([0.12, 0.75]), 9)
        guess = np.column_stack([np.full(9, 0.15), given.y])
        found = estimate(guess, given, tuning, CONVERGED)[-1].x
        np.testing.assert_allclose(found, solve(guess, given.x_bar, given.y, given.u), atol=2e-9)


# Algorithm 2


def test_proposition_1_the_prediction_solves_the_longer_problem():
    """Gradient zero at the reference; and IPOPT finds nothing better."""
    solve = window_solver(TUNING.N + 2, TUNING)
    for t in range(30, 110, 20):
        frame = estimates(ALGORITHM_1)[t - 1]
        last = estimate(frame.warm, information(t - 1, frame.x_bar), TUNING, CONVERGED)[-1].x
        made = update(last, information(t, frame.x_bar, TUNING.N + 2), TUNING)
        assert made.stationary < 1e-6
        given = information(t, frame.x_bar, TUNING.N + 2)
        y_bar = np.append(given.y[:-1], made.reference[-1, 1])
        np.testing.assert_allclose(made.reference, solve(made.reference, given.x_bar, y_bar, given.u), atol=3e-9)


@pytest.mark.parametrize("noises", [True, False])
def test_the_update_is_the_derivative_of_the_solution(noises):
    """(26) against the change of IPOPT's solutions for y_bar +- delta; also where a component is held."""
    solve = window_solver(TUNING.N + 2, TUNING, noises)
    method, delta, held = (ALGORITHM_1 if noises else ALGORITHM_1_WITHOUT), 2e-5, 0
    for t in (*range(40, 110, 15), *_held_frames(method, 2)):
        frame = estimates(method)[t - 1]
        past, given = information(t - 1, frame.x_bar), information(t, frame.x_bar, TUNING.N + 2)
        last = (
            estimate(frame.warm, past, TUNING, CONVERGED)[-1].x
            if noises
            else estimate_first(frame.warm[0], past, TUNING, CONVERGED)[-1].best.x
        )
        y_bar = step(last[-1], given.u[-1], TUNING)[1]
        sides = []
        for sign in (1.0, -1.0):
            y = np.append(given.y[:-1], y_bar + sign * delta)
            guess = np.vstack([last, step(last[-1], given.u[-1], TUNING)])
            sides.append(solve(guess, given.x_bar, y, given.u))
        slope = (sides[0] - sides[1]) / (2 * delta)
        made = (update if noises else update_first)(last, replace(given, y=np.append(given.y[:-1], y_bar + delta)), TUNING)
        held += bool(made.hold.any())
        np.testing.assert_allclose((made.updated - made.reference) / delta, slope, rtol=2e-3, atol=2e-3)
        wrong = (update if noises else update_first)(
            last, replace(given, y=np.append(given.y[:-1], y_bar + delta)), TUNING, sign=-1.0
        )
        assert np.abs((wrong.updated - wrong.reference) / delta - slope).max() > 0.1
    assert held >= 1


def _held_frames(method, count):
    """Frames before which a component of the window is held with a clear push."""
    found = [
        t
        for t in range(20, 118)
        for made in [estimates(ALGORITHM_2 if method.noises else ALGORITHM_2_WITHOUT)[t].update]
        if made.hold.any()
    ]
    return found[5 :: max(1, len(found) // count)][:count]


def test_the_minimisation_is_unaffected_by_the_update():
    """Remark 2: to the last bit."""
    for one, two in ((ALGORITHM_1, ALGORITHM_2), (ALGORITHM_1_WITHOUT, ALGORITHM_2_WITHOUT)):
        for a, b in zip(estimates(one), estimates(two), strict=True):
            np.testing.assert_array_equal(a.x, b.x)


def test_an_update_is_taken_only_if_it_lowers_the_cost():
    taken = 0
    for t, frame in enumerate(estimates(ALGORITHM_2)):
        made = frame.update
        if t <= TUNING.N:
            continue
        given = information(t, estimates(ALGORITHM_2)[t - 1].x_bar, TUNING.N + 2)
        before, after = cost(made.reference, given, TUNING), cost(made.x, given, TUNING)
        assert after <= before
        assert made.J_reference == before
        taken += made.accepted
        np.testing.assert_array_equal(made.x, made.updated if made.accepted else made.reference)
        assert np.all((made.x >= TUNING.lower) & (made.x <= TUNING.upper))
    assert taken > 100
