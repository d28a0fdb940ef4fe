"""The sheets cmhe_fte, umhe_fte and ekf_fte: their ports, parameters, budget, and their equality with the numpy reference.

Frame by frame over 10 000 frames is the verifier's work (``saoflow verify``); here the closed loop must stay equal.
"""

from __future__ import annotations

import re
from dataclasses import fields, replace
from functools import cache
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest
from numpy.typing import NDArray

import saoflow
from saoflow.pipeline import LoadedSheet
from saoflow.scheduler.simulator import Simulator
from saoflow.units import Unit
from verification.flights import Fault, load_recording, sensors
from verification.reference import cmhe_fte, ekf_fte, umhe_fte
from verification.reference.arrays import DEGREE
from verification.reference.tuning import Tuning

Array = NDArray[np.float64]
Arrays = dict[str, Array]
REFERENCES: dict[str, ModuleType] = {"cmhe_fte": cmhe_fte, "umhe_fte": umhe_fte, "ekf_fte": ekf_fte}
SHEETS = tuple(REFERENCES)
FOLDER = Path(saoflow.__file__).parent / "diagrams" / "cmhe_fte"
TUNING = Tuning()

INPUTS = {
    "alpha": ((3,), "rad"),
    "vc": ((3,), "kt"),
    "vg": ((), "kt"),
    "vz": ((), "kt"),
    "theta": ((), "rad"),
    "q": ((), "rad/s"),
    "ax": ((), "kt/s^2"),
    "az": ((), "kt/s^2"),
    "z": ((), "m"),
}
OUTPUTS = {
    "alpha_hat": ((), "rad"),
    "vc_hat": ((), "kt"),
    "wx_hat": ((), "kt"),
    "wz_hat": ((), "kt"),
    "alpha_pred": ((), "rad"),
    "vc_pred": ((), "kt"),
    "alpha_rms": ((3,), "rad"),
    "vc_rms": ((3,), "kt"),
    "alpha_faulty": ((3,), None),
    "vc_faulty": ((3,), None),
    "configuration": ((), None),
}


@cache
def flagship(name: str) -> LoadedSheet:
    return saoflow.load(name)


@cache
def simulator(name: str, exact: bool) -> Simulator:
    return flagship(name).simulator(exact=exact)


# -- what the sheets declare


@pytest.mark.parametrize("name", SHEETS)
def test_ports(name: str) -> None:
    program = flagship(name).frame_program
    for ports, expected in ((program.inputs, INPUTS), (program.outputs, OUTPUTS)):
        assert [p.name for p in ports] == list(expected)
        for port in ports:
            shape, unit = expected[port.name]
            assert port.type.shape == shape
            assert port.doc
            if unit is not None:
                assert port.type.units == Unit.parse(unit)
    assert all(p.type.boolean == p.name.endswith("_faulty") for p in program.outputs)


NAMES = {"n_horizon": "N", "n_qp": "n_QP"}
"""The reference's names of parameters, where the sheets have the paper's."""

OTHERS_ALONE = {
    "cmhe_fte": {p.name for p in fields(Tuning) if p.name.startswith(("umhe_", "ekf_"))},
    "umhe_fte": {"ekf_p_factor"},
    "ekf_fte": {"umhe_u_factor"},
}
"""What a sheet does not have, because only another method needs it; the others have all parameters of cmhe_fte."""


def declared(name: str) -> dict[str, tuple[float, Unit | None, str]]:
    """The parameters that are numbers: value, unit, source."""
    sheet = flagship(name)
    values = dict(sheet.netlist.parameters)
    return {
        p.name.text: (float(values[p.name.text]), None if p.unit is None else Unit.parse(str(p.unit.items)), p.source)
        for p in sheet.sheet.parameters
        if p.source
    }


@pytest.mark.parametrize("name", SHEETS)
def test_every_number_is_the_references(name: str) -> None:
    found = declared(name)
    missing = set()
    for parameter in fields(Tuning):
        own = NAMES.get(parameter.name, parameter.name)
        if own not in found:
            missing.add(parameter.name)
            continue
        value, unit, _ = found[own]
        assert value == getattr(TUNING, parameter.name), own
        written = parameter.metadata["unit"]
        if written not in ("1", "width"):
            assert unit == Unit.parse(written), own
    assert missing == OTHERS_ALONE[name]


@pytest.mark.parametrize("rival", ["umhe_fte", "ekf_fte"])
def test_the_sheets_have_the_same_parameters(rival: str) -> None:
    one, other = declared("cmhe_fte"), declared(rival)
    assert {k: v for k, v in one.items() if k in other} == {k: v for k, v in other.items() if k in one}


def test_both_sheets_are_wired_alike() -> None:
    """They differ in how Step 3 solves its quadratic program and in the bounds of the wind and in the budget."""
    one, other = (flagship(name).sheet.lines for name in ("cmhe_fte", "umhe_fte"))
    one, other = (lines[lines.index("inputs:") :] for lines in (one, other))
    assert len(one) == len(other)
    different = [a.split(":")[0].strip() for a, b in zip(one, other, strict=True) if a != b]
    assert different == ["step3", "wx_out", "wz_out", "budget"]


