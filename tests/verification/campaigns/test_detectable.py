"""The rule of which faults must be found, against the sheet without noise and against calculations by hand."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

import saoflow
from verification.campaigns.detectable import FIRST_S, MARGIN, after, detectable
from verification.campaigns.explained import airspeed_window, alpha_window, followed
from verification.flights import NO_NOISE, Fault, load_recording, sensors
from verification.recordings import Recording
from verification.reference.arrays import DEGREE, KNOT
from verification.reference.tuning import Tuning

TUNING = Tuning()


@cache
def truth(name: str = "a320_calm_350kt_5000ft") -> Recording:
    return load_recording(name).part(0.0, 50.0)


def predicted_errors(fault: Fault, flight: Recording) -> np.ndarray:
    """What the rule says that all three sensors' residuals are, frame by frame from the start, deg or kt."""
    first = fault.onset_frame(flight.period)
    column = flight[f"{fault.sensor}_true"]
    signal = fault.apply(column, flight.period, np.random.default_rng(0)) - column
    v_g = flight["vg"][first] * KNOT
    if fault.sensor == "alpha":
        wind = flight["wz_true"] * KNOT
        drift = np.diff(wind, prepend=wind[0]) / v_g
        states = followed(alpha_window(v_g, TUNING), wind, np.column_stack([signal, -wind]), drift)
        return (signal - np.array([x[0] for x in states])) / DEGREE
    wind = flight["wx_true"] * KNOT
    v_t = np.linspace(0.98, 1.02, 2) * (flight["vt_true"][first] * KNOT)
    from verification.reference.air_data import calibrated_airspeed

    v_c = calibrated_airspeed(v_t, np.full(2, flight["z"][first]))[0]
    slope = float(np.diff(v_c)[0] / np.diff(v_t)[0])
    states = followed(airspeed_window(slope, TUNING), wind, (wind - signal * KNOT / slope)[:, None], np.zeros(len(wind)))
    return signal + slope * (np.array([x[0] for x in states]) - wind) / KNOT


@pytest.mark.parametrize("flight", ["a320_calm_350kt_5000ft", "a320_wind_350kt_5000ft"])
@pytest.mark.parametrize(
    "fault",
    [
        Fault("bias", "vc", amplitude=16.0, onset=15.0),
        Fault("runaway", "vc", rate=-12.0, onset=15.0),
        Fault("bias", "alpha", amplitude=3.5, onset=15.0),
        Fault("runaway", "alpha", rate=1.0, onset=15.0),
    ],
    ids=lambda fault: f"{fault.sensor}_{fault.kind}",
)
def test_the_rule_follows_as_the_sheet_does(fault: Fault, flight: str) -> None:
    """Three faulty sensors, no noise, no decisions: the linear window against the flagship, to 5 % of the threshold."""
    simulator = saoflow.load("cmhe_fte", parameters={"n_inhibit": 10_000}).simulator()
    recording = truth(flight).part(0.0, 24.0)
    out = simulator.run(sensors(recording, 1, NO_NOISE, [fault]).inputs())
    found = out["alpha_rms"][:, 0] / DEGREE if fault.sensor == "alpha" else out["vc_rms"][:, 0]
    squares = np.concatenate([np.zeros(TUNING.n_eval - 1), predicted_errors(fault, recording) ** 2])
    rms = np.sqrt(np.convolve(squares, np.ones(TUNING.n_eval), "valid") / TUNING.n_eval)
    threshold = TUNING.alpha_threshold if fault.sensor == "alpha" else TUNING.vc_threshold
    first = fault.onset_frame(recording.period)
    assert rms[first:].max() > 0.25 * threshold
    np.testing.assert_allclose(found[first:], rms[first:], rtol=0.03, atol=0.05 * threshold)


@pytest.mark.parametrize("which", [(1,), (2, 3), (1, 2, 3)])
def test_noise_is_its_own_rms(which: tuple[int, ...]) -> None:
    just = MARGIN * TUNING.vc_threshold
    assert detectable(Fault("noise", "vc", which, amplitude=just + 0.01, onset=10.0), truth(), TUNING)
    assert not detectable(Fault("noise", "vc", which, amplitude=just - 0.01, onset=10.0), truth(), TUNING)


def test_a_lone_bias_by_hand() -> None:
    """A third is let through and followed at last, so 2/3 stay; at first all of it counts."""
    for amplitude, must in ((12.5, False), (30.0, True)):
        assert detectable(Fault("bias", "vc", (2,), amplitude=amplitude, onset=10.0), truth(), TUNING) is must
    # Every frame after the first n_eval has 2/3 of it left, and the fourth rms is the first above the margin.
    found = after(Fault("bias", "vc", (2,), amplitude=200.0, onset=10.0), truth(), TUNING)
    assert found == pytest.approx((TUNING.n_detect - 1) * truth().period)


def test_three_runaways_meet_the_bound_of_the_wind() -> None:
    """At 5 kt/s the wind follows up to 60 kt of true airspeed, then the residual grows at 5 kt/s up to the margin."""
    found = after(Fault("runaway", "vc", rate=-5.0, onset=10.0), truth(), TUNING)
    v_c, v_t = truth()["vc_true"][210], truth()["vt_true"][210]
    assert found is not None
    least = (60.0 * v_c / v_t + MARGIN * TUNING.vc_threshold) / 5.0 - 0.6  # V_c/V_t is the slope within a few percent
    assert least < found < least + 1.5


def test_wind_that_is_there_uses_up_the_bound() -> None:
    """A tail wind of 50 kt leaves 10 kt before the bound for readings that fall, 110 kt for readings that rise."""
    calm = truth()
    blown = calm.with_columns({"wx_true": np.full(len(calm), 50.0), "vg": calm["vg"] + 50.0})
    falling = after(Fault("runaway", "vc", rate=-5.0, onset=10.0), blown, TUNING)
    rising = after(Fault("runaway", "vc", rate=5.0, onset=10.0), blown, TUNING)
    assert falling is not None and rising is not None
    slope = calm["vc_true"][210] / calm["vt_true"][210]
    assert rising - falling == pytest.approx(100.0 * slope / 5.0, rel=0.05)


def test_two_count_as_three() -> None:
    """Two that drift alike are the majority: no more is promised than for three."""
    fault = Fault("runaway", "vc", (1, 3), rate=3.0, onset=10.0)
    assert after(fault, truth(), TUNING) == after(replace(fault, which=(1, 2, 3)), truth(), TUNING)


def test_what_grows_later_is_counted_apart() -> None:
    """A jammed sensor is wrong by nothing at first; a change of airspeed of 40 kt makes it wrong by 40 kt."""
    calm = truth()
    change = 40.0 * np.clip((calm["t"] - 25.0) / 10.0, 0.0, 1.0)
    flight = calm.with_columns({"vc_true": calm["vc_true"] + change, "vg": calm["vg"] + change})
    jammed = Fault("jamming", "vc", (1,), amplitude=0.0, onset=10.0)
    assert not detectable(jammed, flight, TUNING)
    found = after(jammed, flight, TUNING)
    assert found is not None and 15.0 < found < 25.0
    assert found > FIRST_S


def test_a_fault_below_the_threshold_is_not_promised() -> None:
    for which in ((1,), (1, 2), (1, 2, 3)):
        assert not detectable(Fault("bias", "alpha", which, amplitude=2.8, onset=10.0), truth(), TUNING)
        assert detectable(Fault("bias", "alpha", which, amplitude=20.0, onset=10.0), truth(), TUNING)
