"""EKF-FTE's reference against a textbook filter: automatic derivatives, a dense inverse, Joseph's form; and against the
moving horizon estimator of one sample whose arrival cost is the filter's covariance."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from independent_solution import symbolic_model
from reference_cases import CALM, SIGMA_X, TUNING, WINDY, steps

from verification.flights import Fault, Missing
from verification.reference import ekf_fte
from verification.reference.inputs import Inputs

VC_BIAS = Fault("bias", "vc", which=(1, 2, 3), amplitude=80.0, onset=4.0)
GAP = Missing(inputs=("vg", "alpha", "vc"), onset=2.0, frames=3)
ALPHA_BIAS = Fault("bias", "alpha", which=(1, 2, 3), amplitude=9.0, onset=4.0)
FLIGHTS = {
    "faulty airspeed": {"name": CALM, "seconds": 9.0, "faults": (VC_BIAS,)},
    "faulty angle of attack": {"name": WINDY, "seconds": 8.0, "start": 20.0, "faults": (ALPHA_BIAS,)},
    "wind and a gap": {"name": WINDY, "seconds": 8.0, "start": 24.0, "missing": (GAP,)},
}


@cache
def flown(name):
    return steps(ekf_fte, **FLIGHTS[name])


@pytest.mark.parametrize("name", FLIGHTS)
def test_equals_a_textbook_filter_in_josephs_form(name):
    """From start to end by itself: it takes from the run only what Steps 0 to 2 give it."""
    model, R, Q = symbolic_model(TUNING.t_s), np.diag(TUNING.R), np.diag(TUNING.Q)
    done = flown(name)
    x = P = None
    for step in done:
        trace = step.common.trace
        theta, y, row = trace.window.theta[0], trace.window.y[0], trace.window.row_mask[0]
        if trace.start_up.load:
            x, P = trace.qp.x[0], np.diag(TUNING.P)
        present = row > 0  # rows that do not count are taken out, not zeroed
        C = np.array(model["C"](x, theta))[present]
        e = (y - np.array(model["h"](x, theta)).ravel())[present]
        S = C @ P @ C.T + R[np.ix_(present, present)]
        K = np.linalg.solve(S, C @ P).T
        I_KC = np.eye(4) - K @ C
        x = x + K @ e
        P = I_KC @ P @ I_KC.T + K @ R[np.ix_(present, present)] @ K.T
        assert (np.abs(x - trace.x[0]) / SIGMA_X).max() < 1e-8
        np.testing.assert_allclose(P / np.outer(SIGMA_X, SIGMA_X), step.update.P_f / np.outer(SIGMA_X, SIGMA_X), atol=1e-9)
        A, B = np.array(model["A"](x, np.zeros(4), theta)), np.array(model["B"](x, np.zeros(4), theta))
        x, P = np.array(model["F"](x, np.zeros(4), theta)).ravel(), A @ P @ A.T + B @ Q @ B.T
    outcomes = {step.outputs.configuration for step in done}
    assert outcomes == {"faulty airspeed": {1, 3}, "faulty angle of attack": {1, 2}, "wind and a gap": {1}}[name]


@pytest.mark.parametrize("name", FLIGHTS)
def test_an_update_is_the_window_of_one_sample_with_the_exact_arrival_cost(name):
    """(21) for one sample: |x - x_(k|k-1)|^2 in P^-1 and |y - h - C dx|^2 in R^-1, by orthogonal factors."""
    for step in flown(name)[::7]:
        qp, update = step.common.trace.qp, step.update
        root = np.linalg.cholesky(update.P_hat / np.outer(SIGMA_X, SIGMA_X))
        weighted = qp.C[0] * SIGMA_X / np.sqrt(TUNING.R)[:, None]
        rows = np.vstack([np.linalg.inv(root), weighted])
        dx = np.linalg.lstsq(rows, np.concatenate([np.zeros(4), qp.r_y[0] / np.sqrt(TUNING.R)]), rcond=None)[0]
        assert np.abs(dx - step.common.trace.iterations[0].dx[0] / SIGMA_X).max() < 1e-9 * max(1.0, np.abs(dx).max())


def test_the_covariance_stays_one():
    for name in FLIGHTS:
        for step in flown(name):
            P = step.state.P / np.outer(SIGMA_X, SIGMA_X)
            np.testing.assert_allclose(P, P.T, atol=1e-9)
            assert np.linalg.eigvalsh((P + P.T) / 2).min() > 0.0


@pytest.mark.parametrize("bad", [np.nan, np.inf, -1.0, 1.01 * TUNING.ekf_p_factor * TUNING.p_v])
def test_a_covariance_that_cannot_be_starts_anew(bad):
    before = flown("wind and a gap")[60]
    P = before.state.P.copy()
    P[1, 1] = bad
    now = Inputs(sensors=np.full((2, 3), np.nan), inertial=before.state.common.held)
    step = ekf_fte.step(replace(before.state, P=P), now, TUNING)
    np.testing.assert_array_equal(step.update.P_hat, np.diag(TUNING.P))
    assert np.isfinite(step.state.P).all()
