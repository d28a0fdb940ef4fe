"""Section IV of paper 004: sensitivities against finite differences of an exact solution by quadprog."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import quadprog

from verification.reference.tuning import Tuning
from verification.results.fault_sensitivity import (
    VC,
    by_count,
    deviations,
    held_newest,
    next_outputs,
    on_flight,
    paper_flight,
    problem,
    residual_sensitivity,
    run_traces,
    sensitivity,
    solve,
)

TUNING = Tuning()
N = 3
UNIT = np.sqrt(np.concatenate([np.tile(TUNING.P, N), np.tile(TUNING.Q, N - 1)]))
"""Scales of z = (dx, du)."""


def by_quadprog(qp):
    """(42) with all 20 unknowns, the transitions as equalities and every bound: nothing condensed."""
    size = 8 * N - 4
    H, pull = np.zeros((size, size)), np.zeros(size)
    H[:4, :4] += np.diag(1 / TUNING.P)
    for i in range(N):
        x = slice(4 * i, 4 * i + 4)
        H[x, x] += qp.C[i].T @ np.diag(1 / TUNING.R) @ qp.C[i]
        pull[x] += qp.C[i].T @ (qp.r_y[i] / TUNING.R)
    E, e = np.zeros((4 * (N - 1), size)), np.zeros(4 * (N - 1))
    for i in range(N - 1):
        u, rows = slice(4 * N + 4 * i, 4 * N + 4 * i + 4), slice(4 * i, 4 * i + 4)
        H[u, u] += np.diag(1 / TUNING.Q)
        pull[u] += qp.r_u[i] / TUNING.Q
        E[rows, 4 * i + 4 : 4 * i + 8] = np.eye(4)
        E[rows, 4 * i : 4 * i + 4] = -qp.A[i]
        E[rows, u] = -TUNING.t_s * np.eye(4)
        e[rows] = qp.f[i]
    H = H * UNIT * UNIT[:, None] + 1e-14 * np.eye(size)
    low = np.concatenate([(TUNING.x_lower - qp.x).ravel(), (TUNING.u_lower - qp.u).ravel()]) / UNIT
    high = np.concatenate([(TUNING.x_upper - qp.x).ravel(), (TUNING.u_upper - qp.u).ravel()]) / UNIT
    left = np.vstack([E * UNIT / UNIT[4:12, None], np.eye(size), -np.eye(size)])
    right = np.concatenate([e / UNIT[4:12], low, -high])
    return quadprog.solve_qp(H, pull * UNIT, left.T, right, meq=len(e))[0] * UNIT


@pytest.fixture(scope="module")
def traces():
    return run_traces(paper_flight(9.0, onset=3.0), TUNING)


@pytest.fixture(scope="module")
def found():
    return on_flight(paper_flight(9.0, onset=3.0), TUNING)


def test_the_exact_solution_and_its_active_bounds_are_quadprogs(traces):
    held = 0
    for k in (60, 100, 140, *range(146, 162, 2)):
        z, active = solve(problem(traces[k].qp, TUNING))
        right = by_quadprog(traces[k].qp)
        np.testing.assert_allclose(z / UNIT, right / UNIT, atol=1e-6)
        room = np.minimum(z - problem(traces[k].qp, TUNING).lower, problem(traces[k].qp, TUNING).upper - z)
        assert np.all(room >= -1e-9) and np.all(np.abs(room[active]) < 1e-9)
        held += bool(active.any())
    assert held >= 5


@pytest.mark.parametrize("k", [100, 152])
def test_every_column_of_s_f_is_a_finite_difference(traces, k):
    """Of each output's fault in each sample: perturb the measurement, solve again with quadprog, predict."""
    trace, ahead = traces[k], next_outputs(traces[k], traces[k + 1], TUNING)
    _, active = solve(problem(trace.qp, TUNING))
    assert active.any() == (k == 152)
    S = residual_sensitivity(trace.qp, active, ahead, TUNING)
    for i in range(N):
        for j in range(4):
            step = 0.02 * np.sqrt(TUNING.R[j])
            moved = []
            for sign in (1.0, -1.0):
                r_y = trace.qp.r_y.copy()
                r_y[i, j] += sign * step
                moved.append(by_quadprog(replace(trace.qp, r_y=r_y))[4 * (N - 1) : 4 * N])
            slope = -ahead @ (moved[0] - moved[1]) / (2 * step)
            scale = np.sqrt(TUNING.R / TUNING.R[j])
            column = S[:, 4 + 8 * i + 4 + j] if i < N - 1 else S[:, 8 * N - 4 + j]
            np.testing.assert_allclose(slope / scale, column / scale, atol=1e-5)
    np.testing.assert_array_equal(S[:, -4:], np.eye(4))


