"""`saoflow verify` on the flagship, shortened; and defects planted in copies of its sheets, which it must find."""

from __future__ import annotations

import shutil
from dataclasses import fields, replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

import saoflow
from saoflow import load
from verification.flights import Fault, Missing, load_recording, sensors
from verification.reference.tuning import Tuning
from verification.verifier import Scenario, find_reference, verify
from verification.verifier.cases import cmhe_fte, ekf_fte, umhe_fte
from verification.verifier.ekf_case import ekf_case
from verification.verifier.scenarios import edge_frames, flight_scenarios

SHEETS = Path(saoflow.__file__).parent / "diagrams" / "cmhe_fte"


@pytest.mark.parametrize("sheet", ["cmhe_fte", "umhe_fte", "ekf_fte"])
def test_the_sheet_equals_its_reference(sheet):
    report = verify(sheet, frames=600)
    assert report.passed, report.summary
    assert report.frames == 600
    # At most one frame in 1000 may take another step length; in these 600 none does.
    assert report.other_choices == ()
    assert all(check.frames >= 590 for check in report.checks if check.part != "closed loop with tables")
    assert max(check.ratio for check in report.checks if check.passed is not None) < 1.0


def test_the_runs_visit_what_there_is_to_compare():
    """Every configuration, short step lengths, the wind at its bound: or equality would mean little."""
    simulator = load("cmhe_fte").simulator(probes=[f"step3.ip[{j}].search.s" for j in range(4)])
    seen, steps = set(), set()
    for scenario in flight_scenarios(600, 1):
        simulator.reset()
        out = simulator.run(scenario.inputs)
        seen |= set(out["configuration"])
        steps |= {s for j in range(4) for s in out[f"step3.ip[{j}].search.s"]}
    assert seen == {1.0, 2.0, 3.0, 4.0}
    assert steps > {0.0, 1.0, 0.5, 0.25, 0.125}
    simulator.reset()
    bound = next(scenario for scenario in flight_scenarios(4000, 1) if scenario.name.startswith("vc lost"))
    assert np.abs(simulator.run(bound.inputs)["wx_hat"]).max() > 59.9
    kinds = {scenario.name.split(":")[0] for scenario in flight_scenarios(4000, 1)}
    assert {"alpha lost", "both lost", "edges of the ranges", "gaps", "some sensors"} < kinds


def test_references_are_found_by_the_name_of_the_sheet():
    assert find_reference("cmhe_fte")[0] is cmhe_fte
    assert find_reference("umhe_fte")[0] is umhe_fte
    assert find_reference("ekf_fte")[0] is ekf_fte


ALIASES = {"n_horizon": "N", "n_qp": "n_QP"}
CMHE_ONLY = (
    *("vg_min", "vg_max", "wx_max", "wz_max", "kappa_init", "kappa_factor", "n_kappa", "n_qp", "n_s_max"),
    *("clip_margin", "distance_floor"),
)


@pytest.mark.parametrize("sheet", ["cmhe_fte", "umhe_fte", "ekf_fte"])
def test_every_number_of_the_tuning_is_the_sheets_too(sheet):
    """A threshold off by a hair would differ in no sampled frame: so the numbers themselves are compared."""
    from saoflow.diagrams.expression_value import evaluate

    declared = {p.name.text: p for p in load(sheet).sheet.parameters}
    others = {"cmhe_fte": ("umhe_", "ekf_"), "umhe_fte": (*CMHE_ONLY, "ekf_"), "ekf_fte": (*CMHE_ONLY, "umhe_u_factor")}
    other = others[sheet]
    for field in fields(Tuning):
        name = ALIASES.get(field.name, field.name)
        if name not in declared:
            assert field.name.startswith(other), f"{sheet} has no parameter {name}"
        else:
            assert float(evaluate(declared[name].value, {}).array) == getattr(Tuning(), field.name), name


# Defects


@cache
def short_runs():
    """160 frames in which all that the defects touch is met."""
    loud = [
        Fault("runaway", "vc", rate=-90.0, onset=2.6),
        Fault("bias", "alpha", which=(1, 2), amplitude=9.0, onset=2.6),
    ]
    gap = [Missing(("vg", "alpha_1", "q"), onset=0.5, frames=3)]
    windy = load_recording("a320_wind_350kt_5000ft").part(12.0, 16.8)
    return [
        Scenario("faults and a gap", sensors(windy, 3, faults=loud, missing=gap).inputs()),
        edge_frames(60, np.random.default_rng(1)),
    ]


def verify_quickly(sheet, case=cmhe_fte):
    return verify(sheet, replace(case, scenarios=lambda frames, seed: short_runs(), closed_loop=None))


def test_the_shipped_sheet_passes_the_runs_of_the_defects():
    assert verify_quickly(load("cmhe_fte")).passed


