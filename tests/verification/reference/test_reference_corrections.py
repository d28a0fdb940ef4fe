"""Each correction of paper 004: the printed form disagrees with an independent solution, the used one agrees.

`docs/corrections.md` is the account for users; it names these tests.
"""

from __future__ import annotations

from dataclasses import replace

import casadi as ca
import numpy as np
import printed_forms as printed
import pytest
from independent_solution import (
    SIZE,
    constraints,
    newton_step,
    newton_system,
    solve_inequality_qp,
    symbolic_model,
)
from reference_cases import (
    SIGMA_X,
    TUNING,
    VC_RUNAWAY,
    error,
    flight,
    random_point,
    random_qp,
    random_theta,
    realistic_traces,
    step_error,
    steps,
    synthetic,
)

from verification.reference import cmhe_fte, interior_point, linearisation
from verification.reference.air_data import calibrated_airspeed
from verification.reference.barrier import gradient, room
from verification.reference.model import output, transition, transition_jacobian
from verification.reference.search_direction import search_direction


def first_step_errors(make_problem, traces, iterations=slice(None)):
    """Return the errors of search directions from `make_problem` against the dense Newton steps of (43)."""
    errors = []
    for trace in traces:
        qp = trace.qp
        rooms = (
            room(qp.x, TUNING.x_lower, TUNING.x_upper, TUNING.distance_floor),
            room(qp.u, TUNING.u_lower, TUNING.u_upper, TUNING.distance_floor),
        )
        for it in trace.iterations[iterations]:
            got = search_direction(make_problem(qp, it.dx_before, it.du_before, it.kappa, rooms, TUNING))
            errors.append(step_error(got, newton_step(qp, it.dx_before, it.du_before, it.kappa, TUNING)))
    return np.array(errors)


# (15)


def vertical_speed_from_velocities(v_t, alpha, theta, w_z):
    """Return V_z, up, from the velocity triangle: the body-axis airspeed turned into the inertial frame."""
    u, w = v_t * np.cos(alpha), v_t * np.sin(alpha)
    down = -u * np.sin(theta) + w * np.cos(theta) + w_z
    return -down


def test_15_the_vertical_wind_has_a_minus_sign():
    generator = np.random.default_rng(2)
    for theta in random_theta(generator, 50):
        alpha, w_z = theta[1] + generator.uniform(-0.1, 0.1), generator.uniform(-15, 15)
        x = np.array([alpha, theta[0], 0.0, w_z])
        right = vertical_speed_from_velocities(theta[0], alpha, theta[1], w_z)
        assert output(x, theta, TUNING)[0][1] == pytest.approx(right, abs=1e-9)
        assert abs(printed.output_15(x, theta, TUNING)[0][1] - right) == pytest.approx(2 * abs(w_z))


def test_15_as_printed_estimates_the_vertical_wind_with_the_wrong_sign(monkeypatch):
    recording = synthetic(150, w_z_kt=10.0)
    right = cmhe_fte.run(recording)
    assert right["wz_hat"][-1] == pytest.approx(10.0, abs=0.5)
    monkeypatch.setattr(linearisation, "output", printed.output_15)
    assert cmhe_fte.run(recording)["wz_hat"][-1] == pytest.approx(-10.0, abs=0.5)


# (16)


def test_16_needs_the_lapse_rate_in_kelvin_a_metre():
    v_t, z = np.array(180.0), np.array(5000.0)
    # the definition of calibrated airspeed: the impact pressure of v_t at z, read at sea level
    T, p = 288.15 - 6.5 * 5.0, 101325.0 * ((288.15 - 6.5 * 5.0) / 288.15) ** 5.255879813
    mach = v_t / np.sqrt(1.4 * 287.05287 * T)
    impact = p * ((1 + 0.2 * mach**2) ** 3.5 - 1)
    sound_0 = np.sqrt(1.4 * 287.05287 * 288.15)
    right = sound_0 * np.sqrt(5 * ((impact / 101325.0 + 1) ** (2 / 7) - 1))
    assert float(calibrated_airspeed(v_t, z)[0]) == pytest.approx(float(right), rel=1e-8)
    with np.errstate(all="ignore"):
        T_printed = 288.15 + (-6.5) * z  # K/km times m
    assert T_printed < 0.0


