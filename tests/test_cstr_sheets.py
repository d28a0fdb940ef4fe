"""Paper 001's sheets: equal to their reference, their numbers, their budgets, and what any input makes of them."""

from __future__ import annotations

import shutil
from dataclasses import fields, replace
from pathlib import Path

import numpy as np
import pytest

import saoflow
from saoflow.diagrams.expression_value import evaluate
from verification.plants.cstr import simulate
from verification.reference.cstr.estimator import ALGORITHM_1, ALGORITHM_2, frames
from verification.reference.cstr.tuning import Tuning
from verification.verifier import verify
from verification.verifier.cstr_case import (
    cstr_ahead,
    cstr_ahead_no_est,
    cstr_mhe,
    cstr_mhe_no_est,
    reactor_case,
)
from verification.verifier.cstr_scenarios import reactor_scenarios

SHEETS = Path(saoflow.__file__).parent / "diagrams" / "cstr"
CASES = {case.sheet: case for case in (cstr_mhe, cstr_mhe_no_est, cstr_ahead, cstr_ahead_no_est)}
WITHOUT = {"cstr_mhe_no_est", "cstr_ahead_no_est"}
TUNING = Tuning()


@pytest.mark.parametrize(("sheet", "compared"), [("cstr_mhe", 240), ("cstr_mhe_no_est", 120), ("cstr_ahead", 240), ("cstr_ahead_no_est", 80)])
def test_the_sheet_equals_its_reference(sheet, compared):
    report = verify(sheet, frames=compared, seed=2)
    assert report.passed, report.summary
    assert report.frames == compared


def test_the_runs_visit_what_there_is_to_compare():
    """Held components, accepted updates and refused ones, first frames: or equality would mean little."""
    held, accepted, second = 0, set(), set()
    for scenario in reactor_scenarios(240, 2):
        out = saoflow.load("cstr_ahead").simulator(probes=["passes[3].free"]).run(scenario.inputs)
        held += int((out["passes[3].free"] == 0.0).any(axis=(1, 2)).sum())
        judged = out["valid"] == 1.0
        accepted |= set(out["accepted"][judged])
        second |= set(out["second_order"][judged])
    assert held > 20
    assert accepted == {0.0, 1.0}
    assert second == {0.0, 1.0}


@pytest.mark.parametrize("samples", [2, 7])
def test_n_is_a_parameter(samples):
    tuning = replace(TUNING, N=samples)
    for sheet, method in (("cstr_mhe", ALGORITHM_1), ("cstr_ahead", ALGORITHM_2)):
        loaded = saoflow.load(sheet, parameters={"N": samples, "n_GN": 2})
        case = reactor_case(sheet, replace(tuning, n_GN=2), method)
        report = verify(loaded, case, frames=60)
        assert report.passed, report.summary


@pytest.mark.parametrize(("sheet", "each", "rest"), [("cstr_mhe", 664, 299), ("cstr_ahead", 860, 572)])
def test_operations_grow_linearly_with_n_inside_the_budget(sheet, each, rest):
    for samples in (3, 10, 20):
        report = saoflow.load(sheet, parameters={"N": samples}).budget()
        report.raise_if_over()
        used = next(line.used for line in report.lines if line.kind == "operations")
        assert used == each * samples + rest


@pytest.mark.parametrize("sheet", list(CASES))
def test_every_number_of_the_tuning_is_the_sheets_too(sheet):
    declared = {p.name.text: p for p in saoflow.load(sheet).sheet.parameters}
    tuning = {f.name: getattr(TUNING, f.name) for f in fields(Tuning)}
    first = tuning.pop("n_GN_first")
    if sheet in WITHOUT:
        tuning["n_GN"] = first
    else:
        for name in ("damping", "relax", "damping_min", "damping_max", "J_margin"):
            assert name not in declared
            del tuning[name]
    if "ahead" not in sheet:
        del tuning["optimal"]
    for name, value in tuning.items():
        assert float(evaluate(declared[name].value, {}).array) == value, name
        assert declared[name].source is not None, name


@pytest.mark.parametrize("path", sorted(SHEETS.glob("*.yaml")), ids=lambda path: path.stem)
def test_says_which_equations_and_keeps_to_the_profile(path):
    """The numerics are in profile six; decisions are where components are held, updates judged and windows started."""
    sheet = saoflow.load(str(path)).sheet
    assert sheet.doc.endswith(".")
    assert sheet.equations
    deciding = {"free_components", "window_pass", "shooting_pass", "second_order", "sensitivity_update", "shooting_update"}
    deciding |= {"information_vector", "start_of_window", *CASES}
    assert sheet.profile.text == ("sao" if path.stem in deciding else "six")


@pytest.mark.parametrize("sheet", list(CASES))
def test_any_input_gives_finite_estimates_in_x(sheet):
    generator = np.random.default_rng(5)
    n = 150
    choices = np.array([np.nan, np.inf, -np.inf, 1e300, -1e300, 0.0, 0.38, 0.75, 1.4, 5.0])
    y = np.where(generator.random(n) < 0.5, generator.choice(choices, n), generator.normal(0.75, 0.3, n))
    u = np.where(generator.random(n) < 0.5, generator.choice(choices, n), generator.normal(300.0, 600.0, n))
    out = saoflow.load(sheet).simulator().run({"y": y, "u": u})
    for name in ("x_hat", "window"):
        assert np.all(np.isfinite(out[name]))
        assert np.all((out[name] >= TUNING.lower) & (out[name] <= TUNING.upper))


@pytest.mark.parametrize(
    ("file", "right", "wrong"),
    [
        ("transition_noise.yaml", "-1/theta, there.r]", "1/theta, there.r]"),
        ("sensitivity_update.yaml", "push: {mul: [innovation, 1/sigma_y^2]}", "push: {mul: [-innovation, 1/sigma_y^2]}"),
        ("transition_curvature.yaml", '["weighted[0]", "-weighted[1]"]', '["weighted[0]", "weighted[1]"]'),
        ("free_components.yaml", "[gradient, push_min], relation: \">\"", "[gradient, push_min], relation: \"<\""),
        ("second_order.yaml", "[least, 0]", "[least, 3e4]"),
        ("start_of_window.yaml", '"last[1]"]', '"last[0]"]'),
    ],
)
def test_a_defect_is_found(tmp_path, file, right, wrong):
    """Copies of the sheets with one defect each, the printed sign of K_t among them."""
    for path in SHEETS.glob("*.yaml"):
        shutil.copy(path, tmp_path)
    text = (tmp_path / file).read_text(encoding="utf-8")
    assert text.count(right) == 1
    (tmp_path / file).write_text(text.replace(right, wrong), encoding="utf-8")
    report = verify(saoflow.load(str(tmp_path / "cstr_ahead.yaml")), cstr_ahead, frames=80)
    assert not report.passed


def test_the_c_runs_the_same_frames():
    sheet = saoflow.load("cstr_ahead")
    recording = simulate(4, steps=60).recording
    one, two = sheet.simulator().run(recording), sheet.simulator(backend="c").run(recording)
    for name in one:
        np.testing.assert_array_equal(one[name], two[name])


def test_the_table_moves_an_estimate_by_less_than_a_thousandth():
    recording = simulate(6, steps=100).recording
    right = np.array([frame.x_hat for frame in frames(recording, TUNING, ALGORITHM_2)])
    assert np.abs(saoflow.load("cstr_ahead").simulator().run(recording)["x_hat"] - right).max() < 1e-3
