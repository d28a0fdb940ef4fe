"""Flies a :class:`FlightPlan` with JSBSim and writes down what happened.

Frames are 0.048 s apart, 6 steps of 0.008 s. The first 90 s are not recorded: the aircraft is trimmed in calm
air, the wind of t = 0 is faded in, and everything settles. What is taken from where:

- specific force: total body forces over mass (JSBSim's own accelerations lag a frame or have a lever arm);
- ground speed: all three velocity components (``velocities/vg-fps`` is horizontal);
- pressure altitude: from the static pressure, by the standard atmosphere;
- wind: ``atmosphere/total-wind-*``, turbulence included, seen along the aircraft's heading (``wx``, tail
  positive), to its right (``wy``) and down (``wz``); in turbulence it is the wind at the centre of gravity at
  the instant of the frame, not an average over the frame.

The Earth is JSBSim's: round, turning, gravity changing with place; flights start at 45 deg latitude heading
north, where gravity at low altitude is closest to the standard 9.80665 m/s^2.
"""

from __future__ import annotations

import contextlib
import math
import os
import sys
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from saoflow.diagnosis import refusal
from verification.flights.autopilot import Autopilot, Command, Motion, Surfaces
from verification.flights.plan import (
    AltitudeChange,
    FlightPlan,
    PitchDoublet,
    SpeedChange,
    Turbulence,
    smooth_step,
)
from verification.recordings.recording import FRAME_PERIOD, Recording

STEP = 0.008  # [s]
STEPS_PER_FRAME = 6
SETTLE_S = 90.0  # not recorded: calm, then the wind fades in over FADE_S, then the rest settles
FADE_START_S, FADE_S = 2.0, 40.0
KT = 1852.0 / 3600.0  # [m/s]
FPS_IN_KT = 0.3048 / KT
JSBSIM_VERSION = "1.3.3"

COLUMNS: tuple[tuple[str, str, str], ...] = (
    ("t", "s", "time since the first frame"),
    ("vg", "kt", "inertial speed, all three components"),
    ("vz", "kt", "vertical speed, up positive"),
    ("theta", "rad", "pitch angle"),
    ("q", "rad/s", "pitch rate"),
    ("ax", "kt/s^2", "specific force, forward"),
    ("az", "kt/s^2", "specific force, down; about -g in level flight"),
    ("z", "m", "pressure altitude"),
    ("alpha_true", "rad", "angle of attack"),
    ("vc_true", "kt", "calibrated airspeed"),
    ("vt_true", "kt", "true airspeed"),
    ("wx_true", "kt", "wind along the heading, tail positive"),
    ("wz_true", "kt", "vertical wind, down positive"),
    ("wy_true", "kt", "wind across the heading, towards the right positive"),
    ("beta_true", "rad", "sideslip angle"),
    ("phi_true", "rad", "bank angle"),
    ("mach_true", "", "Mach number"),
    ("temperature_true", "K", "outside air temperature"),
    ("elevator", "", "elevator command of the recorder's pilot, -1 to 1"),
    ("throttle", "", "throttle command of the recorder's pilot, 0 to 1"),
)
"""The columns of a recording: name, unit, meaning."""


def record(plan: FlightPlan, progress: Callable[[float], None] | None = None) -> Recording:
    """Flies ``plan``; columns as in :data:`COLUMNS`, round(duration_s / 0.048) + 1 frames.

    The same plan gives the same numbers. ``progress`` is called now and then with the fraction done, 0 to 1.
    Raises DiagnosisError E703 (no jsbsim) and E704 (the flight got out of hand).
    """
    with _silence():
        fdm = _trimmed(plan)
    return _fly(plan, fdm, progress or (lambda fraction: None))


def jsbsim_module() -> Any:
    """The module ``jsbsim``. Raises DiagnosisError E703 if it is not installed."""
    try:
        import jsbsim
    except ImportError:
        raise refusal(
            "E703",
            "recording a flight needs jsbsim",
            cause="the package jsbsim is not installed",
            remedy="pip install 'saoflow[flights]'; the shipped recordings need nothing",
        ) from None
    version = getattr(jsbsim, "__version__", "unknown")
    if version != JSBSIM_VERSION:
        raise refusal(
            "E703",
            f"recording a flight needs jsbsim {JSBSIM_VERSION}",
            cause=f"version {version} is installed; another version flies another flight",
            remedy="pip install 'saoflow[flights]'",
        )
    return jsbsim


