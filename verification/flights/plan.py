"""What a flight is made of: aircraft, start, manoeuvres, winds. Values only; ``record`` flies them.

All times are in s from the first recorded frame. Everything is smooth by construction where an aircraft or
the air would be smooth: commands and ramps have cosine corners, so that no step excites the recorder's
integrator.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, fields

from saoflow.diagnosis import did_you_mean, refusal

AIRCRAFT = ("A320", "787-8")
"""JSBSim aircraft that may be flown. Loading some others (737, c172x) opens network sockets."""

FEET_PER_KFT = 1000.0


def _sensible(part: object, above_zero: tuple[str, ...] = (), not_zero: tuple[str, ...] = ()) -> None:
    """Raises DiagnosisError E705 unless all numbers of the dataclass ``part`` are finite, the named ones as named."""
    what = type(part).__name__
    for f in fields(part):  # type: ignore[arg-type]
        value = getattr(part, f.name)
        if isinstance(value, str):
            continue
        cause = ""
        if not math.isfinite(value):
            cause = "it must be finite"
        elif f.name in above_zero and value <= 0.0:
            cause = "it must be above 0"
        elif f.name in not_zero and value == 0.0:
            cause = "it must not be 0"
        if cause:
            raise refusal("E705", f"{what}: {f.name} = {value:g}", cause=cause, remedy="change the flight plan")


def smooth_step(t: float, start: float, duration: float) -> float:
    """0 before ``start``, 1 after ``start + duration``, half a cosine in between: greatest slope
    pi/2/duration.
    """
    if duration <= 0.0:
        return 1.0 if t >= start else 0.0
    s = min(max((t - start) / duration, 0.0), 1.0)
    return 0.5 - 0.5 * math.cos(math.pi * s)


def soft_ramp(t: float, start: float, change: float, rate: float, corner: float) -> float:
    """0, then a ramp to ``change`` at |rate| per s, its corners rounded over ``corner`` s (slope never above
    rate).
    """
    duration = max(abs(change) / abs(rate), corner)
    slope = change / duration
    total = duration + corner
    s = min(max(t - start, 0.0), total)

    def risen(x: float) -> float:
        # the integral of a smooth step of length ``corner``
        if x >= corner:
            return x - corner / 2
        return x / 2 - corner / (2 * math.pi) * math.sin(math.pi * x / corner)

    return slope * (risen(s) - (risen(s - duration) if s > duration else 0.0))


@dataclass(frozen=True)
class PitchDoublet:
    """Pitch command: ``amplitude_deg`` up, then down, one period of a sine with cosine-tapered ends."""

    start_s: float
    amplitude_deg: float
    period_s: float = 6.0

    def __post_init__(self) -> None:
        _sensible(self, above_zero=("period_s",))

    def theta_deg(self, t: float) -> float:
        """Added pitch command [deg] at time t [s]."""
        s = (t - self.start_s) / self.period_s
        if not 0.0 <= s <= 1.0:
            return 0.0
        # sin * (1 - cos) has a continuous slope at both ends; 1.299 is its largest value
        return self.amplitude_deg * math.sin(2 * math.pi * s) * (1 - math.cos(2 * math.pi * s)) / 1.299038


@dataclass(frozen=True)
class AltitudeChange:
    """Climb or descent by ``change_ft`` at ``rate_fpm`` and level-off."""

    start_s: float
    change_ft: float
    rate_fpm: float = 1500.0

    def __post_init__(self) -> None:
        _sensible(self, not_zero=("rate_fpm",))

    def altitude_ft(self, t: float) -> float:
        """Added altitude command [ft] at time t [s]."""
        return soft_ramp(t, self.start_s, self.change_ft, self.rate_fpm / 60.0, corner=6.0)


@dataclass(frozen=True)
class SpeedChange:
    """Change of calibrated airspeed by ``change_kt`` at ``rate_kt_s``."""

    start_s: float
    change_kt: float
    rate_kt_s: float = 1.0

    def __post_init__(self) -> None:
        _sensible(self, not_zero=("rate_kt_s",))

    def cas_kt(self, t: float) -> float:
        """Added airspeed command [kt] at time t [s]."""
        return soft_ramp(t, self.start_s, self.change_kt, self.rate_kt_s, corner=4.0)


Manoeuvre = PitchDoublet | AltitudeChange | SpeedChange


@dataclass(frozen=True)
class SteadyWind:
    """Constant wind [kt]: tail, from the left (blowing right), down. Faded in before the recording starts."""

    wx_kt: float = 0.0
    wy_kt: float = 0.0
    wz_kt: float = 0.0

    def __post_init__(self) -> None:
        _sensible(self)

    def wind_kt(self, t: float, altitude_ft: float) -> tuple[float, float, float]:
        """(tail, right, down) [kt]."""
        return self.wx_kt, self.wy_kt, self.wz_kt


@dataclass(frozen=True)
class WindRamp:
    """Wind along ``axis`` ("x" tail, "z" down) that changes by ``change_kt`` at ``rate_kt_s``, corners
    rounded.
    """

    axis: str
    start_s: float
    change_kt: float
    rate_kt_s: float
    corner_s: float = 1.0

    def __post_init__(self) -> None:
        _sensible(self, above_zero=("corner_s",), not_zero=("rate_kt_s",))

    def wind_kt(self, t: float, altitude_ft: float) -> tuple[float, float, float]:
        """(tail, right, down) [kt]."""
        w = soft_ramp(t, self.start_s, self.change_kt, self.rate_kt_s, self.corner_s)
        return (w, 0.0, 0.0) if self.axis == "x" else (0.0, 0.0, w)


@dataclass(frozen=True)
class WindShear:
    """Tail wind proportional to height above ``reference_ft``: ``gradient_kt`` for each 1000 ft."""

    gradient_kt: float
    reference_ft: float

    def __post_init__(self) -> None:
        _sensible(self)

    def wind_kt(self, t: float, altitude_ft: float) -> tuple[float, float, float]:
        """(tail, right, down) [kt]."""
        return self.gradient_kt * (altitude_ft - self.reference_ft) / FEET_PER_KFT, 0.0, 0.0


@dataclass(frozen=True)
class VerticalGust:
    """Vertical wind [kt, down positive]: ramps to ``peak_kt`` in ``rise_s``, holds ``hold_s``, ramps back."""

    start_s: float
    peak_kt: float
    rise_s: float = 3.0
    hold_s: float = 4.0

    def __post_init__(self) -> None:
        _sensible(self, above_zero=("rise_s",))

    def wind_kt(self, t: float, altitude_ft: float) -> tuple[float, float, float]:
        """(tail, right, down) [kt]."""
        up = smooth_step(t, self.start_s, self.rise_s)
        down = smooth_step(t, self.start_s + self.rise_s + self.hold_s, self.rise_s)
        return 0.0, 0.0, self.peak_kt * (up - down)


@dataclass(frozen=True)
class Turbulence:
    """JSBSim's MIL-F-8785C turbulence (Dryden, three axes and rates) at ``severity`` 1 to 7 (3 light, 4
    moderate).

    Above 2000 ft the severity sets it, below ``wind_at_20ft_kt``. Its wind changes faster than 15 kt/s from
    sample to sample: it is turbulence on top of the winds that the paper bounds, not one of them.
    """

    severity: int = 3
    wind_at_20ft_kt: float = 15.0


Wind = SteadyWind | WindRamp | WindShear | VerticalGust | Turbulence


@dataclass(frozen=True)
class FlightPlan:
    """One flight. Raises DiagnosisError E702 (aircraft) or E705 (anything else) if it makes no sense.

    ``cas_kt`` [kt] and ``altitude_ft`` [ft above sea level] at the start, level; ``duration_s`` [s] recorded;
    manoeuvres and winds add up; ``seed`` drives the turbulence alone; ``delta_isa_k`` [K] shifts the temperature
    at every height (so that pressure altitude and altitude above sea level differ).
    """

    name: str
    aircraft: str
    cas_kt: float
    altitude_ft: float
    duration_s: float = 60.0
    manoeuvre: tuple[Manoeuvre, ...] = ()
    wind: tuple[Wind, ...] = ()
    seed: int = 1
    delta_isa_k: float = 0.0
    doc: str = field(default="", compare=False)

    def __post_init__(self) -> None:
        if self.aircraft not in AIRCRAFT:
            raise refusal(
                "E702",
                f"no aircraft `{self.aircraft}`",
                cause=f"known are {', '.join(AIRCRAFT)}",
                remedy=did_you_mean(self.aircraft, AIRCRAFT) or "name one of them",
            )
        self._within("cas_kt", self.cas_kt, 160.0, 400.0, "kt")
        self._within("altitude_ft", self.altitude_ft, 1000.0, 41000.0, "ft")
        self._within("duration_s", self.duration_s, 1.0, 3600.0, "s")
        self._within("delta_isa_k", self.delta_isa_k, -40.0, 40.0, "K")
        self._within("seed", self.seed, 0, 2**31 - 1, "")
        for wind in self.wind:
            if isinstance(wind, WindRamp) and wind.axis not in ("x", "z"):
                self._refuse(f"wind ramp along `{wind.axis}`", "the axes are x (tail) and z (down)")
            if isinstance(wind, Turbulence):
                self._within("turbulence severity", wind.severity, 1, 7, "")

    def _within(self, what: str, value: float, low: float, high: float, unit: str) -> None:
        if not low <= value <= high:
            self._refuse(f"{what} = {value}", f"it must be {low:.10g} to {high:.10g} {unit}".rstrip())

    def _refuse(self, what: str, cause: str) -> None:
        raise refusal("E705", f"flight `{self.name}`: {what}", cause=cause, remedy="change the flight plan")
