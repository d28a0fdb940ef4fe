"""The estimators on flights: alarms, the paper's Fig. 4, start-up, missing samples, garbage."""

from __future__ import annotations

from dataclasses import fields, replace

import numpy as np
import pytest
from reference_cases import CALM, TUNING, VC_RUNAWAY, WINDY, flight, synthetic

from verification.flights import Fault, load_recording, sensors
from verification.reference import cmhe_fte, ekf_fte, umhe_fte
from verification.reference.arrays import DEGREE
from verification.reference.inputs import INERTIAL, RecordingError, frames

FIG_4 = Fault("runaway", "vc", rate=-15.0, onset=5.0)
OUTPUT_BOUNDS = {
    "alpha_hat": (-15 * DEGREE, 30 * DEGREE),
    "alpha_pred": (-15 * DEGREE, 30 * DEGREE),
    "vc_hat": (0.0, 800.0),
    "vc_pred": (0.0, 800.0),
    "wx_hat": (-60.0, 60.0),
    "wz_hat": (-30.0, 30.0),
    "alpha_rms": (0.0, np.pi),
    "vc_rms": (0.0, 1000.0),
    "alpha_faulty": (0, 1),
    "vc_faulty": (0, 1),
    "configuration": (1, 4),
}


def assert_finite_and_bounded(outputs, wind=None):
    for name, (low, high) in OUTPUT_BOUNDS.items():
        if wind is not None and name in ("wx_hat", "wz_hat"):
            low, high = -wind, wind
        assert np.isfinite(outputs[name]).all(), name
        assert (low <= outputs[name]).all(), name
        assert (outputs[name] <= high).all(), name


def alarms(outputs):
    return int(outputs["alpha_faulty"][-1].sum() + outputs["vc_faulty"][-1].sum())


# Fault-free flight


@pytest.mark.parametrize(
    ("name", "start", "seconds"),
    [
        (CALM, 14.0, 6.0),
        (WINDY, 44.0, 10.0),
        (WINDY, 67.0, 10.0),
        ("787_ramps_300kt_15000ft", 55.0, 8.0),
        ("787_ramps_300kt_15000ft", 91.0, 9.0),
        ("a320_slow_190kt_3000ft", 34.0, 8.0),
        ("a320_turbulence_280kt_20000ft", 23.0, 8.0),
        ("a320_turbulence_280kt_20000ft", 39.0, 7.0),
        ("787_shear_280kt_33000ft", 31.0, 6.0),
    ],
)
def test_no_false_alarm_and_small_errors_in_fault_free_flight(name, start, seconds):
    """The parts of the shipped recordings with the largest residuals, each with a start-up in its wind."""
    recording = load_recording(name).part(start, start + seconds)
    outputs = cmhe_fte.run(sensors(recording, seed=7).inputs())
    assert alarms(outputs) == 0
    settled = slice(60, None)
    assert outputs["alpha_rms"][settled].max() < 0.75 * TUNING.alpha_threshold * DEGREE
    assert outputs["vc_rms"][settled].max() < 0.75 * TUNING.vc_threshold
    assert np.abs(outputs["alpha_hat"] - recording["alpha_true"])[settled].max() < 1.2 * DEGREE
    assert np.abs(outputs["vc_hat"] - recording["vc_true"])[settled].max() < 5.0
    assert_finite_and_bounded(outputs)


def test_vertical_wind_ramps_at_the_assumed_rate_raise_no_alarm_with_this_p_and_q_alpha():
    """What set p_alpha and q_alpha: with a tenth, and a twentieth, of them all three healthy AOA are condemned."""
    pytest.importorskip("jsbsim")
    from verification.flights import FlightPlan, record
    from verification.flights.plan import SteadyWind, WindRamp

    wind = (SteadyWind(wz_kt=-28.0), WindRamp("z", 6.0, 56.0, 14.5, 0.3))
    recording = record(FlightPlan("ramp", "A320", 190.0, 3000.0, 13.0, wind=wind))
    assert np.abs(np.diff(recording["wz_true"])).max() / TUNING.t_s > 14.0
    inputs = sensors(recording, seed=0).inputs()
    assert alarms(cmhe_fte.run(inputs)) == 0
    tight = replace(TUNING, p_alpha=1e-7, q_alpha=1e-5)
    assert cmhe_fte.run(inputs, tight)["alpha_faulty"][-1].sum() == 3


# Fig. 4