@contextlib.contextmanager
def _silence() -> Iterator[None]:
    """Sends the C library's standard output to nowhere: JSBSim prints whatever its debug level is."""
    sys.stdout.flush()
    try:
        kept = os.dup(1)
    except OSError:  # no standard output to keep silent
        yield
        return
    nowhere = os.open(os.devnull, os.O_WRONLY)
    try:
        os.dup2(nowhere, 1)
        yield
    finally:
        os.dup2(kept, 1)
        os.close(kept)
        os.close(nowhere)


def _trimmed(plan: FlightPlan) -> Any:
    jsbsim = jsbsim_module()
    jsbsim.FGJSBBase().debug_lvl = 0
    fdm = jsbsim.FGFDMExec(None)
    fdm.set_debug_level(0)
    fdm.load_model(plan.aircraft)
    fdm.set_dt(STEP)
    for quantity in ("rate/rotational", "position/rotational"):
        # Adams-Bashforth 3: JSBSim's own choice for rotation, Euler, is half a step off in pitch.
        fdm[f"simulation/integrator/{quantity}"] = 4
    fdm["simulation/randomseed"] = plan.seed
    fdm["atmosphere/delta-T"] = plan.delta_isa_k * 1.8  # JSBSim wants degrees Rankine
    fdm["ic/lat-geod-deg"] = 45.0
    fdm["ic/psi-true-deg"] = 0.0
    fdm["ic/h-sl-ft"] = plan.altitude_ft
    fdm["ic/vc-kts"] = plan.cas_kt
    fdm["ic/beta-deg"] = 0.0  # after the airspeed, which sets it
    fdm["gear/gear-cmd-norm"] = 0.0
    fdm["gear/gear-pos-norm"] = 0.0
    fdm["propulsion/set-running"] = -1
    fdm.run_ic()
    fdm["propulsion/set-running"] = -1
    try:
        fdm.do_trim(1)
    except Exception as error:
        raise refusal(
            "E704",
            f"flight `{plan.name}`: no trim at {plan.cas_kt:g} kt, {plan.altitude_ft:g} ft",
            cause=f"JSBSim: {error}",
            remedy="choose a speed and an altitude that the aircraft can hold",
        ) from None
    for wind in plan.wind:
        if isinstance(wind, Turbulence):
            fdm["atmosphere/turb-type"] = 3  # MIL-F-8785C
            fdm["atmosphere/turbulence/milspec/windspeed_at_20ft_AGL-fps"] = wind.wind_at_20ft_kt / FPS_IN_KT
            fdm["atmosphere/turbulence/milspec/severity"] = wind.severity
    return fdm


def _fly(plan: FlightPlan, fdm: Any, progress: Callable[[float], None]) -> Recording:
    trim = Surfaces(fdm["fcs/elevator-cmd-norm"], 0.0, fdm["fcs/throttle-cmd-norm[0]"])
    pilot = Autopilot(trim, fdm["attitude/theta-rad"], 0.0, STEP)
    frames = round(plan.duration_s / FRAME_PERIOD) + 1
    settle = round(SETTLE_S / FRAME_PERIOD) * STEPS_PER_FRAME
    total = settle + (frames - 1) * STEPS_PER_FRAME
    rows = np.empty((frames, len(COLUMNS)))
    cas_before = fdm["velocities/vc-kts"]
    cas_rate = 0.0
    for step in range(total + 1):
        t = (step - settle) * STEP
        _set_wind(plan, fdm, t)
        fdm.run()
        motion = _motion(fdm, cas_rate)
        cas_rate += 0.02 * ((motion.cas_kt - cas_before) / STEP - cas_rate)
        cas_before = motion.cas_kt
        surfaces = pilot.step(_command(plan, t), motion)
        fdm["fcs/elevator-cmd-norm"] = surfaces.elevator
        fdm["fcs/aileron-cmd-norm"] = surfaces.aileron
        fdm["fcs/throttle-cmd-norm[0]"] = surfaces.throttle
        fdm["fcs/throttle-cmd-norm[1]"] = surfaces.throttle
        if step >= settle and (step - settle) % STEPS_PER_FRAME == 0:
            frame = (step - settle) // STEPS_PER_FRAME
            rows[frame] = _row(fdm, frame * FRAME_PERIOD, surfaces)
        if step % STEPS_PER_FRAME == 0:
            _in_hand(plan, fdm, t)
        if step % 625 == 0:
            progress(step / total)
    progress(1.0)
    names = tuple(name for name, _, _ in COLUMNS)
    return Recording(names, tuple(rows.T), FRAME_PERIOD)


