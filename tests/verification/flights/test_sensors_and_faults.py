"""Sensor noise, faults (paper 004, Table II) and missing samples, each against its definition."""

import math

import numpy as np
import pytest

from saoflow import DiagnosisError
from verification.flights import (
    KINDS,
    NO_NOISE,
    TABLE_I,
    TABLE_II,
    Fault,
    Missing,
    Noise,
    load_recording,
    random_fault,
    sensors,
    table_ii_levels,
)

TS = 0.048
FIRST = 417  # the first frame at or after 20 s
TRUTH = load_recording("a320_wind_350kt_5000ft")
S = np.arange(len(TRUTH) - FIRST) * TS + (FIRST * TS - 20.0)


def faulty(fault, seed=3, noise=NO_NOISE):
    """The three readings (n, 3) with the fault and without."""
    with_fault = sensors(TRUTH, seed, noise, [fault]).inputs()[fault.sensor]
    return with_fault, sensors(TRUTH, seed, noise).inputs()[fault.sensor]


def test_inputs_have_the_flagships_shapes_and_no_noise_means_the_truth():
    inputs = sensors(TRUTH, 1, NO_NOISE).inputs()
    assert set(inputs) == {"alpha", "vc", "vg", "vz", "theta", "q", "ax", "az", "z"}
    assert inputs["alpha"].shape == inputs["vc"].shape == (len(TRUTH), 3)
    for i in range(3):
        assert (inputs["alpha"][:, i] == TRUTH["alpha_true"]).all()
        assert (inputs["vc"][:, i] == TRUTH["vc_true"]).all()
    for name in ("vg", "vz", "theta", "q", "ax", "az", "z"):
        assert (inputs[name] == TRUTH[name]).all()


def test_noise_has_the_standard_deviations_of_table_i():
    """Paper 003, Table I; the sample deviation of n values lies within 4 / sqrt(2 n) of it."""
    inputs = sensors(TRUTH, 7).inputs()
    printed = {"ax": 0.3215, "az": 0.3215, "q": 0.0140, "vz": 0.5832, "theta": 0.0017, "vc": 0.7775}
    assumed = {"alpha": math.radians(0.2), "vg": 0.2 * 3600 / 1852, "z": 1.0}
    for name, sigma in (printed | assumed).items():
        truth = TRUTH[f"{name}_true"] if name in ("alpha", "vc") else TRUTH[name]
        noise = (inputs[name].T - truth).T
        assert noise.std() / sigma == pytest.approx(1.0, abs=4 / math.sqrt(2 * noise.size)), name
        assert abs(noise.mean()) < 4 * sigma / math.sqrt(noise.size), name


def test_streams_are_independent_and_follow_the_seed():
    first, again, other = (sensors(TRUTH, seed) for seed in (1, 1, 2))
    noise = []
    for name in ("vg", "vz", "q", "ax", "alpha_1", "alpha_2", "alpha_3", "vc_1", "vc_2", "vc_3"):
        assert first[name].tobytes() == again[name].tobytes()
        assert (first[name] != other[name]).mean() > 0.9
        truth = {"a": "alpha_true", "v": "vc_true"}[name[0]] if name[-1].isdigit() else name
        noise.append(first[name] - TRUTH[truth])
    correlation = np.corrcoef(noise) - np.eye(len(noise))
    assert np.abs(correlation).max() < 5 / math.sqrt(len(TRUTH))


def test_truth_columns_stay():
    read = sensors(TRUTH, 1)
    for name in ("t", "alpha_true", "vc_true", "wx_true"):
        assert (read[name] == TRUTH[name]).all()


@pytest.mark.parametrize("noise", [NO_NOISE, TABLE_I])
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("sensor", ["alpha", "vc"])
def test_a_fault_touches_its_sensors_after_its_onset_and_nothing_else(kind, sensor, noise):
    fault = random_fault(5, kind, sensor, which=(1, 3))
    with_fault = sensors(TRUTH, 3, noise, [fault])
    without = sensors(TRUTH, 3, noise)
    for name in without.names:
        changed = with_fault[name] != without[name]
        if name in (f"{sensor}_1", f"{sensor}_3"):
            assert not changed[:FIRST].any()
            assert changed[FIRST + 1 :].mean() > 0.9
        else:
            assert not changed.any()


