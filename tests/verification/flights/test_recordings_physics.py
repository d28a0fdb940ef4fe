"""The shipped recordings obey the equations that the estimator is built on, computed here from the truth
columns.

The trapezoid bounds (0.013 deg/s, 0.007 kt/s) leave room for JSBSim's round, turning Earth: its effective
gravity is below 9.80665 m/s^2 by up to 0.5 %.
"""

import numpy as np
import pytest

from verification.flights import SHIPPED, load_recording, shipped_recordings

TS = 0.048
KT = 1852.0 / 3600.0
G = 9.80665 / KT  # kt/s^2
NAMES = tuple(plan.name for plan in SHIPPED)
SMOOTH = tuple(name for name in NAMES if "turbulence" not in name)


def mean(values):
    return (values[1:] + values[:-1]) / 2


def test_every_planned_recording_is_shipped_and_no_other():
    assert shipped_recordings() == tuple(sorted(NAMES))


@pytest.mark.parametrize("name", NAMES)
def test_wind_triangle_closes_in_three_dimensions(name):
    """Inertial velocity = air velocity + wind, from body axes through bank and pitch to the level heading
    axes.
    """
    r = load_recording(name)
    alpha, beta, theta, phi, vt = (r[n] for n in ("alpha_true", "beta_true", "theta", "phi_true", "vt_true"))
    u, v, w = vt * np.cos(alpha) * np.cos(beta), vt * np.sin(beta), vt * np.sin(alpha) * np.cos(beta)
    right, below = v * np.cos(phi) - w * np.sin(phi), v * np.sin(phi) + w * np.cos(phi)
    forward, down = (
        u * np.cos(theta) + below * np.sin(theta),
        -u * np.sin(theta) + below * np.cos(theta),
    )
    speed = np.sqrt(
        (forward + r["wx_true"]) ** 2 + (right + r["wy_true"]) ** 2 + (down + r["wz_true"]) ** 2
    )
    assert np.abs(speed - r["vg"]).max() < 1e-4
    assert np.abs(-(down + r["wz_true"]) - r["vz"]).max() < 1e-4


@pytest.mark.parametrize("name", NAMES)
def test_motion_stays_longitudinal(name):
    """The paper's plane model holds: wings level, and (10) to (15) are off by less than 0.5 kt for it."""
    r = load_recording(name)
    assert np.degrees(np.abs(r["phi_true"])).max() < 1.5
    slope = r["alpha_true"] - r["theta"]
    u, w = (
        r["vt_true"] * np.cos(slope) + r["wx_true"],
        r["vt_true"] * np.sin(slope) + r["wz_true"],
    )
    assert np.abs(np.hypot(u, w) - r["vg"]).max() < 0.5
    assert np.abs(w + r["vz"]).max() < 0.1


def residuals_of_8_and_9(r):
    """Left minus right side of the exact (8) [rad/s] and (9) [kt/s], trapezoid over a frame, exact wind
    steps.
    """
    alpha, slope, vt = r["alpha_true"], r["alpha_true"] - r["theta"], r["vt_true"]
    f_alpha = -r["ax"] * np.sin(alpha) + r["az"] * np.cos(alpha) + G * np.cos(slope)
    f_v = r["ax"] * np.cos(alpha) + r["az"] * np.sin(alpha) + G * np.sin(slope)
    wx, wz = np.diff(r["wx_true"]), np.diff(r["wz_true"])
    wind_alpha = wx * mean(np.sin(slope) / vt) - wz * mean(np.cos(slope) / vt)
    wind_v = wx * mean(np.cos(slope)) + wz * mean(np.sin(slope))
    return (
        (np.diff(alpha) - wind_alpha) / TS - mean(f_alpha / vt + r["q"]),
        (np.diff(vt) + wind_v) / TS - mean(f_v),
    )


@pytest.mark.parametrize("name", SMOOTH)
def test_equations_8_and_9_close_in_smooth_air(name):
    e_alpha, e_v = residuals_of_8_and_9(load_recording(name))
    assert np.degrees(np.abs(e_alpha)).max() < 0.013
    assert np.abs(e_v).max() < 0.007


def test_equations_8_and_9_are_a_test_at_all():
    """The same residuals see a wind of the wrong sign and a specific force one frame late."""
    r = load_recording("a320_wind_350kt_5000ft")
    e_alpha, e_v = residuals_of_8_and_9(r.with_columns({"wz_true": -r["wz_true"], "wx_true": -r["wx_true"]}))
    assert np.degrees(np.abs(e_alpha)).max() > 1.0
    assert np.abs(e_v).max() > 10.0
    late = r.with_columns({"az": np.roll(r["az"], 1)})
    assert np.degrees(np.abs(residuals_of_8_and_9(late)[0][1:])).max() > 0.03


@pytest.mark.parametrize("name", NAMES)
def test_formula_16_gives_the_calibrated_airspeed(name):
    r = load_recording(name)
    t0, lapse, gas = 288.15, -0.0065, 287.05287
    assert r["z"].max() < 11000.0
    temperature = t0 + lapse * r["z"]
    pressure = (1 + lapse * r["z"] / t0) ** (9.80665 / (-lapse * gas))
    dynamic = ((1 + (r["vt_true"] * KT) ** 2 / (7.0 * gas * temperature)) ** 3.5 - 1) * pressure
    vc = np.sqrt(7.0 * gas * t0 * ((dynamic + 1) ** (1 / 3.5) - 1)) / KT
    assert np.abs(vc - r["vc_true"]).max() < 0.001
    assert np.abs(temperature - r["temperature_true"]).max() < 0.001


@pytest.mark.parametrize("name", NAMES)
def test_winds_stay_inside_the_assumed_bounds(name):
    r = load_recording(name)
    assert np.abs(r["wx_true"]).max() <= 60.0
    assert np.abs(r["wz_true"]).max() <= 30.0
    rates = [np.abs(np.diff(r[wind])).max() / TS for wind in ("wx_true", "wz_true")]
    if name in SMOOTH:
        assert max(rates) <= 15.0
    else:  # Milspec turbulence is above the paper's bound from sample to sample; the catalogue says so
        assert max(rates) > 15.0


def test_what_each_recording_is_for():
    calm = load_recording("a320_calm_350kt_5000ft")
    assert len(calm) * TS >= 60.0
    assert np.abs(calm["wx_true"]).max() == np.abs(calm["wz_true"]).max() == 0.0
    assert np.abs(calm["vc_true"] - 350.0).max() < 0.01
    assert np.abs(calm["z"] / 0.3048 - 5000.0).max() < 5.0
    assert np.abs(calm["az"] + G).max() < 0.03
    shear = load_recording("787_shear_280kt_33000ft")
    assert shear["z"].max() / 0.3048 > 34500.0
    assert np.ptp(shear["wx_true"]) > 20.0
    slow = load_recording("a320_slow_190kt_3000ft")
    assert slow["vc_true"].max() < 210.0
    assert np.degrees(slow["alpha_true"].max()) > 7.0
    ramps = load_recording("787_ramps_300kt_15000ft")
    assert np.ptp(ramps["wx_true"]) > 75.0
    assert np.ptp(ramps["wz_true"]) > 35.0
    for name in NAMES:
        assert 60.0 <= load_recording(name)["t"][-1] <= 120.1


def test_frames_are_0_048_s_apart():
    for name in NAMES:
        t = load_recording(name)["t"]
        assert t[0] == 0.0
        assert np.abs(np.diff(t) - TS).max() < 1e-6
