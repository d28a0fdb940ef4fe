"""The sheets of paper 003: their parameters, budgets, equality with the numpy reference, and defects that are found.

10 000 frames of each are the verifier's work (``saoflow verify mho_pe``); here they are few.
"""

from __future__ import annotations

import shutil
from collections.abc import Callable
from dataclasses import fields, replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

import saoflow
from saoflow.codegen.compiler import find_compiler
from saoflow.diagrams.expression_value import evaluate
from saoflow.pipeline import LoadedSheet
from saoflow.units import Unit
from tests.sheet_text import same_bits
from verification.reference.mho import mho_pe as pe
from verification.reference.mho import mho_wd as wd
from verification.reference.mho.tuning import MhoTuning
from verification.verifier import find_reference, verify
from verification.verifier.case import ReferenceCase
from verification.verifier.mho_case import observer_case
from verification.verifier.mho_cases import RECURSION
from verification.verifier.mho_scenarios import KINDS, mho_scenarios
from verification.verifier.report import Report

FOLDER = Path(saoflow.__file__).parent / "diagrams" / "mho"
TUNING = MhoTuning()
OBSERVERS = ("mho_pe", "mho_wod", "mho_wd", "mho_wd_condensed")
SHEETS = (*OBSERVERS, "ekf", "mho_fault_detection")


def case(sheet: str, N: int = 4) -> ReferenceCase:
    """The reference case with another horizon."""
    if sheet == "mho_pe":
        return observer_case(sheet, pe.mho_pe, MhoTuning(N=N))
    if sheet == "mho_wod":
        return observer_case(sheet, pe.mho_wod, MhoTuning(N=N))
    return observer_case(sheet, wd.mho_wd, MhoTuning(N=N), disturbed=True, tolerance=RECURSION)


@cache
def loaded(sheet: str, N: int = 4) -> LoadedSheet:
    return saoflow.load(sheet, parameters={} if N == 4 else {"N": N})


# -- what the sheets declare


def printed(array: str) -> np.ndarray:
    """The numbers of an array as the netlist shows it."""
    return np.array(array.replace("[", " ").replace("]", " ").split(), dtype=float)


IN_OTHERS = {"n_eval", "alpha_threshold", "alpha_range"}
"""What only the detection needs; it calls alpha_range alpha_valid."""


def test_every_number_is_the_references() -> None:
    declared = {p.name.text: p for p in loaded("mho_pe").sheet.parameters}
    values = dict(loaded("mho_pe").netlist.parameters)
    for field in fields(MhoTuning):
        if field.name in IN_OTHERS or field.name == "L":
            continue
        assert float(values[field.name]) == getattr(TUNING, field.name), field.name
        unit = declared[field.name].unit
        assert (Unit.parse("1") if unit is None else Unit.parse(str(unit.items))) == Unit.parse(field.metadata["unit"])
    np.testing.assert_array_equal(printed(values["L"]).reshape(3, 3), TUNING.gain)
    for name in ("M", "W", "Q"):
        np.testing.assert_allclose(printed(values[name]), getattr(TUNING, name), rtol=1e-8)
    detection = dict(loaded("mho_fault_detection").netlist.parameters)
    assert float(detection["n_eval"]) == TUNING.n_eval
    assert float(detection["alpha_threshold"]) == TUNING.alpha_threshold
    assert float(detection["alpha_valid"]) == TUNING.alpha_range


@pytest.mark.parametrize("sheet", SHEETS)
def test_every_number_has_a_source(sheet: str) -> None:
    """Those without are put together from those with."""
    for parameter in loaded(sheet).sheet.parameters:
        assert parameter.source or parameter.unit is None, parameter.name.text
        if not parameter.source and parameter.value is not None:
            with pytest.raises(saoflow.DiagnosisError):
                evaluate(parameter.value, {})  # it names others


@pytest.mark.parametrize("path", sorted(FOLDER.glob("*.yaml")), ids=lambda path: path.stem)
def test_says_which_equations(path: Path) -> None:
    sheet = saoflow.load(str(path)).sheet
    assert sheet.doc.endswith(".")
    assert sheet.equations
    assert sheet.profile is not None