def test_the_filter_is_wired_as_the_window_is_around_step_3() -> None:
    """Steps 0 to 2 and the outputs of ekf_fte read as those of umhe_fte; the prediction has another name."""
    one, other = ("\n".join(flagship(name).sheet.lines) for name in ("umhe_fte", "ekf_fte"))
    other = re.sub(r"x_prior\[(\d)\]", r"warm.x[-1, \1]", other).replace("x_prior", '"warm.x[-1]"')
    for begin, end in (("  # Step 1:", "  # The "), ("outputs:", "budget:")):
        assert one[one.index(begin) : one.index(end)] == other[other.index(begin) : other.index(end)]


@pytest.mark.parametrize("name", SHEETS)
def test_every_number_has_a_source(name: str) -> None:
    """Those without are put together from those with."""
    for parameter in flagship(name).sheet.parameters:
        assert parameter.source or parameter.unit is None, parameter.name.text
        assert parameter.source or not np.isscalar(parameter.value)


@pytest.mark.parametrize("path", sorted(FOLDER.glob("*.yaml")), ids=lambda path: path.stem)
def test_says_which_equations(path: Path) -> None:
    sheet = saoflow.load(str(path)).sheet
    assert sheet.doc.endswith(".")
    assert sheet.equations
    assert sheet.profile is not None


@pytest.mark.parametrize("name", ["step3", "step3_unconstrained", "step3_extended_kalman"])
def test_step_3_is_in_profile_six(name: str) -> None:
    profile = saoflow.load(str(FOLDER / f"{name}.yaml")).sheet.profile
    assert profile is not None
    assert profile.text == "six"


@pytest.mark.parametrize(("name", "limit"), [("cmhe_fte", 19_500), ("umhe_fte", 2_500), ("ekf_fte", 1_400)])
def test_budget(name: str, limit: int) -> None:
    counted = flagship(name).budget().tree.total
    assert 0.5 * limit < counted <= limit


def test_a_longer_window_is_over_budget() -> None:
    with pytest.raises(saoflow.DiagnosisError, match="E401"):
        saoflow.load("cmhe_fte", parameters={"N": 4}).simulator()


@pytest.mark.parametrize("given", [{"t_s": -0.048}, {"r_vc": 0.0}, {"q_w": -1.0}, {"kappa_factor": 2.0}, {"n_s_max": 21}])
def test_what_no_window_can_have_is_refused(given: dict[str, float]) -> None:
    """A frame period or a covariance that is not positive, a barrier that grows, a step beyond its table."""
    with pytest.raises(saoflow.DiagnosisError, match="E208"):
        saoflow.load("cmhe_fte", given).check()


def test_probe_inside_a_stage() -> None:
    program = flagship("cmhe_fte").program(probes=["step3.ip[2].stages[1].K"])
    assert [p.type.shape for p in program.probes] == [(4, 8)]


# -- the closed loop


def with_gaps(inputs: Arrays, seed: int) -> Arrays:
    """The inputs with some samples missing: NaN or infinite for 1 to 40 frames."""
    random = np.random.default_rng(seed)
    inputs = {name: values.copy() for name, values in inputs.items()}
    for values in inputs.values():
        for _ in range(4):
            start = random.integers(0, len(values))
            gap = slice(start, start + random.integers(1, 40))
            values[(gap, random.integers(0, 3)) if values.ndim == 2 else gap] = random.choice([np.nan, np.inf, -np.inf])
    return inputs


RUNAWAY = Fault("runaway", "vc", which=(1, 2, 3), rate=-15.0, onset=5.0)
BIASES = (
    Fault("bias", "alpha", which=(1, 2, 3), amplitude=8.0, onset=5.0),
    Fault("jamming", "vc", which=(2,), amplitude=40.0, onset=6.0),
)


@cache
def scenario(name: str) -> Arrays:
    """A few seconds of a shipped flight, with what the name says."""
    if name == "calm":
        return cut(sensors(load_recording("a320_calm_350kt_5000ft"), 1).inputs())
    if name == "ramps":
        return cut(sensors(load_recording("787_ramps_300kt_15000ft"), 2).inputs(), 500)
    if name == "runaway":
        return cut(sensors(load_recording("a320_calm_350kt_5000ft"), 3, faults=[RUNAWAY]).inputs(), 250)
    if name == "biases":
        return cut(sensors(load_recording("787_shear_280kt_33000ft"), 4, faults=BIASES).inputs(), 250)
    return with_gaps(cut(sensors(load_recording("a320_wind_350kt_5000ft"), 5).inputs(), 400), 6)


def cut(inputs: Arrays, frames: int = 200) -> Arrays:
    return {name: values[:frames] for name, values in inputs.items()}


@cache
def reference_run(name: str, case: str) -> Arrays:
    found: Arrays = REFERENCES[name].run(scenario(case))
    return found


SCENARIOS = ("calm", "ramps", "runaway", "biases", "gaps")


