"""The JSBSim recorder: determinism, silence, plans, refusals. The physics is in test_recordings_physics."""

import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest

from saoflow import DiagnosisError
from verification.flights import COLUMNS, FLIGHTS, SHIPPED, FlightPlan, find_flight, load_recording
from verification.flights.plan import (
    AltitudeChange,
    PitchDoublet,
    SpeedChange,
    SteadyWind,
    Turbulence,
    VerticalGust,
    WindRamp,
    soft_ramp,
)
from verification.flights.record import pressure_altitude, record
from verification.recordings.recording import to_csv

pytest.importorskip("jsbsim")
ROUGH = FlightPlan(
    "rough", "A320", 280.0, 10000.0, 6.0, wind=(SteadyWind(wx_kt=20.0), Turbulence(severity=4)), seed=4
)


def test_the_same_plan_gives_the_same_bytes_and_another_seed_others():
    first, again = record(ROUGH), record(ROUGH)
    assert to_csv(first) == to_csv(again)
    assert all(a.tobytes() == b.tobytes() for a, b in zip(first.columns, again.columns, strict=True))
    other = record(replace(ROUGH, seed=5))
    assert np.abs(other["wx_true"] - first["wx_true"]).max() > 1.0


@pytest.mark.parametrize("name", ["a320_calm_350kt_5000ft", "a320_turbulence_280kt_20000ft"])
def test_shipped_recordings_are_what_the_recorder_makes(name):
    plan = find_flight(name)
    fresh, shipped = record(plan), load_recording(name)
    assert fresh.names == shipped.names == tuple(column for column, _, _ in COLUMNS)
    assert len(fresh) == len(shipped) == round(plan.duration_s / 0.048) + 1
    for column in fresh.names:  # 9 digits, and another machine's last bits
        scale = max(1.0, float(np.abs(fresh[column]).max()))
        assert np.abs(fresh[column] - shipped[column]).max() < 1e-6 * scale, column