def test_fig_4_cmhe_detects_within_6_s_and_umhe_not_within_370_frames():
    onset = round(5.0 / TUNING.t_s)
    inputs = flight(CALM, seconds=5.0 + 371 * TUNING.t_s, faults=(FIG_4,))
    constrained, free = cmhe_fte.run(inputs), umhe_fte.run(inputs)
    delays = np.argmax(constrained["vc_faulty"], axis=0) - onset
    assert (constrained["vc_faulty"][-1] == 1.0).all()
    assert (delays > 0).all()
    assert (delays * TUNING.t_s < 6.0).all()
    assert constrained["configuration"][-1] == 3
    assert (free["vc_faulty"][: onset + 371] == 0.0).all()
    assert free["wx_hat"][-1] > 150.0  # UMHE's wind takes in the fault
    assert constrained["wx_hat"].max() <= 60.0
    assert alarms({k: v[:, None] if v.ndim == 1 else v for k, v in free.items()}) == 0
    truth = load_recording(CALM)["alpha_true"][: len(constrained["alpha_hat"])]
    assert np.abs(constrained["alpha_hat"] - truth)[60:].max() < 0.6 * DEGREE


@pytest.mark.parametrize("which", [(1,), (1, 3)])
def test_fewer_faulty_sensors_are_isolated_and_the_estimates_kept(which):
    fault = Fault("runaway", "vc", which=which, rate=-15.0, onset=4.0)
    inputs = flight(CALM, seconds=10.0, faults=(fault,))
    outputs = cmhe_fte.run(inputs)
    assert [i + 1 for i in range(3) if outputs["vc_faulty"][-1, i]] == list(which)
    assert outputs["configuration"][-1] == 1
    truth = load_recording(CALM)["vc_true"][: len(outputs["vc_hat"])]
    assert np.abs(outputs["vc_hat"] - truth)[-40:].max() < 3.0


# Missing samples


def with_gap(inputs, gaps):
    """Return a copy of the inputs where gaps {(name, sensors or None): (first frame, frames, value)} apply."""
    broken = {name: np.array(column) for name, column in inputs.items()}
    for (name, which), (first, count, value) in gaps.items():
        if which is None:
            broken[name][first : first + count] = value
        else:
            broken[name][first : first + count, which] = value
    return broken


@pytest.mark.parametrize("method", [cmhe_fte, umhe_fte, ekf_fte])
@pytest.mark.parametrize("seed", range(4))
def test_after_ten_missing_frames_the_run_is_back_in_5_s(method, seed):
    generator = np.random.default_rng(seed)
    inputs = flight(WINDY, seconds=9.5, start=float(5 + 18 * seed))
    missing, first = 10, int(generator.integers(60, 75))
    value = (np.nan, np.inf, -np.inf, 1e300)[seed]
    chosen = INERTIAL if seed == 0 else [n for n in INERTIAL if generator.random() < 0.5] or ["q"]
    gaps = {(name, None): (first, missing, value) for name in chosen}
    gaps |= {("alpha", i): (first, TUNING.n_detect - 1, value) for i in range(3)}
    gaps |= {("vc", i): (first, TUNING.n_detect - 1, value) for i in range(seed)}
    undisturbed, outputs = method.run(inputs), method.run(with_gap(inputs, gaps))
    assert alarms(outputs) == 0
    assert_finite_and_bounded(outputs, wind=None if method is cmhe_fte else 500.0)
    later = slice(first + missing + round(5.0 / TUNING.t_s), None)
    assert len(outputs["alpha_hat"][later]) > 5
    assert np.abs(outputs["alpha_hat"] - undisturbed["alpha_hat"])[later].max() < 0.1 * DEGREE
    assert np.abs(outputs["vc_hat"] - undisturbed["vc_hat"])[later].max() < 1.0


@pytest.mark.parametrize(
    ("missing", "first", "frames"),
    [
        (INERTIAL, 0, 30),
        (INERTIAL, 70, 200),
        (("q",), 40, 200),
        (("theta", "az"), 90, 100),
        (("vg", "vz"), 10, 150),
    ],
)
def test_missing_inertial_inputs_condemn_no_healthy_sensor(missing, first, frames):
    inputs = flight(WINDY, seconds=(first + frames + 120) * TUNING.t_s, start=24.0)
    outputs = cmhe_fte.run(with_gap(inputs, {(name, None): (first, frames, np.nan) for name in missing}))
    assert (outputs["alpha_faulty"] == 0.0).all()
    assert (outputs["vc_faulty"] == 0.0).all()
    assert_finite_and_bounded(outputs)


