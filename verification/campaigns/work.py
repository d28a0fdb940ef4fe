"""Flying a chunk of runs, side by side in compiled C, or in the interpreter without a compiler; rows come out."""

from __future__ import annotations

import threading
import warnings
from collections.abc import Sequence

import numpy as np

from saoflow.diagnosis import DiagnosisError
from saoflow.scheduler.simulator import Simulator
from verification.campaigns.cases import Case, Cases, Chunk, part_of
from verification.campaigns.flights import flown
from verification.campaigns.plan import Campaign, RecordedFlights, Variant
from verification.campaigns.readings import Flight, stacked_readings
from verification.campaigns.row import Row, fault_columns
from verification.campaigns.sheets import load_variant
from verification.campaigns.summary import OUTPUTS, summary
from verification.recordings import Recording
from verification.recordings.recording import Array

BACKEND = "c"


def fly_chunk(campaign: Campaign, chunk: Chunk, backend: str = BACKEND) -> list[Row]:
    """The rows of a chunk, in order of their runs. What goes wrong with a run stands in its row; nothing is raised.

    The same runs give the same rows, bit for bit, whatever chunk, process and backend they are flown in.
    """
    cases = Cases(campaign)
    rows: dict[int, Row] = {}
    flights: list[Flight] = []
    for number in range(chunk.first, chunk.stop):
        case = cases.case(number)
        try:
            flights.append(_flight(campaign, case))
        except Exception as error:
            rows[number] = failed(case, error)
    for row in _fly(flights, backend):
        rows[row.run] = row
    return [rows[number] for number in sorted(rows)]


def failed(case: Case, error: BaseException | str) -> Row:
    """The row of a run without a result."""
    base = _base(case, "", "", 0, 0, 0.0)
    return Row(**base, failure=error if isinstance(error, str) else reason(error))  # type: ignore[arg-type]


def reason(error: BaseException) -> str:
    """One line: the first diagnosis, or the kind of error and its text."""
    if isinstance(error, DiagnosisError):
        first = error.diagnoses[0]
        return " ".join(f"{first.code}: {first.message}; {first.cause}".split())
    if isinstance(error, MemoryError):
        return "out of memory"
    return " ".join(f"{type(error).__name__}: {error}".split()).rstrip(": ")


def _flight(campaign: Campaign, case: Case) -> Flight:
    flights = campaign.flight_set(case.runs.flights)
    found = flown(flights, case.flight)
    truth, start = found.truth, 0
    if isinstance(flights, RecordedFlights):
        start, frames = part_of(flights, len(truth), case.start)
        columns = tuple(column[start : start + frames] for column in truth.columns)
        truth = Recording(truth.names, columns, truth.period)
    return Flight(case, found.name, found.aircraft, start, truth)


def _fly(flights: Sequence[Flight], backend: str) -> list[Row]:
    """All together; if that fails, each alone, so that one does not take the others with it."""
    if not flights:
        return []
    try:
        simulator = simulator_of(flights[0].case.variant, backend)
        simulator.reset()
        out = simulator.run(stacked_readings(flights))
        return [_row(flight, {name: out[name][i] for name in OUTPUTS}) for i, flight in enumerate(flights)]
    except Exception as error:
        if len(flights) == 1:
            return [failed(flights[0].case, error)]
        return [row for flight in flights for row in _fly([flight], backend)]


_OF_THREAD = threading.local()
"""Simulators have a state, and a cluster's worker may have several threads."""
MOST_SHEETS = 8


def simulator_of(variant: Variant, backend: str = BACKEND) -> Simulator:
    """Frames of a sheet, kept for this thread. Raises DiagnosisError as loading and compiling do."""
    kept: dict[tuple[Variant, str], Simulator] = _OF_THREAD.__dict__.setdefault("simulators", {})
    if (variant, backend) not in kept:
        while len(kept) >= MOST_SHEETS:
            kept.pop(next(iter(kept)))
        kept[variant, backend] = _loaded(variant, backend)
    return kept[variant, backend]


def _loaded(variant: Variant, backend: str) -> Simulator:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # that there is no compiler is told once, by the process that was asked
        return load_variant(variant).simulator(backend=backend)


def _row(flight: Flight, out: dict[str, Array]) -> Row:
    frames = len(flight.truth)
    cut = {name: values[:frames] for name, values in out.items()}
    for name, values in cut.items():
        finite = np.isfinite(values)
        if not finite.all():
            frame = int(np.argwhere(~finite)[0][0])
            return failed(flight.case, f"`{name}` is not finite in frame {frame}")
    base = _base(flight.case, flight.name, flight.aircraft, flight.start, frames, flight.truth.period)
    return Row(**base, **fault_columns(flight.case, flight.truth.period), **summary(flight, cut))  # type: ignore[arg-type]


def _base(case: Case, flight: str, aircraft: str, start: int, frames: int, period: float) -> dict[str, object]:
    return {
        "run": case.number,
        "sheet": case.variant.label,
        "runs": case.runs.name,
        "flight": flight,
        "aircraft": aircraft,
        "start": start,
        "frames": frames,
        "period": period,
        "seed": case.seed,
        "category": case.category,
    }