@pytest.mark.parametrize("case", SCENARIOS)
@pytest.mark.parametrize("name", SHEETS)
def test_the_closed_loop_equals_the_reference(name: str, case: str) -> None:
    """Tables replaced by their functions; thousands of roundings later the loop is still at 1e-10."""
    expected = reference_run(name, case)
    loop = simulator(name, True)
    loop.reset()
    found = loop.run(scenario(case))
    for port, values in expected.items():
        np.testing.assert_allclose(np.asarray(found[port], dtype=float), values, rtol=1e-10, atol=1e-10, err_msg=port)


@pytest.mark.parametrize("case", SCENARIOS)
@pytest.mark.parametrize("name", SHEETS)
def test_tables_cost_little(name: str, case: str) -> None:
    """Alpha within 1e-3 deg, airspeed within 0.02 kt, and the same decisions at the same frames."""
    expected = reference_run(name, case)
    loop = simulator(name, False)
    loop.reset()
    found = loop.run(scenario(case))
    for port in ("alpha_faulty", "vc_faulty", "configuration"):
        np.testing.assert_array_equal(np.asarray(found[port], dtype=float), expected[port], err_msg=port)
    for port in ("alpha_hat", "alpha_pred"):
        assert np.abs(found[port] - expected[port]).max() < 1e-3 * DEGREE
    for port in ("vc_hat", "vc_pred"):
        assert np.abs(found[port] - expected[port]).max() < 0.02


@pytest.mark.parametrize(
    ("name", "reference", "sheet"),
    [
        ("cmhe_fte", {"n_horizon": 2, "n_qp": 1, "n_kappa": 3}, {"N": 2, "n_QP": 1, "n_kappa": 3}),
        ("umhe_fte", {"n_horizon": 2}, {"N": 2}),
        ("ekf_fte", {"q_w": 0.1, "p_w": 0.5, "ekf_p_factor": 1.5}, {"q_w": 0.1, "p_w": 0.5, "ekf_p_factor": 1.5}),
        (
            "cmhe_fte",
            {"wx_max": 5.0, "p_w": 0.1, "n_s_max": 3, "n_eval": 6, "n_detect": 2, "alpha_threshold": 1.0},
            {"wx_max": 5, "p_w": 0.1, "n_s_max": 3, "n_eval": 6, "n_detect": 2, "alpha_threshold": 1},
        ),
    ],
)
def test_parameters_mean_the_same(name: str, reference: dict[str, float], sheet: dict[str, float]) -> None:
    inputs = cut(scenario("ramps"), 120)
    expected = REFERENCES[name].run(inputs, replace(TUNING, **reference))  # type: ignore[arg-type]
    found = saoflow.load(name, parameters=sheet).simulator(exact=True).run(inputs)
    for port, values in expected.items():
        np.testing.assert_allclose(np.asarray(found[port], dtype=float), values, rtol=1e-10, atol=1e-10, err_msg=port)


def junk(frames: int, seed: int) -> Arrays:
    """Inputs of every size and kind: stretches of a flight between stretches of nonsense."""
    random = np.random.default_rng(seed)
    flight = sensors(load_recording("a320_wind_350kt_5000ft"), 5).inputs()
    inputs = {}
    for name, values in flight.items():
        plausible = np.resize(values, (frames, *values.shape[1:]))
        size = np.abs(values).max() * random.choice([0.01, 1.0, 3.0], plausible.shape)
        wild = random.normal(size=plausible.shape) * size
        odd = random.choice([np.nan, np.inf, -np.inf, 1e300, -1e300, 5e-324, 0.0], plausible.shape)
        wild = np.where(random.uniform(size=plausible.shape) < 0.2, odd, wild)
        chosen = np.repeat(random.uniform(size=-(-frames // 25)) < 0.4, 25)[:frames]
        inputs[name] = np.where(chosen.reshape(frames, *[1] * (values.ndim - 1)), wild, plausible)
    return inputs


@pytest.mark.parametrize("name", SHEETS)
def test_outputs_stay_finite_and_inside_their_bounds(name: str) -> None:
    t = TUNING
    wx, wz = REFERENCES[name].METHOD.wind_limits(t)
    alpha = t.alpha_min * DEGREE, t.alpha_max * DEGREE
    bounds = {"alpha_hat": alpha, "alpha_pred": alpha, "vc_hat": (0.0, t.vc_out_max), "vc_pred": (0.0, t.vc_out_max)}
    bounds |= {"wx_hat": (-wx, wx), "wz_hat": (-wz, wz), "alpha_rms": (0.0, t.alpha_rms_max * DEGREE)}
    bounds |= {"vc_rms": (0.0, t.vc_rms_max), "configuration": (1.0, 4.0)}
    loop = simulator(name, False)
    for seed in (1, 2, 3):
        loop.reset()
        found = loop.run(junk(1500, seed))
        for port, (low, high) in bounds.items():
            slack = 1e-15 * max(abs(low), abs(high))  # a bound in degrees, rounded on either side
            assert np.all((found[port] >= low - slack) & (found[port] <= high + slack)), port