def test_bias():
    got, healthy = faulty(Fault("bias", "alpha", amplitude=-2.5), noise=TABLE_I)
    np.testing.assert_allclose(got[FIRST:] - healthy[FIRST:], np.radians(-2.5), atol=1e-15)


def test_runaway():
    got, healthy = faulty(Fault("runaway", "vc", rate=-15.0))
    np.testing.assert_allclose((got - healthy)[FIRST:], np.outer(-15.0 * S, [1, 1, 1]), atol=1e-9)
    got, healthy = faulty(Fault("runaway", "alpha", rate=0.2))
    np.testing.assert_allclose((got - healthy)[FIRST:, 0], np.radians(0.2 * S), atol=1e-12)


def test_oscillation():
    got, healthy = faulty(Fault("oscillation", "vc", amplitude=30.0, frequency=0.5))
    added = (got - healthy)[FIRST:, 1]
    assert np.abs(added).max() == pytest.approx(30.0, rel=1e-2)
    crossings = np.flatnonzero(np.diff(np.sign(added)) != 0)
    assert np.diff(crossings).mean() * TS == pytest.approx(1.0, rel=0.02)  # half a period of 0.5 Hz
    np.testing.assert_allclose(added, 30.0 * np.sin(np.pi * S), atol=1e-9)


def test_jamming_freezes_at_the_reading_of_the_onset_plus_amplitude():
    got, healthy = faulty(Fault("jamming", "alpha", which=(2,), amplitude=5.0), noise=TABLE_I)
    assert (got[FIRST:, 1] == healthy[FIRST, 1] + 5.0 * math.pi / 180).all()
    got, healthy = faulty(Fault("jamming", "vc", amplitude=0.0))
    assert (got[FIRST:] == healthy[FIRST]).all()


def test_non_return_to_zero_is_a_tenth_of_the_value_unless_said_otherwise():
    got, healthy = faulty(Fault("non_return_to_zero", "vc"), noise=TABLE_I)
    np.testing.assert_allclose(got[FIRST:], 0.1 * healthy[FIRST:], rtol=1e-15)
    got, healthy = faulty(Fault("non_return_to_zero", "vc", amplitude=1.1))
    np.testing.assert_allclose(got[FIRST:], 1.1 * healthy[FIRST:], rtol=1e-15)


def test_noise_fault_adds_its_standard_deviation_and_differs_between_sensors():
    got, healthy = faulty(Fault("noise", "vc", amplitude=15.0))
    added = (got - healthy)[FIRST:]
    assert added.std() == pytest.approx(15.0, rel=4 / math.sqrt(2 * added.size))
    assert np.abs(np.corrcoef(added.T) - np.eye(3)).max() < 0.15


def test_onset_is_the_first_frame_at_or_after_it():
    for onset, frame in ((0.0, 0), (TS, 1), (0.05, 2), (100 * TS, 100)):
        assert Fault("bias", "vc", amplitude=10.0, onset=onset).onset_frame(TS) == frame


def test_faults_add_up_in_order():
    bias, stuck = Fault("bias", "vc", amplitude=10.0), Fault("jamming", "vc", amplitude=0.0, onset=30.0)
    got = sensors(TRUTH, 1, NO_NOISE, [bias, stuck])["vc_1"]
    assert (got[625:] == TRUTH["vc_true"][625] + 10.0).all()


def test_table_ii_levels_are_its_ends_and_their_geometric_mean():
    low, middle, high = table_ii_levels("oscillation", "vc")
    assert (low.amplitude, low.frequency) == (10.0, 0.5)
    assert middle.amplitude == pytest.approx(math.sqrt(10.0 * 200.0))
    assert (high.amplitude, high.frequency) == (pytest.approx(200.0), pytest.approx(4.0))


def test_random_faults_lie_in_table_ii_and_follow_the_seed():
    for kind, sensor, field, lowest, highest in TABLE_II:
        drawn = [getattr(random_fault(seed, kind, sensor), field) for seed in range(40)]
        assert all(lowest * 0.999999 <= abs(value) <= highest * 1.000001 for value in drawn)
        if highest > lowest:
            assert max(map(abs, drawn)) > (lowest * highest) ** 0.5 > min(map(abs, drawn))
        assert random_fault(3, kind, sensor) == random_fault(3, kind, sensor)
    assert {math.copysign(1, random_fault(s, "bias", "vc").amplitude) for s in range(20)} == {1.0, -1.0}