def test_an_air_data_sensor_missing_for_n_d_frames_is_faulty_and_not_before():
    inputs = flight(CALM, seconds=5.0)
    for missing, faulty in ((TUNING.n_detect - 1, 0), (TUNING.n_detect, 1)):
        outputs = cmhe_fte.run(with_gap(inputs, {("alpha", 1): (70, missing, np.nan)}))
        assert outputs["alpha_faulty"][-1].tolist() == [0, faulty, 0]
        assert outputs["vc_faulty"][-1].sum() == 0


@pytest.mark.parametrize("method", [cmhe_fte, umhe_fte, ekf_fte])
def test_outputs_are_finite_and_bounded_whatever_the_inputs(method):
    generator = np.random.default_rng(11)
    n = 400
    nominal = synthetic(n)
    inputs = {}
    for name, column in nominal.items():
        scale = np.abs(column).max() + 1.0
        wild = generator.standard_cauchy(column.shape) * scale
        odd = generator.choice([np.nan, np.inf, -np.inf, 1e308, -1e308, 5e-324, 0.0], column.shape)
        kind = generator.integers(0, 3, column.shape)
        inputs[name] = np.choose(kind, [column, wild, odd])
    outputs = method.run(inputs)
    assert_finite_and_bounded(outputs, wind=None if method is cmhe_fte else 500.0)


@pytest.mark.parametrize("method", [cmhe_fte, umhe_fte, ekf_fte])
def test_nothing_but_missing_samples_gives_finite_outputs(method):
    inputs = {name: np.full_like(column, np.nan) for name, column in synthetic(60).items()}
    outputs = method.run(inputs)
    assert_finite_and_bounded(outputs, wind=None if method is cmhe_fte else 500.0)
    assert outputs["configuration"][-1] == 4


def test_a_flight_without_any_alpha_starts_in_configuration_II():
    inputs = synthetic(200, w_x_kt=15.0)
    inputs["alpha"][:] = np.nan
    outputs = cmhe_fte.run(inputs)
    assert outputs["configuration"][-1] == 2
    assert outputs["alpha_hat"][-1] == pytest.approx(3.0 * DEGREE, abs=0.3 * DEGREE)
    assert outputs["wx_hat"][-1] == pytest.approx(15.0, abs=0.5)
    assert outputs["vc_hat"][-1] == pytest.approx(inputs["vc"][0, 0], abs=0.5)


def test_decisions_are_inhibited_for_exactly_n_inhibit_frames_after_a_gap():
    inputs = with_gap(flight(CALM, seconds=9.0), {("q", None): (80, 3, np.nan)})
    state, inhibited = cmhe_fte.initial_state(TUNING), []
    for frame in frames(inputs):
        done = cmhe_fte.step(state, frame, TUNING)
        state = done.state
        inhibited.append(done.trace.start_up.inhibit)
    expected = np.zeros(len(inhibited), dtype=bool)
    expected[:50] = True
    expected[80 : 83 + 50] = True
    assert inhibited == expected.tolist()


# The interface


def test_a_step_changes_nothing_it_was_given_and_repeats_to_the_bit():
    inputs = flight(CALM, seconds=4.0, faults=(VC_RUNAWAY,))
    state = cmhe_fte.initial_state(TUNING)
    for frame in frames(inputs):
        before = {name: np.copy(value) for name, value in vars(state).items()}
        done, again = cmhe_fte.step(state, frame, TUNING), cmhe_fte.step(state, frame, TUNING)
        for name, value in before.items():
            np.testing.assert_array_equal(getattr(state, name), value)
        for name, value in vars(done.state).items():
            np.testing.assert_array_equal(getattr(again.state, name), value)
        state = done.state


def test_a_recording_that_cannot_be_run_is_named():
    inputs = synthetic(3)
    with pytest.raises(RecordingError, match=r"input 'theta' is missing.*did you mean 'thta'"):
        cmhe_fte.run({("thta" if k == "theta" else k): v for k, v in inputs.items()})
    with pytest.raises(RecordingError, match=r"'alpha' has shape \(3, 2\), expected \(n, 3\)"):
        cmhe_fte.run(inputs | {"alpha": np.zeros((3, 2))})
    with pytest.raises(RecordingError, match="differ in length"):
        cmhe_fte.run(inputs | {"q": np.zeros(4)})
    with pytest.raises(RecordingError, match="'q' is not an array of numbers"):
        cmhe_fte.run(inputs | {"q": ["a", "b", "c"]})


def test_every_parameter_has_a_unit_and_a_source():
    for field in fields(TUNING):
        assert field.metadata["unit"]
        assert len(field.metadata["source"]) > 10
