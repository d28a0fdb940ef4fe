"""One iteration of every observer of paper 003 against independent solutions of the same window."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from mho_independent import SIGMA_X, TUNING, flight_steps, ipopt, sparse_step

from verification.flights.true_airspeed import PULLS, load_pulls, readings
from verification.reference.mho import ekf
from verification.reference.mho.line_search import cost, step_length
from verification.reference.mho.mho_pe import mho_pe, mho_wod
from verification.reference.mho.mho_wd import mho_wd
from verification.reference.mho.model import f, f_jacobian, h, h_jacobian
from verification.reference.mho.window import Window

NAMES = tuple(plan.name for plan in PULLS)
GAINS = {mho_pe: TUNING.gain, mho_wod: np.zeros((3, 3)), mho_wd: np.zeros((3, 3))}
METHODS = pytest.mark.parametrize("method", GAINS, ids=lambda method: method.__name__)


def random_window(seed: int, N: int) -> Window:
    """A window whose first guess is far off, and whose measurements hardly fit it."""
    random = np.random.default_rng(seed)
    x = random.uniform([-0.1, 150, -0.2], [0.3, 500, 0.3])
    u = random.uniform([-3, -30, -0.1], [6, -5, 0.1], (N, 3))
    w = random.normal(size=(N, 3)) * [1e-3, 0.05, 1e-3]
    states = [x]
    for i in range(N):
        states.append(f(states[i], u[i], TUNING) + w[i])
    y = np.array([h(state, TUNING) for state in states]) + random.normal(size=(N + 1, 3)) * [1, 1, 0.003]
    return Window(y, u, x + random.normal(size=3) * [0.05, 5, 0.05], random.normal(size=(N, 3)) * [1e-3, 0.05, 1e-3])


@METHODS
@pytest.mark.parametrize("N", [1, 2, 6, 15])
def test_the_step_is_that_of_the_problem_with_all_states_kept(method, N):
    """(11) and the condensed (2) against dense KKT systems with the constraints (6)."""
    for seed in range(4):
        window = random_window(seed, N)
        solution = method(window, TUNING)
        dx, dw = sparse_step(window, solution.x_bar, GAINS[method], method is mho_wd, TUNING)
        np.testing.assert_allclose(solution.p / SIGMA_X, dx[0] / SIGMA_X, rtol=1e-9, atol=1e-8)
        if method is mho_wd:
            found = (solution.w - window.w_prior) / SIGMA_X
            np.testing.assert_allclose(found, dw / SIGMA_X, rtol=1e-8, atol=1e-8)


@METHODS
@pytest.mark.parametrize("name", NAMES)
def test_one_iteration_is_next_to_the_exact_minimum_in_flight(name, method):
    """IPOPT's minimum of (2), (3), (4); what one iteration leaves is of second order in the correction."""
    for step in flight_steps(name, method, 6)[::15]:
        exact = ipopt(step.window, GAINS[method], method is mho_wd, replace(TUNING, N=6))
        correction = np.abs((exact - step.solution.x_bar) / SIGMA_X).max()
        left = np.abs((exact - step.solution.x) / SIGMA_X).max()
        assert left < 2e-3 * correction**2 + 1e-6


@pytest.mark.parametrize("name", NAMES)
def test_the_line_search_takes_the_full_step_in_flight(name):
    for step in flight_steps(name, mho_pe, 15):
        assert step_length(step.window, TUNING.gain, TUNING, step.solution.p) == 1.0


def test_the_line_search_shrinks_a_step_that_is_too_long():
    window = random_window(5, 4)
    p = mho_pe(window, TUNING).p
    assert step_length(window, TUNING.gain, TUNING, p) == 1.0
    assert 0.0 < step_length(window, TUNING.gain, TUNING, 20 * p) < 0.2
    assert step_length(window, TUNING.gain, TUNING, -p) == 0.0  # uphill
    lower = cost(window.x_prior + p, window, TUNING.gain, TUNING)
    assert lower < 0.2 * cost(window.x_prior, window, TUNING.gain, TUNING)


@pytest.mark.parametrize("name", NAMES)
def test_the_filter_equals_the_information_form(name):
    rows = readings(load_pulls(name), 4).inputs()
    part = {port: values[:150] for port, values in rows.items()}
    before = None
    for step in ekf.steps(part, TUNING):
        C, W = h_jacobian(step.x_prior, TUNING), np.diag(TUNING.W)
        information = np.linalg.inv(step.P_prior) + C.T @ W @ C
        x = step.x_prior + np.linalg.solve(information, C.T @ W @ (step.inputs.y - h(step.x_prior, TUNING)))
        scale = np.outer(SIGMA_X, SIGMA_X)
        np.testing.assert_allclose((step.x - x) / SIGMA_X, np.zeros(3), atol=1e-8)
        np.testing.assert_allclose(step.P / scale, np.linalg.inv(information) / scale, atol=1e-8)
        if before is not None:
            A = f_jacobian(before.x, before.inputs.u, TUNING)
            np.testing.assert_allclose(step.x_prior, f(before.x, before.inputs.u, TUNING), rtol=1e-12)
            np.testing.assert_allclose(step.P_prior, A @ before.P @ A.T + np.diag(1 / TUNING.Q), rtol=1e-9, atol=1e-15)
        before = step