def test_the_answer_to_a_lasting_fault_goes_from_0_83_to_1(found):
    assert len(found) >= 8
    for one in found:
        assert one.free == pytest.approx(0.83, abs=0.01) and one.held == pytest.approx(1.0, abs=1e-3)
        assert all(name.startswith("W_x of k") for name in one.active)
    assert set(by_count(found)) <= {1, 2, 3}


def test_theorem_1_is_indefinite_as_printed_and_turned_in_standard_deviations(found):
    for one in found:
        assert one.printed[0] < -0.1 and one.printed[1] > 0.001
        assert one.in_deviations[1] < 1e-9 and one.in_deviations[0] < -0.05


def test_without_an_active_bound_both_are_the_same(traces):
    one = sensitivity(100, traces[100], traces[101], TUNING)
    assert one.active == () and one.free == one.held
    assert one.printed == (0.0, 0.0)


def test_one_held_wind_is_enough(traces):
    """Holding the newest W_x alone takes away what could follow the fault; older ones add nothing lasting."""
    none, *some = held_newest(traces[152], traces[153], TUNING)
    assert none < 0.9 and all(abs(answer - 1.0) < 1e-3 for answer in some)


def test_a_lasting_fault_by_direct_perturbation(traces):
    """All airspeeds of the window and the next sample higher by the same amount, solved again by quadprog."""
    for k, answer in ((100, 0.83), (152, 1.0)):
        trace, ahead = traces[k], next_outputs(traces[k], traces[k + 1], TUNING)
        higher = trace.qp.r_y.copy()
        higher[:, VC] += 0.01
        moved = by_quadprog(replace(trace.qp, r_y=higher)) - by_quadprog(trace.qp)
        assert 1.0 - (ahead @ moved[8:12])[VC] / 0.01 == pytest.approx(answer, abs=0.01)


@pytest.mark.parametrize("k", [100, 152])
def test_in_standard_deviations_the_inequality_is_turned_by_proof(traces, k):
    """S U S' = Phi J_1 X J_1' Phi' + R with U = diag(V, R), since X H X = X: the held X_a <= X makes it smaller.

    X is made from the inverse of the KKT matrix of (31) and (37) here, not from a null space.
    """
    trace, ahead = traces[k], next_outputs(traces[k], traces[k + 1], TUNING)
    given = problem(trace.qp, TUNING)
    _, active = solve(given)
    weight = np.concatenate([deviations(N, TUNING), np.sqrt(TUNING.R)])
    H = given.G.T @ given.G
    sizes = []
    for held in (np.zeros_like(active), active):
        A = given.S[held] / np.linalg.norm(given.S[held], axis=1)[:, None]
        kkt = np.block([[H, A.T], [A, np.zeros((len(A), len(A)))]])
        X = np.linalg.pinv(kkt)[: len(H), : len(H)]
        newest = ahead @ given.S[4 * (N - 1) : 4 * N]
        S = residual_sensitivity(trace.qp, held, ahead, TUNING) * weight
        right = newest @ X @ newest.T + np.diag(TUNING.R)
        np.testing.assert_allclose(S @ S.T, right, rtol=1e-6, atol=1e-9)
        sizes.append(right)
    assert np.linalg.eigvalsh(sizes[1] - sizes[0]).max() < 1e-9