# (21b), (42)


def test_42_the_defect_of_a_feasible_trajectory_is_zero():
    generator = np.random.default_rng(3)
    theta = random_theta(generator, 3)
    x, u = np.zeros((3, 4)), random_point(generator, TUNING.u_lower, TUNING.u_upper, 2)
    x[0] = random_point(generator, TUNING.x_lower, TUNING.x_upper, 1)[0]
    model = symbolic_model(TUNING.t_s)
    for i in range(2):
        x[i + 1] = np.array(model["F"](x[i], u[i], theta[i])).ravel()
    window = linearisation.Window(theta, np.zeros((3, 4)), np.ones((3, 4)))
    assert np.abs(linearisation.linearise(x, u, window, TUNING).f).max() < 1e-10
    assert np.abs(printed.defect_42(x, u, theta, TUNING)).max() > 1.0


# (22)


def test_22_needs_one_weight_for_each_of_the_four_outputs():
    R_printed = TUNING.R[[2, 1, 3]]  # diag(R_alpha, R_vz, R_vc)
    theta = random_theta(np.random.default_rng(1), 1)[0]
    y, _ = output(np.array([0.05, theta[0], 0.0, 0.0]), theta, TUNING)
    assert len(y) == len(TUNING.R)
    with pytest.raises(ValueError, match="broadcast"):
        y / R_printed


# (23)


def test_23_remark_1_makes_c42_zero_too():
    x, p = ca.SX.sym("x", 4), ca.SX.sym("p", 6)
    model = symbolic_model(TUNING.t_s)
    measured = model["h"](x, p)
    estimated = model["h"](x, ca.vertcat(x[1], p[1:]))  # the state V_g in place of V_g,m
    C_measured = ca.Function("C", [x, p], [ca.jacobian(measured, x)])
    C_estimated = ca.Function("C", [x, p], [ca.jacobian(estimated, x)])
    theta = random_theta(np.random.default_rng(4), 1)[0]
    at = np.array([theta[1] + 0.05, theta[0], 5.0, 2.0])
    _, C = output(at, theta, TUNING)
    np.testing.assert_allclose(C, np.array(C_measured(at, theta)), atol=1e-9)
    assert C[1, 1] == C[3, 1] == 0.0
    assert transition_jacobian(at, theta, TUNING)[0, 1] == 0.0
    assert abs(np.array(C_estimated(at, theta))[3, 1]) > 0.3  # so (23), which prints 0, needs Remark 1


# (31), (37), Theorem 1


def sensitivity_parts(qp):
    """Return J1 (rows x_l, u_l, h_l, u, h, h), J2 and the diagonal of V of (26), in the order of z."""
    E = np.eye(SIZE)
    blocks = [E[:4], E[12:16], _output_rows(qp, 0), E[16:20], _output_rows(qp, 1), _output_rows(qp, 2)]
    V = np.concatenate([TUNING.P, TUNING.Q, TUNING.R, TUNING.Q, TUNING.R, TUNING.R])
    return np.vstack(blocks), -constraints(qp)[0], V


def _output_rows(qp, i):
    rows = np.zeros((4, SIZE))
    rows[:, 4 * i : 4 * i + 4] = qp.C[i]
    return rows


SCALE = np.sqrt(np.concatenate([TUNING.P, TUNING.P, TUNING.P, TUNING.Q, TUNING.Q]))


