"""``saoflow fly``: record a flight, make its sensor readings, write both to a file."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from saoflow.diagnosis import refusal
from saoflow.recordings import check_output
from verification.flights.catalogue import find_flight
from verification.flights.faults import Fault, Missing
from verification.flights.plan import FlightPlan
from verification.flights.record import record
from verification.flights.sensors import NO_NOISE, TABLE_I, sensors
from verification.recordings.recording import FRAME_PERIOD, Recording, write_recording


def fly(
    aircraft: str | None,
    flight: str,
    seed: int | None,
    noise: bool,
    faults: Sequence[Fault],
    output: str | Path,
    missing: Sequence[Missing] = (),
    progress: Callable[[float], None] | None = None,
) -> Recording:
    """Records ``flight`` and writes it, with sensor readings and truth, to ``output`` (.csv, .csv.gz,
    .parquet).

    ``aircraft``, ``seed``: of the flight itself if None; the seed drives turbulence and noise. Without
    ``noise`` the readings are the truth, plus ``faults`` and ``missing``. Everything that can be refused is
    refused before the flight. Returns what was written. Raises DiagnosisError: E7xx, E601, E605.
    """
    plan = find_flight(flight, aircraft, seed)
    check_onsets(plan, (*faults, *missing))
    check_output(output)
    return fly_plan(plan, noise, faults, output, missing, progress)


def check_onsets(plan: FlightPlan, events: Sequence[Fault | Missing]) -> None:
    """Raises DiagnosisError E711 (fault) or E714 (missing samples) if one starts after the flight's end."""
    for event in events:
        if event.onset > plan.duration_s:
            raise refusal(
                "E711" if isinstance(event, Fault) else "E714",
                f"onset = {event.onset:g} s",
                cause=f"the flight `{plan.name}` ends at {plan.duration_s:g} s",
                remedy="let it start earlier",
            )


def fly_plan(
    plan: FlightPlan,
    noise: bool,
    faults: Sequence[Fault],
    output: str | Path,
    missing: Sequence[Missing] = (),
    progress: Callable[[float], None] | None = None,
) -> Recording:
    """:func:`fly` of a plan of one's own, its requests already checked."""
    truth = record(plan, progress)
    readings = sensors(truth, plan.seed, TABLE_I if noise else NO_NOISE, faults, missing)
    write_recording(readings, output)
    return readings


def summary(recording: Recording, output: str | Path) -> str:
    """One line on what was written."""
    length = (len(recording) - 1) * FRAME_PERIOD
    return f"{output}: {len(recording)} frames, {length:.1f} s, {len(recording.names)} columns"
