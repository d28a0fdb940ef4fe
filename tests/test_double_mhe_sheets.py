"""Paper 002's sheets against their references, from either guess, on the bounds; and defects that must not pass."""

from __future__ import annotations

import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import saoflow
from verification.plants.scalar_system import ScalarSystem
from verification.reference.double_mhe.estimators import run_convexified, run_double, run_nonlinear
from verification.reference.double_mhe.tuning import Tuning
from verification.verifier import verify

FOLDER = Path(saoflow.__file__).parent / "diagrams" / "double_mhe"
SHEETS = ("convexified_mhe", "linearised_mhe", "double_mhe", "nonlinear_mhe")
RUNS = {"convexified_mhe": run_convexified, "double_mhe": run_double, "nonlinear_mhe": run_nonlinear}


@pytest.mark.parametrize("name", SHEETS)
def test_a_sheet_equals_its_reference_and_keeps_its_budget(name: str):
    report = verify(name, frames=200)
    assert report.passed, report
    assert not saoflow.load(name).budget().over


@pytest.mark.parametrize("name", RUNS)
def test_from_the_wrong_guess_and_with_another_window(name: str):
    recording = ScalarSystem(duration=0.4).recording(2)
    given = {"x_0": -1.0, "N": 6}
    got = saoflow.load(name, parameters=given).simulator().run({"y": recording["y"], "u": recording["u"]})
    right = RUNS[name](recording, replace(Tuning(), guess=-1.0, n=6))
    for output, rows in right.items():
        np.testing.assert_allclose(got[output], rows, rtol=0.0, atol=1e-9)
    assert right["x_hat"][0] < 0.1 and np.abs(right["x_hat"][-1] - recording["x_true"][-1]) < 0.1


@pytest.mark.parametrize("name", RUNS)
def test_every_estimate_is_inside_its_bounds_whatever_comes_in(name: str):
    y = np.array([0.1, np.nan, np.inf, -np.inf, 1e300, *[0.2] * 30])
    x = saoflow.load(name).simulator().run({"y": y, "u": np.ones_like(y)})["x"]
    assert np.all((x >= -1.0) & (x <= 2.0))
    # Once the bad samples have left the window, and the state they left behind its arrival cost, all is well again.
    assert np.abs(x[-1, -1] - 0.2) < 0.35


@pytest.mark.parametrize(
    ("file", "right", "wrong"),
    [
        (
            "window_estimate.yaml",
            "rhs: {add: [Ps, CRy, -rhs_next, rhs_before]}",
            "rhs: {add: [Ps, CRy, rhs_next, rhs_before]}",
        ),
        ("window_estimate.yaml", "none_before: {add: [1, -before]}", "none_before: {add: [1, 0]}"),
        ("active_set_pass.yaml", "kept_high: {and: [at_high, up]}", "kept_high: {and: [at_high, down]}"),
        ("active_set_pass.yaml", 'from_next: {mul: [e, "known[1:]"]}', 'from_next: {mul: [e, "known[:-1]"]}'),
        ("tridiagonal_backward.yaml", "[reduced, -known]", "[reduced, known]"),
        ("scalar_system.yaml", "change: {add: [rate, u]}", "change: {add: [rate, 1]}"),
        ("arrival.yaml", '"x[1:]"', '"x[:-1]"'),
        ("double_mhe.yaml", "1e-5", "1.00001e-5"),
    ],
)
def test_a_defect_does_not_pass(file: str, right: str, wrong: str, tmp_path: Path):
    shutil.copytree(FOLDER, tmp_path / "sheets")
    path = tmp_path / "sheets" / file
    text = path.read_text(encoding="utf-8")
    assert right in text
    path.write_text(text.replace(right, wrong), encoding="utf-8")
    assert not verify(saoflow.load(str(tmp_path / "sheets" / "double_mhe.yaml")), frames=200).passed
