"""States to test the reference at: drawn at random, and met on flights with faults."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np

from verification.flights import Fault, Missing, load_recording, sensors
from verification.reference import cmhe_fte
from verification.reference.air_data import calibrated_airspeed
from verification.reference.arrays import KNOT
from verification.reference.inputs import frames
from verification.reference.linearisation import Window, linearise
from verification.reference.tuning import Tuning

TUNING = Tuning()
SIGMA_X = np.sqrt(TUNING.P)
"""Scale of a step in x; a difference counts relative to the larger of the step and this."""
SIGMA_U = np.sqrt(TUNING.Q)

VC_RUNAWAY = Fault("runaway", "vc", rate=-15.0, onset=3.0)
ALPHA_RUNAWAY = Fault("runaway", "alpha", rate=8.0, onset=3.0)
CALM, WINDY = "a320_calm_350kt_5000ft", "a320_wind_350kt_5000ft"


@cache
def flight(name=CALM, seconds=15.0, faults=(), missing=(), start=0.0, seed=1):
    """Return the inputs of a part of a shipped recording, with noise and faults, as a dictionary."""
    recording = load_recording(name).part(start, start + seconds)
    return sensors(recording, seed=seed, faults=faults, missing=missing).inputs()


@cache
def steps(estimator=cmhe_fte, **choice):
    """Return every `Step` of the estimator over `flight(**choice)`."""
    state, done = estimator.initial_state(TUNING), []
    for inputs in frames(flight(**choice)):
        done.append(estimator.step(state, inputs, TUNING))
        state = done[-1].state
    return done


@cache
def realistic_traces(estimator=cmhe_fte):
    """Return traces from flights through configurations I to IV, with bounds active, with missing samples."""
    gap = Missing(inputs=("vg", "vz", "alpha", "vc"), onset=4.0, frames=2)
    chosen = []
    for choice, frames_chosen in (
        ({"faults": (VC_RUNAWAY,)}, (*range(100, 146, 9), *range(146, 168, 2), *range(168, 312, 31))),
        ({"faults": (ALPHA_RUNAWAY,)}, range(60, 312, 21)),
        ({"faults": (VC_RUNAWAY, ALPHA_RUNAWAY)}, range(95, 312, 21)),
        ({"name": WINDY, "seconds": 8.0, "start": 24.0, "missing": (gap,)}, range(0, 166, 14)),
    ):
        done = steps(estimator, **choice)
        chosen += [done[k].trace for k in frames_chosen]
    return chosen


def random_theta(generator, n):
    """Draw Theta: shape (n, 6), SI, level-flight-like forces with large deviations."""
    low = np.array([60.0, -0.4, -0.1, -3.0, -15.0, 0.0])
    high = np.array([340.0, 0.5, 0.1, 4.0, -5.0, 12500.0])
    return generator.uniform(low, high, (n, 6))


def random_point(generator, lower, upper, n):
    """Draw n points inside the bounds, every third entry within 0.1 % to 0.0001 % of the width of one."""
    t = generator.uniform(0.02, 0.98, (n, 4))
    near = 10.0 ** generator.uniform(-6, -3, (n, 4))
    side = generator.random((n, 4)) < 0.5
    t = np.where(generator.random((n, 4)) < 1 / 3, np.where(side, near, 1 - near), t)
    return lower + t * (upper - lower)


def random_qp(seed):
    """Draw a linearised window: any state inside the bounds, any configuration, some samples missing."""
    generator = np.random.default_rng(seed)
    theta = random_theta(generator, 3)
    x = random_point(generator, TUNING.x_lower, TUNING.x_upper, 3)
    u = random_point(generator, TUNING.u_lower, TUNING.u_upper, 2)
    lost = (seed % 4 & 1, seed % 4 >> 1)
    mask = (generator.random((3, 4)) < 0.85) * np.array([1.0, 1.0, 1.0 - lost[0], 1.0 - lost[1]])
    window = Window(theta, np.zeros((3, 4)), mask)
    qp = linearise(x, u, window, TUNING)
    noise = generator.normal(size=(3, 4)) * np.array([1.0, 2.0, 0.03, 5.0])
    return replace(qp, r_y=mask * noise)


def error(got, right, sigma):
    """Return the largest |got - right| / max(|right|, sigma)."""
    return float((np.abs(got - right) / np.maximum(np.abs(right), sigma)).max())


def step_error(got, right):
    """Return the largest error of a step (dx, du) relative to max(|right|, sigma)."""
    return max(error(got[0], right[0], SIGMA_X), error(got[1], right[1], SIGMA_U))


def synthetic(n, v_t=180.0, alpha_deg=3.0, w_x_kt=0.0, w_z_kt=0.0, z=1524.0):
    """Return noise-free inputs of straight level flight in steady wind, from body axes and the wind triangle.

    The aircraft holds its height: the flight path relative to the air climbs to make up for W_z.
    """
    w_x, w_z = w_x_kt * KNOT, w_z_kt * KNOT
    gamma = np.arcsin(w_z / v_t)  # relative to the air, so that the inertial vertical speed is 0
    alpha = np.deg2rad(alpha_deg)
    theta = gamma + alpha
    v_g = v_t * np.cos(gamma) + w_x
    v_c = float(calibrated_airspeed(np.array(v_t), np.array(z))[0]) / KNOT
    ones = np.ones(n)
    return {
        "alpha": np.full((n, 3), alpha),
        "vc": np.full((n, 3), v_c),
        "vg": v_g / KNOT * ones,
        "vz": 0.0 * ones,
        "theta": theta * ones,
        "q": 0.0 * ones,
        "ax": 9.80665 * np.sin(theta) / KNOT * ones,
        "az": -9.80665 * np.cos(theta) / KNOT * ones,
        "z": z * ones,
    }