def test_missing_samples():
    gaps = [
        Missing(("vg", "alpha"), onset=10.0, frames=4),
        Missing(("vc_2",), onset=10.0, frames=2, value="-inf"),
    ]
    read, whole = sensors(TRUTH, 1, missing=gaps), sensors(TRUTH, 1)
    first = 209  # 10 s is frame 208.33
    for name in whole.names:
        changed = ~((read[name] == whole[name]) | (np.isnan(read[name]) & np.isnan(whole[name])))
        where = np.flatnonzero(changed).tolist()
        if name in ("vg", "alpha_1", "alpha_2", "alpha_3"):
            assert where == list(range(first, first + 4))
            assert np.isnan(read[name][where]).all()
        elif name == "vc_2":
            assert where == [first, first + 1]
            assert (read[name][where] == -math.inf).all()
        else:
            assert where == []


@pytest.mark.parametrize(
    ("make", "code", "words"),
    [
        (lambda: Fault("runnaway", "vc", rate=1.0), "E711", "did you mean `runaway`?"),
        (lambda: Fault("bias", "vcc", amplitude=1.0), "E711", "did you mean `vc`?"),
        (lambda: Fault("bias", "vc"), "E711", "bias without amplitude"),
        (lambda: Fault("bias", "vc", amplitude=1.0, rate=1.0), "E711", "bias with rate"),
        (lambda: Fault("runaway", "vc", amplitude=1.0), "E711", "takes rate"),
        (lambda: Fault("oscillation", "vc", amplitude=1.0), "E711", "oscillation without frequency"),
        (lambda: Fault("oscillation", "vc", amplitude=1.0, frequency=0.0), "E711", "above 0 Hz"),
        (lambda: Fault("bias", "vc", amplitude=math.nan), "E711", "must be finite"),
        (lambda: Fault("bias", "vc", (), amplitude=1.0), "E711", "at least one"),
        (lambda: Fault("bias", "vc", (1, 1), amplitude=1.0), "E711", "each once"),
        (lambda: Fault("bias", "vc", (0,), amplitude=1.0), "E711", "numbered 1, 2, 3"),
        (lambda: Fault("bias", "vc", amplitude=1.0, onset=-1.0), "E711", "0 s or later"),
        (lambda: Fault("noise", "vc", amplitude=-1.0), "E711", "not negative"),
        (lambda: sensors(TRUTH, 1, faults=[Fault("bias", "vc", amplitude=1.0, onset=91.0)]), "E711", "ends at 90 s"),
        (lambda: sensors(TRUTH, -1), "E713", "from 0"),
        (lambda: Noise(q=-0.1), "E713", "0 or more"),
        (lambda: Noise(vc=math.inf), "E713", "vc = inf"),
        (lambda: Missing(("vh",), 1.0, 1), "E714", "no input `vh`"),
        (lambda: Missing((), 1.0, 1), "E714", "at least one"),
        (lambda: Missing(("vg",), 1.0, 0), "E714", "at least 1"),
        (lambda: Missing(("vg",), 1.0, 1, "none"), "E714", "nan, inf or -inf"),
        (lambda: sensors(TRUTH, 1, missing=[Missing(("vg",), 91.0, 1)]), "E714", "ends at 90 s"),
        (lambda: TRUTH.inputs(), "E722", "sensors(recording, seed=1)"),
        (lambda: TRUTH["alpha"], "E722", "no column `alpha`"),
        (lambda: load_recording("a320_calm"), "E721", "did you mean `a320_calm_350kt_5000ft`?"),
    ],
)
def test_nonsense_is_refused_with_code_and_reason(make, code, words):
    with pytest.raises(DiagnosisError) as caught:
        make()
    assert caught.value.diagnoses[0].code == code
    assert words in str(caught.value)
    assert str(caught.value).startswith(f"error[{code}]: ")
    assert caught.value.diagnoses[0].cause
    assert caught.value.diagnoses[0].remedy
