"""The named flights. Those marked as shipped lie in ``verification/recordings`` as files."""

from __future__ import annotations

from dataclasses import replace

from verification.flights.errors import FlightError, did_you_mean
from verification.flights.plan import (
    AltitudeChange,
    FlightPlan,
    Manoeuvre,
    PitchDoublet,
    SpeedChange,
    SteadyWind,
    VerticalGust,
    WindRamp,
)

_LIVELY: tuple[Manoeuvre, ...] = (
    PitchDoublet(8.0, 2.0, 6.0),
    AltitudeChange(20.0, 500.0, 1500.0),
    SpeedChange(30.0, -20.0, 1.0),
    PitchDoublet(52.0, -1.5, 5.0),
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
        _LIVELY,
        (
            SteadyWind(wx_kt=-15.0),
            WindRamp("x", 12.0, 45.0, 6.0),
            VerticalGust(26.0, 14.0, 4.0, 6.0),
            WindRamp("x", 42.0, -75.0, 8.0),
            VerticalGust(64.0, -16.0, 3.0, 3.0),
        ),
        doc="Manoeuvres in changing horizontal and vertical wind, inside the paper's bounds.",
    ),
)

FLIGHTS: tuple[FlightPlan, ...] = SHIPPED


def find_flight(name: str, aircraft: str | None = None, seed: int | None = None) -> FlightPlan:
    """The named flight, with another aircraft or seed if given. Raises F101 and F102."""
    names = [plan.name for plan in FLIGHTS]
    if name not in names:
        raise FlightError(
            "F101",
            f"no flight '{name}'",
            cause=f"flights are {', '.join(names)}",
            remedy="name one of them",
            hint=did_you_mean(name, names),
        )
    plan = FLIGHTS[names.index(name)]
    if aircraft is not None:
        plan = replace(plan, aircraft=aircraft)
    return plan if seed is None else replace(plan, seed=seed)
