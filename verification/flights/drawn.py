"""Flights drawn by seed: aircraft, height, speed, manoeuvres and winds, from stated ranges.

Ranges (:func:`random_plan`):

- start: altitude uniform in the range given, calibrated airspeed uniform between what the aircraft holds there: from
  190 kt at 3000 ft (240 kt at 36 000 ft) to 350 kt (265 kt), cut to the range given;
- manoeuvres one after the other, a pause of 5 to 40 s between them: pitch doublets of 0.5 to 2.5 deg in 5 to 8 s,
  changes of height of 200 to 1500 ft at 800 to 1800 ft/min, changes of speed of 5 to 20 kt at 0.4 to 1 kt/s, never
  more than 1500 ft and 20 kt from the start;
- wind "inside": a steady wind of up to 45 kt along and 20 kt across, ramps to other values in that range and vertical
  winds of up to 24 kt, at 0.5 to 12 kt/s (changes of more than a sixth of the airspeed at most at 4 kt/s), in a fifth
  of the flights a shear of up to 6 kt in 1000 ft;
- wind "beyond", a third each: horizontal wind ramping to 70 to 110 kt; vertical winds of 15 to 26 kt that come at 20
  to 40 kt/s; MIL-F-8785C turbulence of severity 3.

Whether a flight's wind is inside the bounds is measured on its recording, sample by sample (:func:`measure_wind`);
:func:`draw_flight` draws again until it is as asked.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from saoflow.diagnosis import DiagnosisError, refusal
from verification.flights.plan import (
    AIRCRAFT,
    AltitudeChange,
    FlightPlan,
    Manoeuvre,
    PitchDoublet,
    SpeedChange,
    SteadyWind,
    Turbulence,
    VerticalGust,
    Wind,
    WindRamp,
    WindShear,
)
from verification.flights.record import record
from verification.recordings.recording import Recording

MOST_DRAWS = 12
"""Drawings after which a flight is given up."""
MOST_WX, MOST_WZ, MOST_RATE = 60.0, 30.0, 15.0
"""The assumed bounds [kt, kt, kt/s]: paper 004, VI-B, and the flagship's wx_max, wz_max, u_w_max."""
_LOWEST, _HIGHEST = 3000.0, 36000.0


@dataclass(frozen=True)
class MeasuredWind:
    """Largest horizontal and vertical wind [kt] and largest change of either from sample to sample [kt/s]."""

    wx: float
    wz: float
    rate: float

    @property
    def inside(self) -> bool:
        """Whether it keeps to the assumed bounds in every sample."""
        return self.wx <= MOST_WX and self.wz <= MOST_WZ and self.rate <= MOST_RATE


def measure_wind(recording: Recording) -> MeasuredWind:
    """The wind of a recording with the columns wx_true and wz_true. Raises DiagnosisError E722."""
    wx, wz = recording["wx_true"], recording["wz_true"]
    if len(wx) == 1:
        return MeasuredWind(abs(float(wx[0])), abs(float(wz[0])), 0.0)
    rate = max(float(np.abs(np.diff(wx)).max()), float(np.abs(np.diff(wz)).max())) / recording.period
    return MeasuredWind(float(np.abs(wx).max()), float(np.abs(wz).max()), rate)


def draw_flight(
    seed: tuple[int, ...],
    duration: float,
    inside: bool = True,
    aircraft: tuple[str, ...] = AIRCRAFT,
    cas: tuple[float, float] = (160.0, 400.0),
    altitude: tuple[float, float] = (_LOWEST, _HIGHEST),
) -> tuple[FlightPlan, Recording]:
    """Draw, fly and measure until the flight stays in hand and its wind is inside the bounds, or beyond, as asked.

    The same arguments give the same flight. Raises DiagnosisError E703, and E704 after :data:`MOST_DRAWS` drawings.
    """
    last = "no drawing"
    for attempt in range(MOST_DRAWS):
        plan = random_plan((*seed, attempt), duration, inside, aircraft, cas, altitude)
        try:
            recording = record(plan)
        except DiagnosisError as error:
            first = error.diagnoses[0]
            if first.code != "E704":
                raise
            last = f"{first.message}: {first.cause}"
            continue
        wind = measure_wind(recording)
        if wind.inside == inside:
            return plan, recording
        last = f"wind of up to {wind.wx:.1f} kt along, {wind.wz:.1f} kt down, changing by up to {wind.rate:.1f} kt/s"
    raise refusal(
        "E704",
        f"no flight of {duration:g} s with the winds asked for in {MOST_DRAWS} drawings",
        cause=last,
        remedy="widen the ranges of speed and altitude, or take another seed",
    )


def random_plan(
    seed: tuple[int, ...],
    duration: float,
    inside: bool = True,
    aircraft: tuple[str, ...] = AIRCRAFT,
    cas: tuple[float, float] = (160.0, 400.0),
    altitude: tuple[float, float] = (_LOWEST, _HIGHEST),
) -> FlightPlan:
    """A flight plan of ``duration`` [s] drawn by ``seed`` from the ranges above; ``cas`` [kt], ``altitude`` [ft].

    Raises DiagnosisError E705 if no speed of the range can be held at any altitude of the range.
    """
    generator = np.random.default_rng(seed)
    height = _uniform(generator, *altitude)
    low, high = holdable(height)
    low, high = max(low, cas[0]), min(high, cas[1])
    if low > high:
        raise refusal(
            "E705",
            f"no calibrated airspeed between {cas[0]:g} and {cas[1]:g} kt at {height:.0f} ft",
            cause="an airliner holds {:.0f} to {:.0f} kt there".format(*holdable(height)),
            remedy="widen the range of speeds or altitudes",
        )
    speed = _uniform(generator, low, high)
    kind = aircraft[int(generator.integers(len(aircraft)))]
    manoeuvres = _manoeuvres(generator, duration)
    wind = _inside(generator, duration, speed, height) if inside else _beyond(generator, duration)
    name = "drawn_" + "_".join(str(number) for number in seed)
    return FlightPlan(name, kind, speed, height, duration, manoeuvres, wind, seed=int(generator.integers(2**31)))


