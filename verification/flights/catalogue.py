"""The named flights. Those marked as shipped lie in ``verification/recordings`` as files."""

from __future__ import annotations

from dataclasses import replace

from saoflow.diagnosis import unknown_name
from verification.flights.plan import (
    AltitudeChange,
    FlightPlan,
    PitchDoublet,
    SpeedChange,
    SteadyWind,
    Turbulence,
    VerticalGust,
    WindRamp,
    WindShear,
)

SHIPPED: tuple[FlightPlan, ...] = (
    FlightPlan(
        "a320_calm_350kt_5000ft",
        "A320",
        350.0,
        5000.0,
        72.0,
        doc="The paper's Fig. 4 condition: level, calm, nearly steady.",
    ),
    FlightPlan(
        "a320_wind_350kt_5000ft",
        "A320",
        350.0,
        5000.0,
        90.0,
        (
            PitchDoublet(8.0, 2.0, 6.0),
            AltitudeChange(20.0, 500.0, 1500.0),
            SpeedChange(30.0, -25.0, 1.0),
            PitchDoublet(56.0, -1.5, 5.0),
        ),
        (
            SteadyWind(wx_kt=20.0),
            WindRamp("x", 12.0, -50.0, 3.0),
            VerticalGust(26.0, 14.0, 4.0, 6.0),
            WindRamp("x", 42.0, 70.0, 7.0),
            VerticalGust(66.0, -16.0, 3.0, 3.0),
        ),
        doc="Manoeuvres in changing horizontal and vertical wind, inside the paper's bounds.",
    ),
    FlightPlan(
        "787_shear_280kt_33000ft",
        "787-8",
        280.0,
        33000.0,
        120.0,
        (AltitudeChange(10.0, 2000.0, 1800.0), SpeedChange(60.0, -8.0, 0.4), PitchDoublet(98.0, 1.5, 8.0)),
        (SteadyWind(wx_kt=-40.0, wy_kt=15.0), WindShear(12.0, 33000.0)),
        doc="Climb through a shear of 12 kt in 1000 ft and level-off at FL350, cross wind.",
    ),
    FlightPlan(
        "a320_slow_190kt_3000ft",
        "A320",
        190.0,
        3000.0,
        90.0,
        (
            PitchDoublet(6.0, 2.5, 7.0),
            SpeedChange(18.0, 12.0, 0.8),
            AltitudeChange(40.0, -500.0, 900.0),
            PitchDoublet(76.0, -2.0, 6.0),
        ),
        (SteadyWind(wx_kt=-12.0), VerticalGust(28.0, 8.0, 4.0, 5.0), WindRamp("x", 58.0, 20.0, 2.0)),
        doc="Slow, at 5 to 8 deg angle of attack, descending, with a down-draught and a falling head wind.",
    ),
    FlightPlan(
        "a320_turbulence_280kt_20000ft",
        "A320",
        280.0,
        20000.0,
        90.0,
        (PitchDoublet(15.0, 1.5, 6.0), AltitudeChange(35.0, 600.0, 1200.0)),
        (SteadyWind(wx_kt=25.0), Turbulence(severity=3)),
        seed=20,
        doc="Light MIL-F-8785C turbulence on a steady tail wind.",
    ),
    FlightPlan(
        "787_ramps_300kt_15000ft",
        "787-8",
        300.0,
        15000.0,
        120.0,
        (
            SpeedChange(5.0, -15.0, 0.8),
            PitchDoublet(34.0, 1.5, 6.0),
            AltitudeChange(48.0, 800.0, 1500.0),
            SpeedChange(84.0, 15.0, 0.8),
        ),
        (
            SteadyWind(wx_kt=40.0),
            WindRamp("x", 15.0, -85.0, 5.0),
            WindRamp("z", 44.0, 20.0, 8.0),
            WindRamp("z", 56.0, -40.0, 8.0),
            WindRamp("z", 70.0, 20.0, 8.0),
            WindRamp("x", 92.0, 75.0, 10.0),
        ),
        doc="Long fast ramps of both winds, near the paper's bounds, with changes of speed and height.",
    ),
)

_MORE: tuple[FlightPlan, ...] = (
    FlightPlan("a320_calm_220kt_10000ft", "A320", 220.0, 10000.0, 60.0, doc="Level, calm."),
    FlightPlan("a320_calm_280kt_35000ft", "A320", 280.0, 35000.0, 60.0, doc="Level, calm, cruise."),
    FlightPlan("787_calm_350kt_5000ft", "787-8", 350.0, 5000.0, 60.0, doc="Level, calm."),
    FlightPlan("787_calm_280kt_35000ft", "787-8", 280.0, 35000.0, 60.0, doc="Level, calm, cruise."),
    FlightPlan(
        "a320_doublets_300kt_10000ft",
        "A320",
        300.0,
        10000.0,
        60.0,
        tuple(PitchDoublet(8.0 + 13.0 * i, amplitude, 6.0) for i, amplitude in enumerate((1.0, -2.0, 3.0, -1.5))),
        doc="Pitch doublets, calm.",
    ),
    FlightPlan(
        "787_gusts_250kt_25000ft",
        "787-8",
        250.0,
        25000.0,
        90.0,
        (),
        tuple(VerticalGust(10.0 + 25.0 * i, peak, 2.5, 5.0) for i, peak in enumerate((10.0, -18.0, 20.0))),
        doc="Vertical gusts, nothing commanded.",
    ),
    FlightPlan(
        "787_turbulence_280kt_33000ft",
        "787-8",
        280.0,
        33000.0,
        90.0,
        (),
        (SteadyWind(wx_kt=-45.0), Turbulence(severity=4)),
        seed=21,
        doc="Moderate turbulence on a steady head wind.",
    ),
    FlightPlan(
        "a320_hot_280kt_20000ft",
        "A320",
        280.0,
        20000.0,
        60.0,
        (PitchDoublet(20.0, 1.5, 6.0),),
        (SteadyWind(wx_kt=20.0),),
        delta_isa_k=15.0,
        doc="15 K above the standard atmosphere, which the paper's (16) does not know.",
    ),
    FlightPlan(
        "a320_beyond_350kt_5000ft",
        "A320",
        350.0,
        5000.0,
        90.0,
        (),
        (SteadyWind(wx_kt=20.0), WindRamp("x", 20.0, 70.0, 5.0)),
        doc="Tail wind of 90 kt, beyond the bound of 60 kt: false alarms expected, as the paper says.",
    ),
)

FLIGHTS: tuple[FlightPlan, ...] = SHIPPED + _MORE


def find_flight(name: str, aircraft: str | None = None, seed: int | None = None) -> FlightPlan:
    """The named flight, with another aircraft or seed if given. Raises DiagnosisError E701 and E702."""
    names = [plan.name for plan in FLIGHTS]
    if name not in names:
        otherwise = "name one of them; `saoflow fly --list` says what they are"
        raise unknown_name("E701", f"no flight `{name}`", name, names, what="flights", otherwise=otherwise)
    plan = FLIGHTS[names.index(name)]
    if aircraft is not None:
        plan = replace(plan, aircraft=aircraft)
    return plan if seed is None else replace(plan, seed=seed)
