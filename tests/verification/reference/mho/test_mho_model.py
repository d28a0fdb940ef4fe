"""The model of paper 003 against automatic differentiation, and the flights against the model."""

from __future__ import annotations

import numpy as np
import pytest
from mho_independent import TUNING, numbers, symbolic_model

from verification.flights.true_airspeed import INPUT_BIASES, PULLS, load_pulls, readings, resampled
from verification.recordings import Recording
from verification.reference.mho.gain import level_flight, observer_gain, placed_gain, rounded, spectral_radius
from verification.reference.mho.model import f, f_jacobian, first_state, h, h_jacobian
from verification.reference.mho.tuning import GRAVITY, MhoTuning


def points(count: int = 100) -> list[tuple[np.ndarray, np.ndarray]]:
    random = np.random.default_rng(3)
    x = random.uniform([-0.3, 100, -0.5], [0.5, 600, 0.5], (count, 3))
    u = random.uniform([-10, -50, -0.5], [10, 10, 0.5], (count, 3))
    return list(zip(x, u, strict=True))


def test_model_and_jacobians_equal_automatic_differentiation():
    model = symbolic_model(TUNING.t_s)
    for x, u in points():
        np.testing.assert_allclose(f(x, u, TUNING), numbers(model.f(x, u)).ravel(), rtol=1e-13, atol=1e-13)
        np.testing.assert_allclose(h(x, TUNING), numbers(model.h(x)).ravel(), rtol=1e-13, atol=1e-12)
        np.testing.assert_allclose(f_jacobian(x, u, TUNING), numbers(model.A(x, u)), rtol=1e-12, atol=1e-13)
        np.testing.assert_allclose(h_jacobian(x, TUNING), numbers(model.C(x)), rtol=1e-12, atol=1e-12)


def test_gravity_in_knots_a_second():
    assert pytest.approx(19.0626, abs=5e-5) == GRAVITY


def test_level_flight_is_steady():
    x, u = level_flight()
    np.testing.assert_allclose(f(x, u, TUNING), x, atol=1e-12)
    assert h(x, TUNING)[1] == 0.0


def test_the_first_state_reproduces_the_measurements():
    x = first_state(np.array([300.0, 20.0, 0.1]))
    np.testing.assert_allclose(h(x, TUNING), [300.0, 20.0, 0.1], atol=0.02)


@pytest.mark.parametrize("plan", PULLS, ids=lambda plan: plan.name)
def test_flights_obey_the_model(plan):
    """One Euler step errs by the inputs' change within it; a trapezoid closes to what the recorder's test allows."""
    flight = load_pulls(plan.name)
    x = np.stack([flight[name] for name in ("alpha_true", "vt_true", "theta")], axis=1)
    u = np.stack([flight[name] for name in ("ax", "az", "q")], axis=1)
    y = np.stack([flight[name] for name in ("vt_true", "vz", "theta")], axis=1)
    steps = np.array([f(a, b, TUNING) - a for a, b in zip(x, u, strict=True)])
    trapezoid = np.diff(x, axis=0) - 0.5 * (steps[:-1] + steps[1:])
    assert np.abs(trapezoid).max(axis=0) == pytest.approx(np.zeros(3), abs=0.006)
    assert np.abs(np.degrees(trapezoid[:, 0]) / 0.08).max() < 0.03  # deg/s
    np.testing.assert_allclose([h(row, TUNING) for row in x], y, atol=2e-3)
    # Angle of attack, altitude and A_z change significantly, as in the paper's Fig. 2
    assert np.ptp(np.degrees(x[:, 0])) > 8
    assert np.ptp(u[:, 1]) > 0.7 * GRAVITY
    assert np.abs(np.cumsum(y[:, 1]) * 0.08 * 1852 / 3600).max() > 300  # m


def test_resampling_keeps_common_samples_and_cubics():
    t = np.arange(101) * 0.048
    cubic = 1 + t - 2 * t**2 + 0.3 * t**3
    names = ("t", "vt_true", "vz", "theta", "q", "ax", "az", "alpha_true")
    found = resampled(Recording(names, (t, *[cubic] * 7)))
    now = found["t"]
    np.testing.assert_allclose(found["vz"], 1 + now - 2 * now**2 + 0.3 * now**3, rtol=1e-12)
    np.testing.assert_allclose(found["vz"][::3], cubic[::5], rtol=1e-14)
    assert found.period == 0.08
    assert now[-1] == pytest.approx(4.8)


def test_readings_repeat_and_carry_noise_and_biases():
    truth = load_pulls(PULLS[0].name)
    once, again, biased = readings(truth, 7), readings(truth, 7), readings(truth, 7, biases=INPUT_BIASES)
    for port, values in once.inputs().items():
        np.testing.assert_array_equal(values, again.inputs()[port])
    deviations = {"vt": 0.7775, "vz": 0.5832, "theta": 0.0017, "q": 0.0140, "ax": 0.3215, "az": 0.3215}
    for port, deviation in deviations.items():
        column = "vt_true" if port == "vt" else port
        assert np.std(once.inputs()[port] - truth[column]) == pytest.approx(deviation, rel=0.1)
    np.testing.assert_allclose(biased.inputs()["q"] - once.inputs()["q"], np.radians(0.5))
    np.testing.assert_allclose(biased.inputs()["az"] - once.inputs()["az"], 0.4)


def test_the_gain_is_that_of_the_riccati_equation():
    from scipy.linalg import solve_discrete_are

    for tuning in (TUNING, MhoTuning(q_v=1.41e5)):
        x, u = level_flight()
        A, C = f_jacobian(x, u, tuning), h_jacobian(x, tuning)
        R = np.diag(1 / tuning.W)
        P = solve_discrete_are(A.T, C.T, np.diag(1 / tuning.Q), R)
        expected = A @ P @ C.T @ np.linalg.inv(C @ P @ C.T + R)
        np.testing.assert_allclose(observer_gain(tuning), expected, rtol=1e-6, atol=1e-9)


def test_the_gain_in_use_is_the_computed_one_and_stabilises_every_speed():
    np.testing.assert_array_equal(TUNING.gain, rounded(observer_gain(TUNING)))
    for v in (120.0, 300.0, 550.0):
        for alpha in (-2.0, 4.0, 12.0):
            x, u = level_flight(v, alpha)
            A, C = f_jacobian(x, u, TUNING), h_jacobian(x, TUNING)
            assert spectral_radius(A) >= 1.0 - 1e-9  # the open loop is not stable
            assert spectral_radius(A - TUNING.gain @ C) < 0.97


def test_pole_placement_puts_the_poles_there():
    x, u = level_flight(250.0, 6.0)
    A, C = f_jacobian(x, u, TUNING), h_jacobian(x, TUNING)
    np.testing.assert_allclose(A - placed_gain(TUNING, x, u) @ C, 0.5 * np.eye(3), atol=1e-12)
