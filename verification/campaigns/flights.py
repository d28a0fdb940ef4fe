"""The flights of a campaign: recordings by name or path, and drawn ones, which are recorded once and kept.

A drawn flight is kept in ``$XDG_CACHE_HOME/saoflow_flights`` (else ``~/.cache/saoflow_flights``), under a name made of
everything that it depends on: the ranges and seeds it is drawn from, the recorder's code and JSBSim's version.
"""

from __future__ import annotations

import ast
import hashlib
import os
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import numpy as np

from saoflow.diagnosis import DiagnosisError, refusal
from saoflow.recordings.parquet_reader import need_pyarrow
from saoflow.whole_file import write_whole
from verification.campaigns.cases import duration_of
from verification.campaigns.plan import INSIDE, DrawnFlights, FlightSet, RecordedFlights
from verification.flights import drawn
from verification.flights.record import JSBSIM_VERSION
from verification.recordings import Recording, load_recording, read_recording, shipped_recordings

NEEDED = ("vg", "vz", "theta", "q", "ax", "az", "z", "alpha_true", "vc_true", "wx_true", "wz_true")
"""Columns of a flight that a run needs."""
_RECORDER = ("autopilot.py", "drawn.py", "plan.py", "record.py")
_REMEMBERED = 12


@dataclass(frozen=True, eq=False)
class Flown:
    """A flight: its name, its aircraft ("" where nothing says it) and its truth."""

    name: str
    aircraft: str
    truth: Recording


def flights_folder() -> Path:
    """Where drawn flights are kept."""
    base = os.environ.get("XDG_CACHE_HOME", "")
    return (Path(base) if os.path.isabs(base) else Path.home() / ".cache") / "saoflow_flights"


def flown(flights: FlightSet, index: int) -> Flown:
    """The flight of a set by its index. Raises DiagnosisError of flights and recordings; E502 for a missing column."""
    if isinstance(flights, DrawnFlights):
        return _remembered_drawn(flights, index)
    return recorded(flights.recordings[index])


@lru_cache(maxsize=_REMEMBERED)
def _remembered_drawn(flights: DrawnFlights, index: int) -> Flown:
    return _kept(flights, index) or record_drawn(flights, index)


@lru_cache(maxsize=_REMEMBERED)
def recorded(name: str) -> Flown:
    """A recording by shipped name or by path."""
    truth = load_recording(name) if name in shipped_recordings() else read_recording(name)
    missing = [column for column in NEEDED if column not in truth]
    if missing:
        raise refusal(
            "E502",
            f"{name}: the recording has no column `{missing[0]}`",
            cause=f"a run needs {', '.join(NEEDED)}",
            remedy="record the flight with `saoflow fly`, which writes the truth beside the inputs",
        )
    aircraft = {"a320": "A320", "787": "787-8"}.get(Path(name).name.split("_")[0], "")
    return Flown(name, aircraft, _only_needed(truth))


def _only_needed(truth: Recording) -> Recording:
    return Recording(NEEDED, tuple(truth[name] for name in NEEDED), truth.period)


# -- drawn flights


def is_kept(flights: DrawnFlights, index: int) -> bool:
    """Whether a drawn flight has been recorded already."""
    return _path(flights, index).is_file()


def record_drawn(flights: DrawnFlights, index: int) -> Flown:
    """Draw and record a flight, and keep it. Raises DiagnosisError E703, E704, E705."""
    plan, truth = drawn.draw_flight(
        (flights.seed, index),
        duration_of(flights, index),
        flights.wind == INSIDE,
        flights.aircraft,
        (flights.cas.low, flights.cas.high),
        (flights.altitude.low, flights.altitude.high),
    )
    found = Flown(f"{flights.name}_{index}", plan.aircraft, _only_needed(truth))
    _keep(found, _path(flights, index))
    return found


def _path(flights: DrawnFlights, index: int) -> Path:
    what = f"{JSBSIM_VERSION} {_recorder_digest()} {flights!r} {index}"
    return flights_folder() / f"{hashlib.sha256(what.encode()).hexdigest()[:40]}.parquet"


@lru_cache(maxsize=1)
def _recorder_digest() -> str:
    """Of the recorder's statements: its comments, its docstrings and its lay-out may change."""
    folder = Path(drawn.__file__).parent
    return hashlib.sha256("\0".join(_statements(folder / name) for name in _RECORDER).encode()).hexdigest()


def _statements(path: Path) -> str:
    tree = ast.parse(path.read_bytes())
    for node in ast.walk(tree):
        body = getattr(node, "body", None)
        if isinstance(body, list):
            kept = [item for item in body if not (isinstance(item, ast.Expr) and isinstance(item.value, ast.Constant))]
            node.body = kept  # type: ignore[attr-defined]
    return ast.dump(tree)


def _keep(flight: Flown, path: Path) -> None:
    """Whole or not at all; a folder that cannot be written to only costs time."""
    pyarrow = need_pyarrow(str(path))
    table = pyarrow.table(dict(zip(flight.truth.names, flight.truth.columns, strict=True)))
    table = table.replace_schema_metadata({"name": flight.name, "aircraft": flight.aircraft})
    sink = pyarrow.BufferOutputStream()
    pyarrow.parquet.write_table(table, sink, compression="zstd")
    try:
        path.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
        write_whole(path, sink.getvalue().to_pybytes())
    except OSError:
        return


def _kept(flights: DrawnFlights, index: int) -> Flown | None:
    """The recorded flight; None if there is none, or none that can be read."""
    path = _path(flights, index)
    if not path.is_file():
        return None
    pyarrow = need_pyarrow(str(path))
    try:
        table = pyarrow.parquet.read_table(path)
        facts = {key.decode(): value.decode() for key, value in (table.schema.metadata or {}).items()}
        columns = tuple(np.asarray(table.column(name).to_numpy(), dtype=np.float64) for name in NEEDED)
        return Flown(facts["name"], facts["aircraft"], Recording(NEEDED, columns))
    except (pyarrow.ArrowException, OSError, KeyError, UnicodeDecodeError, DiagnosisError):
        return None


def content_of(flights: FlightSet) -> str:
    """What the flights of a set depend on beside the campaign's text: a digest."""
    if isinstance(flights, RecordedFlights):
        paths = [name for name in flights.recordings if name not in shipped_recordings()]
        parts = [hashlib.sha256(Path(path).read_bytes()).hexdigest() for path in paths if Path(path).is_file()]
        shipped = [name for name in flights.recordings if name in shipped_recordings()]
        return hashlib.sha256(" ".join([*shipped, *parts]).encode()).hexdigest()
    return hashlib.sha256(f"{JSBSIM_VERSION} {_recorder_digest()}".encode()).hexdigest()
