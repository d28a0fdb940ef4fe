"""cmhe_fte_lean: the same ports, parameters, decisions and steps as cmhe_fte, and what each change of it saves."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

import saoflow
from saoflow.scheduler.simulator import Simulator, State
from verification.flights import Fault, Missing, load_recording, sensors
from verification.reference import cmhe_fte as reference
from verification.reference.arrays import KNOT
from verification.reference.tuning import Tuning
from verification.results import lean_table
from verification.results.lean_variants import REPLACED, VARIANTS, Variant, loaded
from verification.verifier import Scenario, verify
from verification.verifier.cases import cmhe_fte_lean
from verification.verifier.scenarios import edge_frames

Array = NDArray[np.float64]
Arrays = dict[str, Array]
LEAN = Path(saoflow.__file__).parent / "diagrams" / "cmhe_fte_lean"
DOCUMENT = Path(__file__).parent.parent / "docs" / "lean.md"
TUNING = Tuning()
PASSES = TUNING.n_kappa * TUNING.n_qp
TOLERANCE = 1e-10
"""Relative to max(|reference|, sigma)."""


# -- what the sheets declare


def test_the_same_ports() -> None:
    lean, flagship = (saoflow.load(name).frame_program for name in ("cmhe_fte_lean", "cmhe_fte"))
    for mine, theirs in ((lean.inputs, flagship.inputs), (lean.outputs, flagship.outputs)):
        assert [(p.name, p.type, p.doc) for p in mine] == [(p.name, p.type, p.doc) for p in theirs]


def test_the_same_parameters() -> None:
    lean, flagship = (saoflow.load(name).netlist.parameters for name in ("cmhe_fte_lean", "cmhe_fte"))
    assert dict(lean).keys() == dict(flagship).keys()
    for name, value in dict(flagship).items():
        np.testing.assert_array_equal(dict(lean)[name], value, err_msg=name)


def test_steps_0_to_2_are_the_flagships_sheets() -> None:
    own = {path.stem for path in LEAN.glob("*.yaml")}
    shared = {"conditioning", "start_up", "first_state", "warm_start", "step1", "step2", "configuration", "window"}
    text = (LEAN / "cmhe_fte_lean.yaml").read_text(encoding="utf-8")
    assert not own & shared
    assert all(f"{name}:" in text for name in shared)


@pytest.mark.parametrize("path", sorted(LEAN.glob("*.yaml")), ids=lambda path: path.stem)
def test_says_which_equations_and_keeps_to_the_profile(path: Path) -> None:
    sheet = saoflow.load(str(path)).sheet
    assert sheet.doc.endswith(".")
    assert sheet.equations
    assert sheet.profile is not None
    assert sheet.profile.text == ("sao" if path.stem == "cmhe_fte_lean" else "six")


def test_operations_and_budget() -> None:
    """At most 9 500 was asked; less than a quarter of the flagship is what it takes."""
    counted = saoflow.load("cmhe_fte_lean").budget().tree
    assert 4 * counted.total < saoflow.load("cmhe_fte").budget().tree.total
    assert counted.total <= 4200


# -- step by step from the state of cmhe_fte


def flight(name: str, start: float, seed: int, faults: list[Fault], missing: list[Missing] | None = None) -> Arrays:
    part = load_recording(name).part(start, start + 7.2)
    return sensors(part, seed, faults=faults, missing=missing or []).inputs()


RUNS: dict[str, Callable[[], Arrays]] = {
    "calm": lambda: flight("a320_calm_350kt_5000ft", 0.0, 1, []),
    "lost airspeed": lambda: flight("a320_wind_350kt_5000ft", 10.0, 2, [Fault("runaway", "vc", rate=-60.0, onset=2.6)]),
    "lost alpha": lambda: flight(
        "787_shear_280kt_33000ft", 10.0, 3, [Fault("bias", "alpha", amplitude=10.0, onset=2.6)]
    ),
    "lost both, and gaps": lambda: flight(
        "a320_turbulence_280kt_20000ft",
        5.0,
        4,
        [Fault("bias", "alpha", amplitude=12.0, onset=2.6), Fault("runaway", "vc", rate=-90.0, onset=2.6)],
        [Missing(("vg", "alpha_1", "q"), onset=0.4, frames=5), Missing(("vz", "vc_2"), onset=5.4, frames=3)],
    ),
    "edges of the ranges": lambda: dict(edge_frames(150, np.random.default_rng(7)).inputs),
}

FLAGSHIP = [f"step3.ip[{j}]." for j in range(PASSES)]
LEAN_PASSES = [f"step3.ip[{j}].newton." for j in range(PASSES - 1)] + ["step3.last."]


def of_pass(path: str) -> list[str]:
    return [path + wire for wire in ("direction_x", "direction_u", "search.v", "search.s")]


def flagship_wires(path: str) -> list[str]:
    return [path + "direction_x", path + "backward[0].u", path + "backward[1].u", *of_pass(path)[2:]]


@cache
def simulators() -> tuple[Simulator, Simulator]:
    """cmhe_fte and cmhe_fte_lean with functions for tables, and every pass probed."""
    flagship = saoflow.load("cmhe_fte").simulator(
        exact=True, probes=["step3.u", "step3.x", *(wire for path in FLAGSHIP for wire in flagship_wires(path))]
    )
    lean = saoflow.load("cmhe_fte_lean").simulator(
        exact=True, probes=["step3.u", "step3.x", *(wire for path in LEAN_PASSES for wire in of_pass(path))]
    )
    return flagship, lean


@dataclass(frozen=True)
class SideBySide:
    """Each frame of cmhe_fte, and the same frame of cmhe_fte_lean from the same state."""

    flagship: Arrays
    lean: Arrays
    left: Array  # (frames, slots), the state that cmhe_fte leaves
    left_lean: Array


@cache
def side_by_side(name: str) -> SideBySide:
    inputs = RUNS[name]()
    flagship, lean = simulators()
    flagship.reset()
    frames = len(inputs["vg"])
    states, rows = [flagship.state().slots], []
    for k in range(frames):
        rows.append(flagship.step({port: values[k] for port, values in inputs.items()}))
        states.append(flagship.state().slots)
    places = {(s.path, s.element, s.age): i for i, s in enumerate(flagship.program.states)}
    order = [places[s.path, s.element, s.age] for s in lean.program.states]
    assert sorted(order) == list(range(len(places)))
    before = np.array(states)[:, order]
    # One frame each of as many flights as there are frames.
    lean.restore(State(before[:-1].T.copy(), 0))
    found = lean.run({port: values[:, None] for port, values in inputs.items()})
    return SideBySide(
        {key: np.array([row[key] for row in rows]) for key in rows[0]},
        {key: np.asarray(values)[:, 0] for key, values in found.items()},
        before[1:],
        lean.state().slots.T,
    )


def assert_close(found: Array, expected: Array, sigma: Array | float, what: str) -> None:
    allowed = TOLERANCE * np.maximum(np.abs(expected), sigma)
    assert found.shape == expected.shape
    assert np.all(np.abs(found - expected) <= allowed), what


@pytest.mark.parametrize("name", RUNS)
def test_every_pass_takes_the_flagships_step(name: str) -> None:
    run = side_by_side(name)
    for number, (theirs, mine) in enumerate(zip(FLAGSHIP, LEAN_PASSES, strict=True)):
        x, first, second, v, s = (run.flagship[wire] for wire in flagship_wires(theirs))
        found_x, found_u, found_v, found_s = (run.lean[wire] for wire in of_pass(mine))
        assert_close(found_x, x, np.sqrt(TUNING.P), f"direction of x, pass {number + 1}")
        assert_close(found_u, np.stack([first, second], axis=1), np.sqrt(TUNING.Q), f"of u, pass {number + 1}")
        assert_close(found_v, v, 1.0, f"reach, pass {number + 1}")
        np.testing.assert_array_equal(found_s, s)
    assert_close(run.lean["step3.x"], run.flagship["step3.x"], np.sqrt(TUNING.P), "x")
    assert_close(run.lean["step3.u"], run.flagship["step3.u"], np.sqrt(TUNING.Q), "u")


@pytest.mark.parametrize("name", RUNS)
def test_outputs_and_memory_are_the_flagships(name: str) -> None:
    run = side_by_side(name)
    r_alpha, r_vc = np.sqrt(TUNING.r_alpha), np.sqrt(TUNING.r_vc) / KNOT
    sigma = {"alpha_hat": 1e-3, "alpha_pred": 1e-3, "vc_hat": r_vc, "vc_pred": r_vc}
    sigma |= {"wx_hat": 0.1 / KNOT, "wz_hat": 0.1 / KNOT, "alpha_rms": r_alpha, "vc_rms": r_vc}
    for port in ("alpha_faulty", "vc_faulty", "configuration"):
        np.testing.assert_array_equal(run.lean[port], run.flagship[port], err_msg=port)
    for port, scale in sigma.items():
        assert_close(run.lean[port], run.flagship[port], scale, port)
    assert_close(run.left_lean, run.left, 1e-3, "memory")


def test_the_runs_visit_what_there_is_to_compare() -> None:
    """Every configuration and many step lengths: or equality would mean little."""
    configurations, lengths = set[float](), set[float]()
    for name in RUNS:
        found = side_by_side(name).flagship
        configurations |= set(found["configuration"])
        lengths |= {s for path in FLAGSHIP for s in found[path + "search.s"]}
    assert configurations == {1.0, 2.0, 3.0, 4.0}
    assert lengths >= {0.0, 1.0, 0.5, 0.25, 0.125}


# -- the closed loop


@cache
def lean_loop() -> Simulator:
    return saoflow.load("cmhe_fte_lean").simulator()


@pytest.mark.parametrize("name", RUNS)
def test_with_tables_the_decisions_are_the_references(name: str) -> None:
    inputs = RUNS[name]()
    expected = reference.run(inputs)
    lean_loop().reset()
    found = lean_loop().run(inputs)
    for port in ("alpha_faulty", "vc_faulty", "configuration"):
        np.testing.assert_array_equal(np.asarray(found[port], dtype=float), expected[port], err_msg=port)
    if name == "calm":
        assert np.abs(found["alpha_hat"] - expected["alpha_hat"]).max() < np.deg2rad(1e-3)
        assert np.abs(found["vc_hat"] - expected["vc_hat"]).max() < 0.02


def test_outputs_stay_finite_and_inside_their_bounds() -> None:
    """Nonsense of every size in two frames of five, with NaN, infinities and denormals."""
    random = np.random.default_rng(11)
    flown = RUNS["lost airspeed"]()
    inputs = {}
    for name, values in flown.items():
        plausible = np.resize(values, (900, *values.shape[1:]))
        odd = random.choice([np.nan, np.inf, -np.inf, 1e300, -1e300, 5e-324, 0.0, -1.0], plausible.shape)
        wild = random.normal(size=plausible.shape) * random.choice([0.1, 1.0, 3.0]) * np.abs(values).max()
        nonsense = np.where(random.uniform(size=plausible.shape) < 0.3, odd, wild)
        inputs[name] = np.where(random.uniform(size=plausible.shape) < 0.4, nonsense, plausible)
    lean_loop().reset()
    found = lean_loop().run(inputs)
    alpha = np.deg2rad(TUNING.alpha_min), np.deg2rad(TUNING.alpha_max)
    bounds = {"alpha_hat": alpha, "alpha_pred": alpha, "vc_hat": (0.0, TUNING.vc_out_max)}
    bounds |= {"vc_pred": (0.0, TUNING.vc_out_max), "wx_hat": (-TUNING.wx_max, TUNING.wx_max)}
    bounds |= {"wz_hat": (-TUNING.wz_max, TUNING.wz_max), "alpha_rms": (0.0, np.pi)}
    bounds |= {"vc_rms": (0.0, TUNING.vc_rms_max), "configuration": (1.0, 4.0)}
    for port, (low, high) in bounds.items():
        slack = 1e-15 * max(abs(low), abs(high))  # a bound in degrees, rounded on either side
        assert np.all((found[port] >= low - slack) & (found[port] <= high + slack)), port


@pytest.mark.parametrize(
    "parameters",
    [
        {"n_qp": 1, "n_kappa": 3},
        {"kappa_init": 0.5, "kappa_factor": 0.2},
        {"wx_max": 5.0, "p_w": 0.1, "n_s_max": 3, "q_alpha": 1e-5, "r_vz": 0.5, "t_s": 0.05, "u_v_max": 2.0},
    ],
)
def test_parameters_mean_the_same(parameters: dict[str, float]) -> None:
    inputs = {port: values[:60] for port, values in RUNS["lost airspeed"]().items()}
    expected = reference.run(inputs, replace(TUNING, **parameters))  # type: ignore[arg-type]
    given = {{"n_qp": "n_QP"}.get(name, name): value for name, value in parameters.items()}
    found = saoflow.load("cmhe_fte_lean", parameters=given).simulator(exact=True).run(inputs)
    for port, values in expected.items():
        np.testing.assert_allclose(np.asarray(found[port], dtype=float), values, rtol=1e-10, atol=1e-10, err_msg=port)


def test_another_window_is_refused() -> None:
    with pytest.raises(saoflow.DiagnosisError, match="E20"):
        saoflow.load("cmhe_fte_lean", parameters={"N": 4}).simulator()


# -- `saoflow verify cmhe_fte_lean`


def test_equals_its_reference() -> None:
    report = verify("cmhe_fte_lean", frames=240)
    assert report.passed, report.summary
    assert report.other_choices == ()


@cache
def short_runs() -> list[Scenario]:
    """40 frames of flight with wind, and 40 in which every step length is met."""
    windy = load_recording("a320_wind_350kt_5000ft").part(12.0, 13.92)
    return [Scenario("wind", sensors(windy, 3).inputs()), edge_frames(40, np.random.default_rng(1))]


DEFECTS = {
    "the printed sign of W_z in (15)": (
        "measurement_information", 'Vg_sin, "x[3]"]}', 'Vg_sin, "-x[3]"]}', "information vectors"),
    "a weight in both measurements of alpha": (
        "measurement_information", '["w[2]", cc_21, cc_41]', '["w[2]", "w[2]", cc_21, cc_41]', "information"),
    "A_l the wrong way": ("window_information", 'mul: ["moved.a_21[0]", per_a_11]', 'mul: ["moved.a_21[0]", 1]',
        "a_21/a_11, first"),
    "the barrier's gradient": ("barrier_information", "[H_step, -per_upper,", "[H_step, per_upper,", "direction of x"),
    "noise leaves what is shared": ("process_noise", 'add: ["j[1:]", -j_taken]', 'add: ["j[1:]", j_taken]',
        "direction of x"),
    "noise of V_g": ("ground_speed_end", "add: [phi_j, I_o]", "add: [phi_j, -I_o]", "direction of x"),
    "V_g between the ends": ("ground_speed", "{mul: [coupled_first, share_last]}", "{mul: [-coupled_first, share_last]}",
        "direction of x"),
    "the factors of the middle": ("solve_3x3_symmetric", "{add: [c2_per_d2, -l_32_x3]}", "{add: [c2_per_d2, l_32_x3]}",
        "direction of x"),
    "kappa falls late": ("lean_step3", "floor((index + 1)/n_QP)", "floor(index/n_QP)", "direction of x"),
    "2^-3 for 2^-2": ("step_length", "1, 2^-1, 2^-2,", "1, 2^-1, 2^-3,", "frames with another choice"),
    "the last step whole": ("lean_step3", "{mul: [last.s, last.direction]}", "{mul: [1, last.direction]}", "x"),
}  # fmt: skip


@pytest.mark.parametrize("defect", [None, *DEFECTS])
def test_a_planted_defect_is_found_and_located(tmp_path: Path, defect: str | None) -> None:
    shutil.copytree(LEAN, tmp_path, dirs_exist_ok=True)
    if defect is not None:
        name, old, new, _ = DEFECTS[defect]
        path = tmp_path / f"{name}.yaml"
        text = path.read_text(encoding="utf-8")
        assert text.count(old) == 1
        path.write_text(text.replace(old, new), encoding="utf-8")
    case = replace(cmhe_fte_lean, scenarios=lambda frames, seed: short_runs(), closed_loop=None)
    report = verify(saoflow.load(str(tmp_path / "cmhe_fte_lean.yaml")), case)
    assert report.passed is (defect is None), report.summary
    if defect is not None:
        assert report.failures[0].quantity == DEFECTS[defect][3], report.summary


# -- what each change saves


@pytest.mark.parametrize("variant", [VARIANTS[2], VARIANTS[5], VARIANTS[6]], ids=lambda variant: variant.changes[-1])
def test_the_variants_take_the_same_step(variant: Variant) -> None:
    """Those that hold every change between them."""
    inputs = {port: values[:75] for port, values in RUNS["lost both, and gaps"]().items()}
    expected = reference.run(inputs)
    with loaded(variant) as sheet:
        found = sheet.simulator(exact=True).run(inputs)
    for port, values in expected.items():
        np.testing.assert_allclose(np.asarray(found[port], dtype=float), values, rtol=1e-10, atol=1e-10, err_msg=port)


def test_every_change_is_used_and_saves() -> None:
    folders = {path.name for path in REPLACED.iterdir() if path.is_dir()}
    assert folders == {change for variant in VARIANTS for change in variant.changes}
    frames = [cost.frame for cost in costs()]
    assert frames == sorted(frames, reverse=True)
    assert len(set(frames)) == len(frames)


@cache
def costs() -> tuple[lean_table.Cost, ...]:
    return tuple(lean_table.cost(variant) for variant in VARIANTS)


def test_the_document_shows_the_table_that_the_command_prints() -> None:
    """If this fails after a change of a sheet: python -m verification.results.lean_table -o docs/lean.md"""
    assert lean_table.table(costs()) in DOCUMENT.read_text(encoding="utf-8")


def test_the_command_replaces_the_table_and_nothing_else(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(lean_table, "VARIANTS", VARIANTS[-1:])
    monkeypatch.setattr(lean_table, "cost", lambda variant: costs()[-1])
    document = tmp_path / "lean.md"
    document.write_text("before\n\n| a | b |\n|---|---|\n| 1 | 2 |\n\nafter\n", encoding="utf-8")
    assert lean_table.main(["-o", str(document)]) == 0
    assert document.read_text(encoding="utf-8") == f"before\n\n{lean_table.table(costs()[-1:])}\nafter\n"
    assert lean_table.main([]) == 0
    assert capsys.readouterr().out == lean_table.table(costs()[-1:])
    assert lean_table.main(["-o", str(tmp_path / "missing.md")]) == 2
    (tmp_path / "bare.md").write_text("no table\n", encoding="utf-8")
    assert lean_table.main(["-o", str(tmp_path / "bare.md")]) == 2
    assert sorted(path.name for path in tmp_path.iterdir()) == ["bare.md", "lean.md"]