@pytest.mark.parametrize("name", ["mho_pe_step", "mho_wd_step", "mho_wd_condensed_step", "ekf_step"])
def test_the_numerics_are_in_profile_six(name: str) -> None:
    profile = saoflow.load(str(FOLDER / f"{name}.yaml")).sheet.profile
    assert profile is not None
    assert profile.text == "six"


@pytest.mark.parametrize("N", [2, 20])
@pytest.mark.parametrize("sheet", ["mho_pe", "mho_wod", "mho_wd"])
def test_the_budget_fits_every_horizon(sheet: str, N: int) -> None:
    report = loaded(sheet, N).budget()
    report.raise_if_over()
    assert report.tree.total > 0.6 * (100 + N * 160)


@pytest.mark.parametrize("sheet", ["ekf", "mho_fault_detection", "mho_wd_condensed"])
def test_the_budget_fits(sheet: str) -> None:
    loaded(sheet).budget().raise_if_over()


@pytest.mark.parametrize("sheet", ["mho_pe", "mho_wod", "mho_wd"])
def test_operations_grow_in_proportion(sheet: str) -> None:
    two, four, twenty = (loaded(sheet, N).budget().tree.total for N in (2, 4, 20))
    assert (twenty - four) * 2 == (four - two) * 16


def test_mho_wd_costs_little_more_than_mho_pe() -> None:
    pe_20, wd_20 = (loaded(sheet, 20).budget().tree.total for sheet in ("mho_pe", "mho_wd"))
    assert 1.0 < wd_20 / pe_20 < 1.2


# -- equality with the reference


@pytest.mark.parametrize("sheet", SHEETS)
def test_the_sheet_equals_its_reference(sheet: str) -> None:
    report = verify(loaded(sheet), frames=360)
    assert report.passed, report.summary
    assert {name.split(":")[0] for name in report.scenarios} == set(KINDS)


@pytest.mark.parametrize(("sheet", "N"), [("mho_pe", 15), ("mho_wod", 2), ("mho_wd", 2), ("mho_wd", 20)])
def test_so_it_does_with_other_horizons(sheet: str, N: int) -> None:
    quick = replace(case(sheet, N), closed_loop=None)
    report = verify(loaded(sheet, N), quick, frames=60)
    assert report.passed, report.summary


def test_both_forms_of_mho_wd_take_the_same_step() -> None:
    inputs = mho_scenarios(60, 3)[0].inputs
    one, other = (loaded(sheet).simulator(exact=True).run(_ports(sheet, inputs)) for sheet in OBSERVERS[2:])
    np.testing.assert_allclose(one["alpha_hat"], other["alpha_hat"], rtol=0, atol=1e-13)
    np.testing.assert_allclose(one["vt_hat"], other["vt_hat"], rtol=0, atol=1e-11)