def projected_inverse(H, J):
    """Return X of (33) without H^-1: the upper left block of the inverse of the KKT matrix, scaled."""
    J = J * SCALE
    J = J / np.linalg.norm(J, axis=1)[:, None]
    m = len(J)
    K = np.block([[H * SCALE * SCALE[:, None], J.T], [J, np.zeros((m, m))]])
    return np.linalg.inv(K)[:SIZE, :SIZE] * SCALE * SCALE[:, None]


def test_31_the_hessian_weighs_with_the_inverse_of_V():
    trace = steps(faults=(VC_RUNAWAY,))[100].trace
    qp = trace.qp
    J1, J2, V = sensitivity_parts(qp)
    zero = np.zeros((3, 4)), np.zeros((2, 4))
    H = newton_system(qp, *zero, 0.0, TUNING)[0]
    np.testing.assert_allclose(J1.T @ (J1 / V[:, None]), H, rtol=1e-12, atol=1e-9)
    X = projected_inverse(H, J2)
    dz = X @ J1.T / V
    loose = replace(
        TUNING, wx_max=1e4, wz_max=1e4, u_w_max=1e4, u_alpha_max=1e3, u_v_max=1e4, alpha_max=1e4, alpha_min=-1e4
    )
    before = np.concatenate([part.ravel() for part in solve_inequality_qp(qp, loose)[:2]])
    r_y = qp.r_y.copy()
    r_y[2, 3] += 1.0  # a fault of 1 m/s on the newest airspeed: the last entry of epsilon
    after = np.concatenate([part.ravel() for part in solve_inequality_qp(replace(qp, r_y=r_y), loose)[:2]])
    np.testing.assert_allclose((after - before) / SCALE, dz[:, -1] / SCALE, atol=1e-7)
    wrong = projected_inverse(printed.gauss_newton_hessian_31(J1, V), J2) @ J1.T / V
    assert np.abs((wrong[:, -1] - dz[:, -1]) / SCALE).max() > 0.1


def test_31_the_hessian_is_singular_in_configurations_II_to_IV():
    ranks = {}
    for trace in realistic_traces():
        J1, _, V = sensitivity_parts(trace.qp)
        present = trace.window.row_mask.all(axis=0)[:2].all() and trace.fused.present.all()
        if present or trace.fused.configuration > 1:
            rank = np.linalg.matrix_rank(J1 * SCALE / np.sqrt(V)[:, None], tol=1e-12)
            ranks.setdefault(trace.fused.configuration, set()).add(int(rank))
    assert ranks[1] == {SIZE}
    assert set(ranks) == {1, 2, 3, 4}
    assert all(max(ranks[configuration]) < SIZE for configuration in (2, 3, 4))


def active_case():
    """Return a step with W_x at its bound throughout the window, and the Jacobian J_a of these bounds."""
    done = steps(faults=(VC_RUNAWAY,))
    J_a = np.zeros((3, SIZE))
    J_a[range(3), [2, 6, 10]] = 1.0
    return done[160].trace, done[161].trace, J_a


def test_37_takes_J_a_not_its_transpose():
    trace, _, J_a = active_case()
    J1, J2, V = sensitivity_parts(trace.qp)
    dz = projected_inverse(J1.T @ (J1 / V[:, None]), np.vstack([J2, J_a])) @ J1.T / V
    # the sensitivity keeps the active bounds active: W_x does not move, whatever the fault
    assert np.abs(J_a @ dz / np.sqrt(TUNING.p_w)).max() < 1e-8
    printed_J_a = J_a.T  # J_a' = dF_a/dz, as printed below (37)
    with pytest.raises(ValueError, match="dimensions"):
        np.block([[J1.T @ J1, J2.T, printed_J_a.T], [J2, np.zeros((8, 11))]])