def _set_wind(plan: FlightPlan, fdm: Any, t: float) -> None:
    fade = smooth_step(t, FADE_START_S - SETTLE_S, FADE_S)
    altitude = fdm["position/h-sl-ft"]
    parts = [wind.wind_kt(t, altitude) for wind in plan.wind if not isinstance(wind, Turbulence)]
    north, east, down = (fade * sum(part[axis] for part in parts) / FPS_IN_KT for axis in range(3))
    fdm["atmosphere/wind-north-fps"] = north
    fdm["atmosphere/wind-east-fps"] = east
    fdm["atmosphere/wind-down-fps"] = down


def _command(plan: FlightPlan, t: float) -> Command:
    altitude, before, cas, pitch = plan.altitude_ft, plan.altitude_ft, plan.cas_kt, 0.0
    for part in plan.manoeuvre:
        if isinstance(part, AltitudeChange):
            altitude += part.altitude_ft(t)
            before += part.altitude_ft(t - 0.5)
        elif isinstance(part, SpeedChange):
            cas += part.cas_kt(t)
        elif isinstance(part, PitchDoublet):
            pitch += math.radians(part.theta_deg(t))
    return Command(altitude, (altitude - before) / 0.5, cas, pitch)


def _motion(fdm: Any, cas_rate: float) -> Motion:
    return Motion(
        theta=fdm["attitude/theta-rad"],
        phi=fdm["attitude/phi-rad"],
        psi=fdm["attitude/psi-rad"],
        p=fdm["velocities/p-rad_sec"],
        q=fdm["velocities/q-rad_sec"],
        altitude_ft=fdm["position/h-sl-ft"],
        climb_fps=-fdm["velocities/v-down-fps"],
        cas_kt=fdm["velocities/vc-kts"],
        cas_rate_kt_s=cas_rate,
        speed_fps=fdm["velocities/vt-fps"],
        qbar_psf=fdm["aero/qbar-psf"],
    )


def pressure_altitude(pressure_psf: float) -> float:
    """Pressure altitude [m] of a static pressure [psf], International Standard Atmosphere up to 20 km."""
    ratio = pressure_psf * 47.88025898 / 101325.0
    exponent = 0.0065 * 287.05287 / 9.80665
    z: float = 288.15 / 0.0065 * (1.0 - ratio**exponent)
    if z <= 11000.0:
        return z
    ratio_tropopause = (216.65 / 288.15) ** (1.0 / exponent)
    return 11000.0 - 287.05287 * 216.65 / 9.80665 * math.log(ratio / ratio_tropopause)


def _row(fdm: Any, t: float, surfaces: Surfaces) -> tuple[float, ...]:
    north, east, down = (fdm[f"velocities/v-{axis}-fps"] for axis in ("north", "east", "down"))
    wind_n, wind_e, wind_d = (fdm[f"atmosphere/total-wind-{axis}-fps"] for axis in ("north", "east", "down"))
    psi = fdm["attitude/psi-rad"]
    mass = fdm["inertia/mass-slugs"]
    return (
        t,
        math.sqrt(north**2 + east**2 + down**2) * FPS_IN_KT,
        -down * FPS_IN_KT,
        fdm["attitude/theta-rad"],
        fdm["velocities/q-rad_sec"],
        fdm["forces/fbx-total-lbs"] / mass * FPS_IN_KT,
        fdm["forces/fbz-total-lbs"] / mass * FPS_IN_KT,
        pressure_altitude(fdm["atmosphere/P-psf"]),
        fdm["aero/alpha-rad"],
        fdm["velocities/vc-kts"],
        fdm["velocities/vt-fps"] * FPS_IN_KT,
        (wind_n * math.cos(psi) + wind_e * math.sin(psi)) * FPS_IN_KT,
        wind_d * FPS_IN_KT,
        (wind_e * math.cos(psi) - wind_n * math.sin(psi)) * FPS_IN_KT,
        fdm["aero/beta-rad"],
        fdm["attitude/phi-rad"],
        fdm["velocities/mach"],
        fdm["atmosphere/T-R"] / 1.8,
        surfaces.elevator,
        surfaces.throttle,
    )


def _in_hand(plan: FlightPlan, fdm: Any, t: float) -> None:
    alpha, phi = fdm["aero/alpha-deg"], fdm["attitude/phi-deg"]
    if not (-10.0 < alpha < 16.0 and abs(phi) < 20.0 and fdm["position/h-sl-ft"] > 200.0):
        raise refusal(
            "E704",
            f"flight `{plan.name}`: out of hand at t = {t:.1f} s",
            cause=f"angle of attack {alpha:.1f} deg, bank {phi:.1f} deg",
            remedy="fly smaller manoeuvres or winds, or at another speed",
        )