def _ports(sheet: str, inputs: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    return {port: inputs[port] for port in loaded(sheet).input_types}


@pytest.mark.parametrize("sheet", SHEETS)
def test_references_are_found_by_the_name_of_the_sheet(sheet: str) -> None:
    found, _ = find_reference(sheet)
    assert isinstance(found, ReferenceCase)
    assert found.sheet == sheet


@pytest.mark.skipif(find_compiler() is None, reason="there is no C compiler on this machine")
@pytest.mark.parametrize("sheet", ["mho_wd", "ekf", "mho_fault_detection"])
def test_the_compiled_frames_have_the_interpreters_bits(sheet: str) -> None:
    inputs = _ports(sheet, dict(mho_scenarios(600, 2)[2].inputs))  # with gaps
    one = loaded(sheet).simulator().run(inputs)
    other = loaded(sheet).simulator(backend="c").run(inputs)
    assert all(same_bits(one[port], other[port]) for port in one)


def test_a_horizon_out_of_range_is_diagnosed() -> None:
    with pytest.raises(saoflow.DiagnosisError, match="N") as refused:
        saoflow.load("mho_wd", parameters={"N": 1}).check()
    assert "2" in str(refused.value)


# -- robustness


@pytest.mark.parametrize("sheet", SHEETS)
def test_outputs_recover_from_any_gap(sheet: str) -> None:
    scenario = mho_scenarios(600, 5)[0]
    clean = _ports(sheet, dict(scenario.inputs))
    simulator = loaded(sheet).simulator()
    expected = simulator.run(clean)["alpha_hat"]
    gappy = {port: values.copy() for port, values in clean.items()}
    for i, values in enumerate(gappy.values()):
        values[:5] = np.nan
        values[40 + i : 46] = (np.nan, np.inf, -np.inf)[i % 3]
    simulator.reset()
    out = simulator.run(gappy)
    assert all(np.isfinite(values).all() for values in out.values())
    assert np.abs(out["alpha_hat"][-30:] - expected[-30:]).max() < np.radians(0.01)


def test_the_detection_confirms_a_runaway_and_nothing_else() -> None:
    runs = {scenario.name.split(":")[0]: scenario.inputs for scenario in mho_scenarios(2400, 1)}
    simulator = loaded("mho_fault_detection").simulator()
    for kind, faulty in (("fault-free", False), ("input biases", False), ("runaway", True), ("oscillation", True)):
        simulator.reset()
        out = simulator.run(dict(runs[kind]))
        assert bool(out["alpha_faulty"].any()) is faulty, kind


# -- defects


def verify_quickly(sheet: LoadedSheet, name: str) -> Report:
    quick = replace(case(name) if name != "ekf" else find_reference("ekf")[0], closed_loop=None)
    return verify(sheet, quick, frames=60)


DEFECTS = {
    "printed order of Phi": ("mho_pe", "mho_pe_stage", "[Phi, Psi]", "[Psi, Phi]", "p (12)"),
    "a sign in Phi": ("mho_pe", "mho_pe_stage", "[motion.A, -LC]", "[motion.A, LC]", "p (12)"),
    "V_z up and down": ("mho_wod", "mho_output", '["x[1]", -V_sin, "x[2]"]', '["x[1]", V_sin, "x[2]"]', "p (12)"),
    "the inputs one sample late": ("mho_pe", "mho_memory", "inputs.y[:-1]", "inputs.y[1:]", "x_bar"),
    "the pull of w": ("mho_wd", "mho_wd_stage", "[A_dx, -w]", "[A_dx, w]", "p (12)"),
    "w not shifted": ("mho_wd", "mho_disturbance_memory", '["w[1:]", "[zeros(3)]"]', '["w[:-1]", "[zeros(3)]"]', "a priori disturbances"),
    "a_12 forgotten": ("ekf", "mho_transition_jacobian", "[a_11, -minus_a_12, a_13]", "[a_11, 0, a_13]", "P_k+1|k"),
}  # fmt: skip


@pytest.mark.parametrize("defect", DEFECTS)
def test_a_planted_defect_is_found_and_located(tmp_path: Path, defect: str) -> None:
    sheet, file, old, new, first = DEFECTS[defect]
    shutil.copytree(FOLDER, tmp_path / "mho")
    path = tmp_path / "mho" / f"{file}.yaml"
    text = path.read_text(encoding="utf-8")
    assert text.count(old) == 1
    path.write_text(text.replace(old, new), encoding="utf-8")
    report = verify_quickly(saoflow.load(str(tmp_path / "mho" / f"{sheet}.yaml")), sheet)
    assert not report.passed
    assert report.failures[0].quantity == first, report.summary


CHANGED: dict[str, Callable[[], object]] = {
    "q_v": lambda: 1511.8,
    "prior_v": lambda: 5.00001,
    "L_theta": lambda: [0.2621, -1.448, 0.41391],
    "vt_nominal": lambda: 300.001,
}


@pytest.mark.parametrize("parameter", CHANGED)
def test_a_changed_parameter_is_found(parameter: str) -> None:
    name = "mho_wd" if parameter == "q_v" else "mho_pe"
    changed = saoflow.load(name, parameters={parameter: CHANGED[parameter]()})
    assert not verify_quickly(changed, name).passed
