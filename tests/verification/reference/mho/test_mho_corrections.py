"""What paper 003 prints wrongly or leaves open: each printed form fails here, the form in use holds."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from mho_independent import TUNING, flight_steps

from verification.flights.true_airspeed import PULLS, load_pulls, readings
from verification.reference.mho.gain import level_flight
from verification.reference.mho.mho_pe import Linearised, estimated, linearise, mho_pe, product, stacked_matrices
from verification.reference.mho.mho_wd import mho_wd
from verification.reference.mho.model import f, f_jacobian, h_jacobian
from verification.reference.mho.tuning import Q_V_NOISE, Q_V_PRINTED
from verification.reference.mho.window import Window

NAME = PULLS[0].name
N = 5


def steps():
    return flight_steps(NAME, mho_pe, N)[::20]


def points() -> list[tuple[Window, Linearised]]:
    return [(step.window, linearise(step.window, TUNING.gain, TUNING)) for step in steps()]


def test_the_weights_are_those_of_round_deviations():
    np.testing.assert_allclose(TUNING.M, [131.31, 0.04, 131.31], rtol=1e-3)
    np.testing.assert_allclose(TUNING.W, [1.65, 2.94, 3.28e5], rtol=5e-3)
    np.testing.assert_allclose(TUNING.Q[[0, 2]], 8.01e5, rtol=5e-3)


def test_q2_as_printed_contradicts_table_i():
    """The disturbance of V_t that the noise of A_x and A_z makes, measured on a flight."""
    truth = load_pulls(NAME)
    read = readings(truth, 3).inputs()
    x = np.stack([truth[name] for name in ("alpha_true", "vt_true", "theta")], axis=1)
    clean, noisy = (np.stack([rows[name] for name in ("ax", "az", "q")], axis=1) for rows in (truth, read))
    w = np.array([f(a, b, TUNING) - f(a, c, TUNING) for a, b, c in zip(x, noisy, clean, strict=True)])
    variance = w.var(axis=0)
    np.testing.assert_allclose(variance[1:] * TUNING.Q[1:], 1.0, rtol=0.15)
    assert variance[1] * Q_V_PRINTED > 50
    assert pytest.approx(93, abs=1) == Q_V_PRINTED / Q_V_NOISE


def test_the_first_guess_has_one_disturbance_for_each_transition():
    """Step (i) lists w_k-N|k-1 ... w_k-1|k-1, 0: N + 1 for the N transitions of (2), and w_k-1|k-1 does not exist."""
    flight = flight_steps(NAME, mho_wd, N)
    for before, step in pairwise(flight):
        np.testing.assert_array_equal(step.window.w_prior[:-1], before.solution.w[1:])
        np.testing.assert_array_equal(step.window.w_prior[-1], 0)
    printed = np.vstack([flight[-2].solution.w, np.zeros(3)])
    with pytest.raises(IndexError):
        mho_wd(replace(flight[-1].window, w_prior=printed), TUNING)


def test_14_ends_with_the_newest_state():
    """With i = k as printed it would need u_m,k, which I_k does not hold, and give x_k+1."""
    window = steps()[0].window
    assert len(window.u) == N
    assert len(estimated(window.x_prior, window, TUNING.gain, TUNING)) == len(window.y) == N + 1


def by_differences(point: Linearised) -> np.ndarray:
    """F_k: the outputs along the linearised observer from each unit vector, and from zero."""

    def outputs_from(x: np.ndarray) -> np.ndarray:
        rows = []
        for i, C in enumerate(point.C):
            rows.append(C @ x)
            if i < len(point.Phi):
                x = point.Phi[i] @ x
        return np.concatenate(rows)

    return np.stack([outputs_from(unit) for unit in np.eye(3)], axis=1)


def test_later_factors_of_phi_stand_on_the_left():
    for _, point in points():
        expected = by_differences(point)
        np.testing.assert_allclose(stacked_matrices(point, TUNING.gain)[0], expected, rtol=1e-12, atol=1e-9)
        from_left = np.linalg.multi_dot(list(point.Phi))  # earlier factors on the left
        assert np.abs(point.C[-1] @ from_left - expected[-3:]).max() > 1e-4
        np.testing.assert_allclose(point.C[-1] @ product(point.Phi, 0, N - 1), expected[-3:], rtol=1e-12, atol=1e-9)


def test_8_holds_along_the_linearised_observer():
    """y_m - y_hat = sigma - F x for any x, by running (6) itself."""
    random = np.random.default_rng(1)
    for window, point in points():
        F, G, H = stacked_matrices(point, TUNING.gain)
        mu = np.append(point.mu, np.zeros(3))
        sigma = H @ window.y.ravel() - G @ mu - H @ point.tau.ravel()
        x = start = point.x_bar[0] + random.normal(size=3) * [0.01, 1, 0.01]
        errors = []
        for i, (C, tau, y) in enumerate(zip(point.C, point.tau, window.y, strict=True)):
            errors.append(y - C @ x - tau)
            if i < N:
                x = point.Phi[i] @ x + TUNING.gain @ (y - tau) + point.mu[i]
        np.testing.assert_allclose(sigma - F @ start, np.concatenate(errors), rtol=1e-9, atol=1e-8)


def test_the_appendix_holds():
    """H F_o = F and H G_o = G."""
    for _, point in points():
        F, G, H = stacked_matrices(point, TUNING.gain)
        F_o, G_o, _ = stacked_matrices(replace(point, Phi=point.A), np.zeros((3, 3)))
        np.testing.assert_allclose(H @ F_o, F, rtol=1e-11, atol=1e-9)
        np.testing.assert_allclose(H @ G_o, G, rtol=1e-11, atol=1e-9)


def test_34_has_no_c_in_it_and_begins_one_sample_earlier():
    """The errors of the pre-estimated states: H_bar is -G_bar blkdiag(L); "similarly to (9)" would give I - C G L."""
    random = np.random.default_rng(2)
    L = TUNING.gain
    for step in steps():
        point = linearise(step.window, L, TUNING)
        Xi = point.Phi
        states = Linearised(point.x_bar, Xi, np.tile(np.eye(3), (N + 1, 1, 1)), Xi, point.mu, point.tau)
        F_bar, G_bar, printed = stacked_matrices(states, L)
        H_bar = -G_bar @ np.kron(np.eye(N + 1), L)
        before, e = Xi[0] * 0.9, random.normal(size=3)  # Xi_k-N-1,k-1, and the error at k - N - 1
        w, v = random.normal(size=(N + 2, 3)), random.normal(size=(N + 2, 3))
        errors = [before @ e + w[0] - L @ v[0]]  # (18), from k - N - 1 to k - N
        for i in range(N):
            errors.append(Xi[i] @ errors[i] + w[i + 1] - L @ v[i + 1])  # (17)
        found = F_bar @ errors[0] + G_bar @ w[1:].ravel() + H_bar @ v[1:].ravel()
        np.testing.assert_allclose(found, np.concatenate(errors), rtol=1e-10, atol=1e-9)
        wrong = F_bar @ errors[0] + G_bar @ w[1:].ravel() + printed @ v[1:].ravel()
        assert np.abs(wrong - found).max() > 0.1
        F_hat = F_bar @ before
        G_hat, H_hat = np.hstack([F_bar, G_bar]), np.hstack([-F_bar @ L, H_bar])
        found = F_hat @ e + G_hat @ w.ravel() + H_hat @ v.ravel()
        np.testing.assert_allclose(found, np.concatenate(errors), rtol=1e-10, atol=1e-9)
        from_k_n = F_bar @ Xi[0] @ e + G_hat @ w.ravel() + H_hat @ v.ravel()  # Xi_k-N,k-1 as printed
        assert np.abs(from_k_n - found).max() > 1e-2


def gamma(M: np.ndarray, F: np.ndarray, W: np.ndarray) -> np.ndarray:
    information = F.T @ W @ F
    return np.eye(len(M)) - np.linalg.solve(M + information, information)


def test_delta_gamma_is_not_below_one_in_general():
    """(28) makes the spectral radius at most 1, not the norm: one direction measured well gives up to 1.41 and more."""
    F = np.array([[1.0, 1.0]])
    found = gamma(np.diag([1.0, 1e6]), F, 1e12 * np.eye(1))
    assert np.abs(np.linalg.eigvals(found)).max() <= 1 + 1e-9
    assert np.linalg.norm(found, 2) == pytest.approx(np.sqrt(2), rel=1e-3)


def test_delta_xi_is_not_below_one_although_the_observer_is_stable():
    """In a pull-up of 2 g; in level flight it is below one."""
    for load, expected in ((1.0, 0.97), (2.0, 1.94)):
        x, u = level_flight(200.0)
        Phi = f_jacobian(x, load * u, TUNING) - TUNING.gain @ h_jacobian(x, TUNING)
        assert np.abs(np.linalg.eigvals(Phi)).max() < 0.97
        assert np.linalg.norm(Phi, 2) == pytest.approx(expected, abs=0.02)
