"""What a campaign is: values only, as read from its file. `reader` reads them, `cases` makes runs of them."""

from __future__ import annotations

import hashlib
import json
from dataclasses import asdict, dataclass

from verification.flights import KINDS, TABLE_II

CATEGORIES = ("I", "II", "III", "IV")
"""Paper 004, Table I: fewer than three faulty AOA and VCAS sensors; all AOA; all VCAS; all of both."""

INSIDE, BEYOND = "inside", "beyond"
"""Winds of drawn flights: inside the assumed bounds in every sample, or not."""


@dataclass(frozen=True)
class Range:
    """From ``low`` to ``high``, both included."""

    low: float
    high: float


@dataclass(frozen=True)
class DrawnFlights:
    """``count`` flights drawn by ``seed`` and recorded with JSBSim; see `verification.flights.drawn`.

    ``duration`` [s], log-uniform; ``cas`` [kt] and ``altitude`` [ft] where they start, uniform and inside what the
    aircraft can hold; ``wind`` :data:`INSIDE` or :data:`BEYOND` the assumed bounds.
    """

    name: str
    count: int
    seed: int
    aircraft: tuple[str, ...]
    duration: Range
    cas: Range
    altitude: Range
    wind: str


@dataclass(frozen=True)
class RecordedFlights:
    """Recordings with truth: shipped ones by name, others by path. ``part`` [s]: a run flies so much of one, from a
    drawn frame on; None: all of it.
    """

    name: str
    recordings: tuple[str, ...]
    part: float | None


FlightSet = DrawnFlights | RecordedFlights


@dataclass(frozen=True)
class Level:
    """The range of one number of a fault: kind, sensor, field of `Fault`, lowest, highest (deg, kt, deg/s, kt/s, Hz, 1)."""

    kind: str
    sensor: str
    field: str
    low: float
    high: float


LEVELS = tuple(Level(*row) for row in TABLE_II)
"""Paper 004, Table II."""


@dataclass(frozen=True)
class FaultMix:
    """How the faults of a set of runs are drawn.

    ``weights``: shares of Table I's categories I to IV; or ``sensors``: exactly these are hit ("alpha_1", "vc_3").
    ``kinds``: equally often each. ``levels``: log-uniform. ``onset`` [s], uniform.
    """

    weights: tuple[int, int, int, int] | None
    sensors: tuple[str, ...]
    kinds: tuple[str, ...] = KINDS
    onset: Range = Range(10.0, 30.0)
    levels: tuple[Level, ...] = LEVELS


@dataclass(frozen=True)
class RunSet:
    """``count`` runs over the flights of one set, fault-free or with faults."""

    name: str
    flights: str
    count: int
    faults: FaultMix | None


@dataclass(frozen=True)
class Variant:
    """A sheet (a shipped name or a path) with parameters of its own: pairs of name and text.

    ``unlimited``: flown even if it exceeds its budget.
    """

    sheet: str
    settings: tuple[tuple[str, str], ...] = ()
    unlimited: bool = False

    @property
    def label(self) -> str:
        """``cmhe_fte``, or ``cmhe_fte[n_QP=3]``."""
        if not self.settings:
            return self.sheet
        return f"{self.sheet}[{', '.join(f'{name}={text}' for name, text in self.settings)}]"


@dataclass(frozen=True)
class Campaign:
    """A whole campaign. Every sheet flies every run, with the same noise and the same faults."""

    name: str
    doc: str
    seed: int
    sheets: tuple[Variant, ...]
    flights: tuple[FlightSet, ...]
    runs: tuple[RunSet, ...]

    def flight_set(self, name: str) -> FlightSet:
        """The set of flights of that name."""
        return next(flights for flights in self.flights if flights.name == name)

    @property
    def runs_a_sheet(self) -> int:
        """How many runs each sheet flies."""
        return sum(runs.count for runs in self.runs)

    @property
    def total(self) -> int:
        """How many runs there are."""
        return len(self.sheets) * self.runs_a_sheet

    def content(self) -> str:
        """Everything that the results depend on, but sheets, recordings and recorder, as text; the doc left out."""
        facts = asdict(self)
        facts.pop("doc")
        return json.dumps(facts, sort_keys=True)

    @property
    def digest(self) -> str:
        """Of :meth:`content`."""
        return hashlib.sha256(self.content().encode()).hexdigest()