def fault_sensitivity(trace, following, J):
    """Return S_f of (36): the sensitivity of the next residual to faults in the window and to its own."""
    J1, _, V = sensitivity_parts(trace.qp)
    X = projected_inverse(J1.T @ (J1 / V[:, None]), J)
    theta = trace.window.theta[2]
    ahead = transition(trace.x[2], np.zeros(4), theta, TUNING)
    C = output(ahead, following.window.theta[2], TUNING)[1]
    pick = np.zeros((4, SIZE))
    pick[:, 8:12] = np.eye(4)
    Phi_J1 = C @ transition_jacobian(trace.x[2], theta, TUNING) @ pick
    return np.hstack([-Phi_J1 @ X @ J1.T / V, np.eye(4)]), np.concatenate([V, TUNING.R])


def test_theorem_1_is_false_as_printed_and_what_holds_instead():
    trace, following, J_a = active_case()
    J2 = sensitivity_parts(trace.qp)[1]
    S, V = fault_sensitivity(trace, following, J2)
    S_a, _ = fault_sensitivity(trace, following, np.vstack([J2, J_a]))
    difference = np.linalg.eigvalsh(S_a @ S_a.T - S @ S.T)
    assert difference.min() < -1e-3 < 1e-3 < difference.max()  # indefinite, not >= 0
    whitened = (S_a * V) @ S_a.T - (S * V) @ S.T
    sigma = np.sqrt(TUNING.R)
    assert np.linalg.eigvalsh(whitened / sigma / sigma[:, None]).max() < 1e-9  # in standard deviations: <= 0
    lasting = [11, 19, 23, 27]  # the airspeed's fault at l, l + 1, k and k + 1
    assert S[3, lasting].sum() == pytest.approx(0.83, abs=0.02)
    assert S_a[3, lasting].sum() == pytest.approx(1.0, abs=1e-4)


# (46)


def test_46_used_forms_agree_with_dense_newton_steps():
    assert first_step_errors(interior_point.newton_problem, realistic_traces()[::3]).max() < 1e-9


@pytest.mark.parametrize(
    ("make_problem", "later"),
    [
        (printed.newton_problem_46ab, False),
        (printed.newton_problem_46d, False),
        (printed.newton_problem_46e, True),
    ],
    ids=["46ab", "46d", "46e"],
)
def test_46_printed_forms_disagree_with_dense_newton_steps(make_problem, later):
    iterations = slice(1, None) if later else slice(None)  # at the first, Delta x = 0
    errors = first_step_errors(make_problem, realistic_traces()[::3], iterations)
    assert np.median(errors) > 1e-6
    assert errors.max() > 1e-2


def test_46d_as_printed_detects_the_airspeed_fault_all_the_same(monkeypatch):
    """Why steps are checked, not delays: the wrong form finds the fault in the same frame or nearly."""
    recording = flight(faults=(VC_RUNAWAY,))
    onset = round(3.0 / TUNING.t_s)
    right = cmhe_fte.run(recording)
    monkeypatch.setattr(interior_point, "newton_problem", printed.newton_problem_46d)
    wrong = cmhe_fte.run(recording)
    found = [int(np.argmax(run["vc_faulty"].all(axis=1))) - onset for run in (right, wrong)]
    assert 0 < found[0] < 125
    assert 0 < found[1] < 125
    assert np.rad2deg(np.abs(right["alpha_hat"] - wrong["alpha_hat"]).max()) > 0.3


# Algorithm 1


def test_algorithm_1_takes_n_qp_iterations_for_each_kappa():
    kappas = [it.kappa for it in interior_point.interior_point(random_qp(0), TUNING)]
    assert kappas == pytest.approx([1.0, 1.0, 0.1, 0.1])
    assert printed.kappas_algorithm_1(1.0, 2, 2) == pytest.approx([1.0, 0.1, 0.1, 0.01])
    three = replace(TUNING, n_kappa=2, n_qp=3)
    kappas = [it.kappa for it in interior_point.interior_point(random_qp(0), three)]
    assert kappas == pytest.approx([1.0, 1.0, 1.0, 0.1, 0.1, 0.1])