DEFECTS = {
    "the printed sign of W_z in (15)": ("output_equation", '{add: [-Vg_sin, "-x[3]"]}', '{add: [-Vg_sin, "x[3]"]}', "r_y"),
    "a sign in (46e)": ("newton_output", "{add: [r_y, -C_dx]}", "{add: [r_y, C_dx]}", "r_y (46e)"),
    "the gradient's sign in (46d)": ("newton_transition", "-kappa_g]", "kappa_g]", "r_u (46d)"),
    "P_f without its minus": ("measurement_update", "{add: [P_hat, -KPi]}", "{add: [P_hat, KPi]}", "P_f"),
    "a sign in line 25": ("backward_stage", "{add: [xi, -Omega_r]}", "{add: [xi, Omega_r]}", "direction of x"),
    "2^-3 for 2^-2": ("line_search", "1, 2^-1, 2^-2,", "1, 2^-1, 2^-3,", "frames with another choice"),
    "kappa falls as printed": ("step3", "floor(index/n_QP)", "floor((index + 1)/n_QP)", "r_y (46e)"),
    "weights 1/J for 1/J^2": ("step2", "[per_J, per_J]", "[per_J, 1]", "fused (19)"),
    "a missing sensor's residual": ("step1", "[valid, difference, 0]", "[valid, difference, 0.001]", "residuals (17)"),
    "the warm start not shifted": ("warm_start", '["x[1:]", "[x_next]"]', '["x[:-1]", "[x_next]"]', "warm start of x"),
}  # fmt: skip


EKF_DEFECTS = {
    "a sign in the gain's covariance": ("measurement_update", "{add: [P_hat, -KPi]}", "{add: [P_hat, KPi]}", "P_f"),
    "half of Q": ("ekf_fte", "Q_bar: Q,", "Q_bar: 0.5*Q,", "P_hat, one step ahead"),
    "two elements of P exchanged": ("step3_extended_kalman", "P_prior[2], P_prior[5], P_prior[7]", "P_prior[2], P_prior[6], P_prior[7]", "P_hat"),
    "no new start of the covariance": ("ekf_fte", "{or: [start.load, P_lost]}", "{or: [start.load, start.load]}", "P_hat"),
    "an absent row counts": ("ekf_fte", "{mul: [present, counts]}", "{mul: [counts, counts]}", "rows that count"),
    "linearised at the prediction": ("ekf_fte", "coming: {transition: {x: step3.x,", "coming: {transition: {x: x_prior,", "P_hat, one step ahead"),
}  # fmt: skip


@pytest.mark.parametrize("defect", EKF_DEFECTS)
def test_a_defect_planted_in_the_filter_is_found_and_located(tmp_path, defect):
    sheet, old, new, first = EKF_DEFECTS[defect]
    shutil.copytree(SHEETS, tmp_path / "sheets")
    path = tmp_path / "sheets" / f"{sheet}.yaml"
    text = path.read_text(encoding="utf-8")
    assert text.count(old) == 1
    path.write_text(text.replace(old, new), encoding="utf-8")
    parameters = {"ekf_p_factor": 2.0} if "new start" in defect else {}
    case = ekf_case(replace(Tuning(), **parameters), ekf_fte.closed_loop)
    good = verify_quickly(load(str(SHEETS / "ekf_fte.yaml"), parameters=parameters), case)
    assert good.passed, good.summary
    report = verify_quickly(load(str(tmp_path / "sheets" / "ekf_fte.yaml"), parameters=parameters), case)
    assert not report.passed
    assert report.failures[0].quantity == first, report.summary


@pytest.mark.parametrize("defect", DEFECTS)
def test_a_planted_defect_is_found_and_located(tmp_path, defect):
    sheet, old, new, first = DEFECTS[defect]
    shutil.copytree(SHEETS, tmp_path / "sheets")
    path = tmp_path / "sheets" / f"{sheet}.yaml"
    text = path.read_text(encoding="utf-8")
    assert text.count(old) == 1
    path.write_text(text.replace(old, new), encoding="utf-8")
    report = verify_quickly(load(str(tmp_path / "sheets" / "cmhe_fte.yaml")))
    assert not report.passed
    assert report.failures[0].quantity == first, report.summary
    assert report.failures[0].where is not None


@pytest.mark.parametrize(
    ("parameter", "value", "first"),
    [
        ("q_w", 1.000001, "Q_bar (46f)"),
        ("n_detect", 6, "wind from before"),
        ("vg_valid_min", 100.0001, "Theta"),
        ("z_nominal", 3000.001, "held inputs"),
        ("wx_max", 60.0001, "r_y (46e)"),
    ],
)
def test_a_changed_parameter_is_found(parameter, value, first):
    report = verify_quickly(load("cmhe_fte", parameters={parameter: value}))
    assert not report.passed
    assert report.failures[0].quantity == first, report.summary