def holdable(altitude_ft: float) -> tuple[float, float]:
    """Calibrated airspeeds [kt] from which both aircraft can fly the manoeuvres above."""
    share = min(max((altitude_ft - _LOWEST) / (_HIGHEST - _LOWEST), 0.0), 1.0)
    return 190.0 + 50.0 * share, 350.0 - 85.0 * share


def _uniform(generator: np.random.Generator, low: float, high: float) -> float:
    return float(low + (high - low) * generator.random())


def _log_uniform(generator: np.random.Generator, low: float, high: float) -> float:
    return float(low * (high / low) ** generator.random())


def _sign(generator: np.random.Generator) -> float:
    return 1.0 if generator.random() < 0.5 else -1.0


def _manoeuvres(generator: np.random.Generator, duration: float) -> tuple[Manoeuvre, ...]:
    found: list[Manoeuvre] = []
    climbed = faster = 0.0
    t = _uniform(generator, 3.0, 15.0)
    while t < duration - 8.0:
        kind = int(generator.integers(3))
        if kind == 0:
            period = _uniform(generator, 5.0, 8.0)
            found.append(PitchDoublet(t, _sign(generator) * _uniform(generator, 0.5, 2.5), period))
            t += period
        elif kind == 1:
            change, rate = _bounded(generator, climbed, 200.0, 1500.0), _uniform(generator, 800.0, 1800.0)
            found.append(AltitudeChange(t, change, rate))
            climbed += change
            t += 60.0 * abs(change) / rate + 6.0
        else:
            change, rate = _bounded(generator, faster, 5.0, 20.0), _uniform(generator, 0.4, 1.0)
            found.append(SpeedChange(t, change, rate))
            faster += change
            t += abs(change) / rate + 4.0
        t += _uniform(generator, 5.0, 40.0)
    return tuple(found)


def _bounded(generator: np.random.Generator, now: float, least: float, most: float) -> float:
    """A change that leaves the sum within ``most`` of zero."""
    change = _sign(generator) * _uniform(generator, least, most)
    return change if abs(now + change) <= most else -change if abs(now - change) <= most else -now or change


def _inside(generator: np.random.Generator, duration: float, speed: float, height: float) -> tuple[Wind, ...]:
    now = _uniform(generator, -45.0, 45.0)
    found: list[Wind] = [SteadyWind(wx_kt=now, wy_kt=_uniform(generator, -20.0, 20.0))]
    if generator.random() < 0.2:
        # At most 1500 ft from the start: 9 kt at most.
        found.append(WindShear(_uniform(generator, -6.0, 6.0), height))
    t = _uniform(generator, 3.0, 20.0)
    while t < duration - 5.0:
        if generator.random() < 0.5:
            target = _uniform(generator, -45.0, 45.0)
            change = target - now
            rate = _log_uniform(generator, 0.5, 12.0 if abs(change) < speed / 6.0 else 4.0)
            found.append(WindRamp("x", t, change, rate))
            now = target
            t += abs(change) / rate + 1.0
        else:
            gust = _vertical(generator, t, _log_uniform(generator, 2.0, 24.0), _log_uniform(generator, 0.5, 12.0))
            found.append(gust)
            t += 2.0 * gust.rise_s + gust.hold_s
        t += _uniform(generator, 2.0, 30.0)
    return tuple(found)


def _vertical(generator: np.random.Generator, t: float, peak: float, rate: float) -> VerticalGust:
    """Rises at ``rate`` [kt/s] at most; half a cosine is pi/2 times as steep as its mean."""
    hold = _uniform(generator, 1.0, 10.0)
    return VerticalGust(t, _sign(generator) * peak, math.pi / 2.0 * peak / rate, hold)


def _beyond(generator: np.random.Generator, duration: float) -> tuple[Wind, ...]:
    now = _uniform(generator, -30.0, 30.0)
    steady = SteadyWind(wx_kt=now, wy_kt=_uniform(generator, -20.0, 20.0))
    start = _uniform(generator, 5.0, max(6.0, min(30.0, duration / 3.0)))
    kind = int(generator.integers(3))
    if kind == 0:
        target = _sign(generator) * _uniform(generator, 70.0, 110.0)
        return steady, WindRamp("x", start, target - now, _uniform(generator, 1.5, 4.0))
    if kind == 1:
        gusts = []
        while start < duration - 5.0:
            gust = _vertical(generator, start, _uniform(generator, 15.0, 26.0), _uniform(generator, 20.0, 40.0))
            gusts.append(gust)
            start += 2.0 * gust.rise_s + gust.hold_s + _uniform(generator, 8.0, 40.0)
        return steady, *gusts
    return steady, Turbulence(severity=3)
