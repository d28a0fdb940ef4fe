"""What paper 004 leaves open: the decisions that can be tested, each with what happens otherwise.

`docs/corrections.md` is the account for users; it names these tests.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from reference_cases import (
    ALPHA_RUNAWAY,
    SIGMA_X,
    TUNING,
    VC_RUNAWAY,
    WINDY,
    error,
    flight,
    random_qp,
    steps,
    synthetic,
)

from verification.reference import cmhe_fte, estimator, interior_point, umhe_fte
from verification.reference.arrays import KNOT
from verification.reference.barrier import room
from verification.reference.search_direction import search_direction


def test_a_warm_start_outside_the_bounds_must_be_clipped_or_the_run_freezes():
    """The paper does neither clip nor floor: outside, the barrier pushes away, and no step length is left."""
    recording = flight(WINDY, seconds=12.0)
    alpha_max = float(np.rad2deg(np.quantile(recording["alpha"], 0.8)))  # a bound that is met
    clipped = replace(TUNING, alpha_max=alpha_max)
    frozen = {}
    for name, tuning in (("clipped", clipped), ("as printed", replace(clipped, clip_margin=-9.0, distance_floor=-9.0))):
        state, lengths = estimator.initial_state(tuning), []
        for inputs in estimator.frames(recording):
            done = cmhe_fte.step(state, inputs, tuning)
            state = done.state
            lengths.append(max(it.s for it in done.trace.iterations))
        frozen[name] = int(np.sum(np.array(lengths) == 0.0))
    assert frozen["clipped"] == 0
    assert frozen["as printed"] > 20


def test_without_the_inhibition_a_steady_wind_condemns_every_airspeed_sensor():
    recording = synthetic(120, w_x_kt=30.0)
    assert cmhe_fte.run(recording)["vc_faulty"][-1].sum() == 0
    assert cmhe_fte.run(recording, replace(TUNING, n_inhibit=0))["vc_faulty"][-1].sum() == 3


def test_without_a_floor_the_fusion_weighs_by_chance():
    recording = synthetic(1)
    recording["alpha"] = recording["alpha"] + np.deg2rad([[0.0, 0.25, 0.5]])
    inputs = next(estimator.frames(recording))
    state = cmhe_fte.initial_state(TUNING)
    fused = cmhe_fte.step(state, inputs, replace(TUNING, alpha_floor=5.0)).trace.fused
    assert fused.value[0] == pytest.approx(recording["alpha"].mean())
    without = cmhe_fte.step(state, inputs, replace(TUNING, alpha_floor=1e-12)).trace
    weights = 1.0 / np.maximum(without.judgement.rms[0], 1e-20) ** 2
    assert weights.max() / weights.min() > 1e9  # one sensor decides alone


def test_an_empty_fusion_counts_nothing_and_keeps_running():
    lost = flight(faults=(ALPHA_RUNAWAY, VC_RUNAWAY))
    done = steps(faults=(VC_RUNAWAY, ALPHA_RUNAWAY))
    assert len(done) == len(lost["vg"])
    assert done[-1].outputs.configuration == 4
    trace = done[-1].trace
    assert not trace.fused.present.any()
    assert (trace.qp.C[:, 2:] == 0.0).all()
    assert (trace.qp.r_y[:, 2:] == 0.0).all()
    np.testing.assert_array_equal(trace.fused.value, trace.prediction)


def test_scalar_updates_without_square_roots_give_the_same_step():
    """Eight scalar updates in sequence, the barrier by its variance: the same newest state as the paper's form."""
    for seed in range(6):
        qp = random_qp(seed)
        rooms = (
            room(qp.x, TUNING.x_lower, TUNING.x_upper, TUNING.distance_floor),
            room(qp.u, TUNING.u_lower, TUNING.u_upper, TUNING.distance_floor),
        )
        zero = np.zeros((3, 4)), np.zeros((2, 4))
        problem = interior_point.newton_problem(qp, *zero, 1.0, rooms, TUNING)
        paper = search_direction(problem)
        d1, d2 = rooms[0].distances(zero[0])
        variance = (d1 * d2) ** 2 / (d1**2 + d2**2)
        residual = -((d2 - d1) * d1 * d2 / (d1**2 + d2**2))
        P_hat, x_hat = np.diag(TUNING.P), np.zeros(4)
        for i in range(3):  # the forward pass, measurement by measurement
            for j in range(8):
                row = qp.C[i, j] if j < 4 else np.eye(4)[j - 4]
                r, noise = (qp.r_y[i, j], TUNING.R[j]) if j < 4 else (residual[i, j - 4], variance[i, j - 4])
                gain = P_hat @ row / (row @ P_hat @ row + noise)
                x_hat, P_hat = x_hat + gain * (r - row @ x_hat), P_hat - np.outer(gain, row @ P_hat)
            if i < 2:
                x_hat = qp.f[i] + qp.A[i] @ x_hat + TUNING.t_s * problem.r_u[i]
                P_hat = qp.A[i] @ P_hat @ qp.A[i].T + TUNING.t_s**2 * np.diag(problem.Q_bar[i])
        assert error(x_hat, paper[0][2], SIGMA_X) < 1e-9


def test_t_s_follows_from_the_370_samples_of_fig_4():
    assert 370 * TUNING.t_s == pytest.approx(17.76)


def test_p_w_and_q_w_read_in_square_knots_contradict_fig_4():
    """Fig. 4: the wind of UMHE takes in the whole fault. In kt^2 its weights are 3.8 times smaller."""
    recording = flight(faults=(VC_RUNAWAY,))
    onset = round(3.0 / TUNING.t_s)
    in_knots = replace(TUNING, p_w=TUNING.p_w * KNOT**2, q_w=TUNING.q_w * KNOT**2)
    rms = [umhe_fte.run(recording, t)["vc_rms"][onset + 100 :].max() for t in (TUNING, in_knots)]
    assert rms[0] < TUNING.vc_threshold < rms[1]