def test_nothing_is_printed():
    code = (
        "from verification.flights import FlightPlan, record;"
        "print(len(record(FlightPlan('short', '787-8', 300.0, 20000.0, 1.0))))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert (done.stdout, done.stderr) == ("22\n", "")


def test_progress_ends_at_one():
    seen = []
    record(replace(ROUGH, duration_s=1.0), seen.append)
    assert seen == sorted(seen)
    assert seen[-1] == 1.0
    assert len(seen) > 5


def test_commands_are_flown():
    plan = FlightPlan(
        "commands", "A320", 280.0, 12000.0, 70.0,
        (PitchDoublet(3.0, 2.0, 6.0), AltitudeChange(15.0, 400.0, 1200.0), SpeedChange(15.0, -15.0, 1.0)),
    )  # fmt: skip
    r = record(plan)
    assert np.degrees(np.ptp(r["theta"][:250])) > 1.5
    assert (r["z"][-1] - r["z"][0]) / 0.3048 == pytest.approx(400.0, rel=0.05)
    assert r["vc_true"][-1] == pytest.approx(265.0, abs=2.0)


def test_wind_is_what_was_asked_for():
    gust, ramp = VerticalGust(2.0, -12.0, 2.0, 2.0), WindRamp("x", 3.0, 20.0, 5.0)
    r = record(FlightPlan("wind", "787-8", 300.0, 15000.0, 12.0, wind=(SteadyWind(-10.0), gust, ramp)))
    assert r["wx_true"][0] == pytest.approx(-10.0, abs=0.01)
    assert r["wx_true"][-1] == pytest.approx(10.0, abs=0.01)
    assert r["wz_true"].min() == pytest.approx(-12.0, abs=0.01)
    assert np.diff(r["wx_true"]).max() / 0.048 == pytest.approx(5.0, rel=1e-3)
    assert np.abs(r["wz_true"][-1]) < 0.01


def test_soft_ramps_reach_their_change_and_never_exceed_their_rate():
    t = np.arange(0.0, 60.0, 0.01)
    for change, rate, corner in ((40.0, 5.0, 1.0), (-30.0, 7.0, 2.0), (2.0, 10.0, 3.0)):
        ramp = np.array([soft_ramp(x, 5.0, change, rate, corner) for x in t])
        assert ramp[0] == 0.0
        assert ramp[-1] == pytest.approx(change)
        slope = np.diff(ramp) / 0.01
        assert np.abs(slope).max() <= rate * (1 + 1e-9)
        assert np.abs(np.diff(slope)).max() / 0.01 <= np.pi / 2 * rate / corner * 1.01  # no kink


def test_pressure_altitude_is_that_of_the_standard_atmosphere():
    for z, pascal in ((0.0, 101325.0), (5000.0, 54019.9), (11000.0, 22632.1), (15000.0, 12044.6)):
        assert pressure_altitude(pascal / 47.88025898) == pytest.approx(z, abs=0.5)


def test_catalogue_names_are_unique_and_known():
    names = [plan.name for plan in FLIGHTS]
    assert len(set(names)) == len(names)
    assert all(find_flight(name).name == name for name in names)
    assert find_flight(names[0], "787-8", 9) == replace(SHIPPED[0], aircraft="787-8", seed=9)


@pytest.mark.parametrize(
    ("make", "code", "words"),
    [
        (lambda: find_flight("a320_calm_350"), "E701", "did you mean `a320_calm_350kt_5000ft`?"),
        (lambda: replace(ROUGH, aircraft="a320"), "E702", "did you mean `A320`?"),
        (lambda: replace(ROUGH, aircraft="737"), "E702", "known are A320, 787-8"),
        (lambda: replace(ROUGH, cas_kt=20.0), "E705", "cas_kt = 20.0"),
        (lambda: replace(ROUGH, altitude_ft=float("nan")), "E705", "altitude_ft = nan"),
        (lambda: replace(ROUGH, duration_s=0.0), "E705", "duration_s"),
        (lambda: replace(ROUGH, seed=-1), "E705", "0 to 2147483647"),
        (lambda: replace(ROUGH, wind=(WindRamp("y", 1.0, 1.0, 1.0),)), "E705", "the axes are x"),
        (lambda: WindRamp("x", 1.0, 1.0, 0.0), "E705", "WindRamp: rate_kt_s = 0"),
        (lambda: WindRamp("x", 1.0, 1.0, 1.0, 0.0), "E705", "WindRamp: corner_s = 0"),
        (lambda: PitchDoublet(1.0, float("inf")), "E705", "PitchDoublet: amplitude_deg = inf"),
        (lambda: PitchDoublet(1.0, 1.0, 0.0), "E705", "PitchDoublet: period_s = 0"),
        (lambda: AltitudeChange(1.0, 1.0, 0.0), "E705", "AltitudeChange: rate_fpm = 0"),
        (lambda: SpeedChange(1.0, 1.0, 0.0), "E705", "SpeedChange: rate_kt_s = 0"),
        (lambda: VerticalGust(1.0, 5.0, -1.0), "E705", "VerticalGust: rise_s = -1"),
        (lambda: record(replace(ROUGH, wind=(WindRamp("x", 0.5, 600.0, 300.0),))), "E704", "out of hand"),
        (lambda: replace(ROUGH, wind=(Turbulence(severity=8),)), "E705", "1 to 7"),
        (lambda: record(replace(ROUGH, cas_kt=165.0, altitude_ft=41000.0)), "E704", "can hold"),
    ],
)
def test_nonsense_is_refused_with_code_and_reason(make, code, words):
    with pytest.raises(DiagnosisError) as caught:
        make()
    assert caught.value.diagnoses[0].code == code
    assert words in str(caught.value)


def test_without_jsbsim_the_remedy_is_the_extra(monkeypatch):
    monkeypatch.setitem(sys.modules, "jsbsim", None)
    with pytest.raises(DiagnosisError) as caught:
        record(ROUGH)
    assert caught.value.diagnoses[0].code == "E703"
    assert "pip install 'saoflow[flights]'" in str(caught.value)


def test_another_jsbsim_is_refused(monkeypatch):
    import jsbsim

    monkeypatch.setattr(jsbsim, "__version__", "1.1.0")
    with pytest.raises(DiagnosisError, match=r"needs jsbsim 1\.3\.3"):
        record(ROUGH)


def test_away_from_the_standard_temperature_formula_16_errs_by_several_knots():
    """The paper's (16) takes the standard temperature; the recordings' README gives this number."""
    r = record(replace(find_flight("a320_hot_280kt_20000ft"), duration_s=2.0))
    temperature = 288.15 - 0.0065 * r["z"]
    height = 6096.0 * 6356766.0 / (6356766.0 + 6096.0)  # 20 000 ft as geopotential height, m
    assert r["temperature_true"] == pytest.approx(288.15 - 0.0065 * height + 15.0, abs=0.05)
    pressure = (temperature / 288.15) ** (9.80665 / (0.0065 * 287.05287))
    dynamic = ((1 + (r["vt_true"] * 1852 / 3600) ** 2 / (7.0 * 287.05287 * temperature)) ** 3.5 - 1) * pressure
    vc = np.sqrt(7.0 * 287.05287 * 288.15 * ((dynamic + 1) ** (1 / 3.5) - 1)) * 3600 / 1852
    assert vc - r["vc_true"] == pytest.approx(7.5, abs=0.1)
