"""The metrics of paper 004, VI-B, of groups of runs.

With "AOA" and "VCAS" told apart, as its Table IV does:

- FAR: of the fault-free runs, those in which a sensor of the kind was confirmed faulty;
- MDR: of the faulty runs, those in which at least one faulty sensor of the kind was not confirmed;
- FIR: of the faulty runs, those in which at least one healthy sensor of the kind was confirmed (or a faulty one before
  its fault);
- detection delay of a run: from the onset of the fault to the confirmation of the last faulty sensor of the kind;
  largest and mean over the runs in which all were confirmed;
- absolute errors: the largest of all frames; the mean over the runs of each run's mean. After the start-up. V_c
  without the runs of categories III and IV, since the paper leaves those configurations out; they stand apart.

Runs that failed count nowhere but in ``failed``.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import asdict, dataclass, field

from verification.campaigns.plan import CATEGORIES
from verification.campaigns.row import Row
from verification.flights import KINDS
from verification.flights.faults import SENSORS

FAST_KINDS = ("bias", "oscillation", "jamming", "non_return_to_zero")
FAST_RATE = {"alpha": 2.0, "vc": 10.0}
"""[deg/s], [kt/s]: runaways that are faster count among the fast faults."""


@dataclass(frozen=True)
class Spread:
    """Number, largest and mean of some values; NaN of none."""

    count: int
    largest: float
    mean: float


@dataclass(frozen=True)
class Figures:
    """One kind of sensor over a group of runs. Counts are of runs; delays in s, errors in deg or kt."""

    hit: int
    """With faulty sensors of the kind."""
    missed: int
    detectable: int
    """With a fault that must be found; see `detectable`."""
    detectable_missed: int
    wrong: int
    delay: Spread
    fast_delay: Spread
    """Over the detectable faults that are fast: bias, oscillation, jamming, non-return to zero, fast runaways."""
    error: tuple[float, float]
    """Largest and mean."""
    error_lost: tuple[float, float]
    """Of V_c in configurations III and IV."""


@dataclass(frozen=True)
class Group:
    """Runs that belong together."""

    name: str
    runs: int
    failed: int
    alpha: Figures
    vc: Figures

    def figures(self, sensor: str) -> Figures:
        """Of "alpha" or "vc"."""
        return self.alpha if sensor == "alpha" else self.vc


@dataclass(frozen=True)
class SheetMetrics:
    """One sheet of a campaign: its runs in groups. All groups but the two "beyond" have winds inside the bounds."""

    sheet: str
    fault_free: Group
    faulty: Group
    fault_free_beyond: Group
    faulty_beyond: Group
    categories: tuple[Group, ...]
    kinds: tuple[Group, ...]
    """By kind of fault and sensor: "bias alpha"."""
    failures: tuple[tuple[int, str], ...]
    """The first runs that failed, and why."""


MOST_FAILURES = 20


def metrics_of(rows: Iterable[Row]) -> tuple[SheetMetrics, ...]:
    """The metrics of every sheet, in order of their first runs. Rows are looked at one by one and not kept."""
    sheets: dict[str, _Sheet] = {}
    for row in rows:
        sheets.setdefault(row.sheet, _Sheet(row.sheet)).add(row)
    return tuple(sheet.metrics() for sheet in sheets.values())


def share(part: int, whole: int) -> float:
    """In percent; NaN of nothing."""
    return 100.0 * part / whole if whole else math.nan


def is_fast(row: Row, sensor: str) -> bool:
    """Whether a fault is one that shows at once."""
    if sensor == "alpha":
        kind, rate = row.alpha_kind, row.alpha_rate
    else:
        kind, rate = row.vc_kind, row.vc_rate
    return kind in FAST_KINDS or (kind == "runaway" and abs(rate) > FAST_RATE[sensor])


def is_detectable(row: Row, sensor: str) -> bool:
    """Whether the fault of a kind of sensor must be found."""
    return row.alpha_detectable if sensor == "alpha" else row.vc_detectable


def to_dict(sheet: SheetMetrics) -> dict[str, object]:
    """For JSON: NaN is None."""
    return {key: _plain(value) for key, value in asdict(sheet).items()}


def _plain(value: object) -> object:
    if isinstance(value, dict):
        return {key: _plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


# -- adding up


@dataclass
class _Adding:
    count: int = 0
    largest: float = math.nan
    total: float = 0.0

    def add(self, value: float, largest: float | None = None) -> None:
        if math.isnan(value):
            return
        top = value if largest is None else largest
        self.count += 1
        self.total += value
        self.largest = top if math.isnan(self.largest) else max(self.largest, top)

    def spread(self) -> Spread:
        return Spread(self.count, self.largest, self.total / self.count if self.count else math.nan)

    def pair(self) -> tuple[float, float]:
        spread = self.spread()
        return spread.largest, spread.mean


@dataclass
class _Figures:
    sensor: str
    hit: int = 0
    missed: int = 0
    detectable: int = 0
    detectable_missed: int = 0
    wrong: int = 0
    delay: _Adding = field(default_factory=_Adding)
    fast_delay: _Adding = field(default_factory=_Adding)
    error: _Adding = field(default_factory=_Adding)
    error_lost: _Adding = field(default_factory=_Adding)

    def add(self, row: Row) -> None:
        sensor = self.sensor
        must, missed = is_detectable(row, sensor), row.missed(sensor)
        self.hit += bool(row.hit(sensor))
        self.missed += missed
        self.detectable += must
        self.detectable_missed += must and missed
        self.wrong += row.wrong(sensor)
        self.delay.add(row.delay(sensor))
        if must and is_fast(row, sensor):
            self.fast_delay.add(row.delay(sensor))
        if sensor == "alpha":
            self.error.add(row.alpha_error_mean, row.alpha_error_max)
        elif row.category not in ("III", "IV"):
            self.error.add(row.vc_error_mean, row.vc_error_max)
        if sensor == "vc":
            self.error_lost.add(row.vc_error_mean_lost, row.vc_error_max_lost)

    def figures(self) -> Figures:
        return Figures(
            self.hit,
            self.missed,
            self.detectable,
            self.detectable_missed,
            self.wrong,
            self.delay.spread(),
            self.fast_delay.spread(),
            self.error.pair(),
            self.error_lost.pair(),
        )


class _Group:
    def __init__(self, name: str, belongs: Callable[[Row], bool]) -> None:
        self.name, self.belongs = name, belongs
        self.runs = self.failed = 0
        self.by_sensor = {sensor: _Figures(sensor) for sensor in SENSORS}

    def add(self, row: Row) -> None:
        if not self.belongs(row):
            return
        if row.failure:
            self.failed += 1
            return
        self.runs += 1
        for figures in self.by_sensor.values():
            figures.add(row)

    def group(self) -> Group:
        alpha, vc = (figures.figures() for figures in self.by_sensor.values())
        return Group(self.name, self.runs, self.failed, alpha, vc)


class _Sheet:
    def __init__(self, sheet: str) -> None:
        self.sheet = sheet
        self.failures: list[tuple[int, str]] = []
        inside, beyond = _inside, _beyond
        self.groups = [
            _Group("fault-free", lambda r: not r.category and inside(r)),
            _Group("faulty", lambda r: bool(r.category) and inside(r)),
            _Group("fault-free, wind beyond the bounds", lambda r: not r.category and beyond(r)),
            _Group("faulty, wind beyond the bounds", lambda r: bool(r.category) and beyond(r)),
        ]
        self.categories = [_Group(c, lambda r, c=c: r.category == c and inside(r)) for c in CATEGORIES]  # type: ignore[misc]
        self.kinds = [_Group(f"{k} {s}", _has(k, s)) for s in SENSORS for k in KINDS]

    def add(self, row: Row) -> None:
        for group in (*self.groups, *self.categories, *self.kinds):
            group.add(row)
        if row.failure and len(self.failures) < MOST_FAILURES:
            self.failures.append((row.run, row.failure))

    def metrics(self) -> SheetMetrics:
        fault_free, faulty, free_beyond, faulty_beyond = (group.group() for group in self.groups)
        return SheetMetrics(
            self.sheet,
            fault_free,
            faulty,
            free_beyond,
            faulty_beyond,
            _groups(self.categories),
            _groups(self.kinds),
            tuple(self.failures),
        )


def _groups(groups: Sequence[_Group]) -> tuple[Group, ...]:
    return tuple(group.group() for group in groups)


def _inside(row: Row) -> bool:
    """A run that failed before its wind was known counts among those inside."""
    return row.wind_inside or bool(row.failure)


def _beyond(row: Row) -> bool:
    return not row.wind_inside and not row.failure


def _has(kind: str, sensor: str) -> Callable[[Row], bool]:
    def belongs(row: Row) -> bool:
        return _inside(row) and (row.alpha_kind if sensor == "alpha" else row.vc_kind) == kind

    return belongs