def test_algorithm_1_stays_strictly_inside_where_the_barrier_is_finite():
    d1, d2 = np.array([2.0, 4.0]), np.array([3.0, 3.0])
    direction = np.array([2.0, 1.0])  # the full step ends on the first upper bound
    s = interior_point.line_search((direction,), [(d1, d2)], TUNING.n_s_max)
    assert s == 0.5
    assert np.isfinite(gradient(d1 - s * direction, d2 + s * direction)).all()
    assert printed.inside_algorithm_1(direction, d1, d2)
    with np.errstate(divide="ignore"):
        assert np.isinf(gradient(d1 - direction, d2 + direction)).any()


# Algorithm 2


def factorisation(qp, first):
    """Return what lines 1 to 18 leave, by absolute index from `first`, computed densely stage by stage."""
    last = first + 2
    A = dict(enumerate(qp.A, start=first))
    C = dict(enumerate(qp.C, start=first))
    P_hat, x_hat = np.diag(TUNING.P), np.zeros(4)
    left = {name: {} for name in ("P_f", "Omega", "Pi", "innovation", "x", "u")}
    for i in range(first, last + 1):
        Pi = C[i] @ P_hat
        Omega = C[i].T @ np.linalg.inv(np.diag(TUNING.R) + Pi @ C[i].T)
        r = qp.r_y[i - first] - C[i] @ x_hat
        left["Pi"][i], left["Omega"][i], left["innovation"][i] = Pi, Omega, r
        left["P_f"][i] = P_hat - P_hat @ Omega @ Pi
        left["x"][i] = x_hat + P_hat @ Omega @ r
        if i < last:
            left["u"][i] = qp.r_u[i - first]
            x_hat = qp.f[i - first] + A[i] @ left["x"][i] + TUNING.t_s * left["u"][i]
            P_hat = A[i] @ left["P_f"][i] @ A[i].T + TUNING.t_s**2 * np.diag(TUNING.Q)
    return A, left


def test_algorithm_2_goes_back_to_l_not_to_zero():
    qp, k = random_qp(0), 10
    first = k - 2
    arguments = {"Q_bar": dict.fromkeys(range(first, k), TUNING.Q), "B": TUNING.t_s}
    A, left = factorisation(qp, first)
    x, _ = printed.backward_recursion_algorithm_2(first, k, A, **arguments, **left)
    right = newton_step(qp, np.zeros((3, 4)), np.zeros((2, 4)), 0.0, TUNING)
    assert error(np.array([x[i] for i in range(first, k + 1)]), right[0], SIGMA_X) < 1e-9
    A, left = factorisation(qp, first)
    with pytest.raises(KeyError):  # line 21 as printed, i = k - 1 to 0, asks for samples before the window
        printed.backward_recursion_algorithm_2(0, k, A, **arguments, **left)


# III-C


def test_alpha_is_observable_without_its_sensors_only_through_a21():
    g, pitch = 9.80665, 0.05
    theta = np.array([180.0, pitch, 0.0, g * np.sin(pitch), -g * np.cos(pitch), 1500.0])  # steady flight
    x = np.array([0.05, 180.0, 0.0, 0.0])
    unknown = [0, 1, 3]  # alpha, V_g, W_z
    A, C = transition_jacobian(x, theta, TUNING), output(x, theta, TUNING)[1][:2]  # configuration IV
    A, C = A[np.ix_(unknown, unknown)], C[:, unknown]

    def smallest(a21):
        changed = A.copy()
        changed[1, 0] = a21
        rows = np.vstack([C @ np.linalg.matrix_power(changed, n) for n in range(3)])
        return np.linalg.svd(rows * [0.001, 0.1, 0.1])[1].min()

    assert abs(A[1, 0]) < 1e-12  # t_s f_alpha
    assert smallest(A[1, 0]) < 1e-12
    assert smallest(5.0 * TUNING.t_s) > 1e-6
