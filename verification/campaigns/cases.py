"""The runs of a campaign: each by its number, always the same, whatever runs before or beside it.

Runs are numbered sheet by sheet, and within a sheet set by set. What is drawn for a run comes from a random stream of
its own, so that runs can be made one by one in any order and in any process.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np
from numpy.typing import NDArray

from verification.campaigns.plan import (
    CATEGORIES,
    Campaign,
    DrawnFlights,
    FaultMix,
    RecordedFlights,
    RunSet,
    Variant,
)
from verification.flights import Fault
from verification.flights.faults import SENSORS
from verification.recordings import FRAME_PERIOD

SIGNED = ("jamming", "bias", "runaway")
"""Kinds that have a direction: either with the same chance."""
MOST_RUNS = 64
"""Runs of a chunk: a few registers of lanes, and less than a second of work for flights of a minute."""
MOST_FRAMES = 160_000
"""Frames of a chunk, all its runs together: what a process holds at a time, about 40 MB."""
FEWEST = 8
"""Runs of a chunk however long they are: lanes of one register."""


@dataclass(frozen=True)
class Case:
    """One run: a sheet, a flight (or a part of it), a noise seed and the faults.

    ``flight``: its index in the set; ``start`` the first frame flown of it, as a share (0 to 1) of those that leave a
    whole part. ``category``: of Table I, empty for a fault-free run.
    """

    number: int
    variant: Variant
    runs: RunSet
    index: int
    """Of the run in its set."""
    flight: int
    start: float
    seed: int
    faults: tuple[Fault, ...]
    category: str


@dataclass(frozen=True)
class Chunk:
    """Runs ``first`` to ``stop`` - 1, all of one sheet and one set, that are flown together."""

    number: int
    first: int
    stop: int

    def __len__(self) -> int:
        return self.stop - self.first


class Cases:
    """The runs of a campaign, and the chunks in which they are flown."""

    def __init__(self, campaign: Campaign) -> None:
        self.campaign = campaign

    def __len__(self) -> int:
        return self.campaign.total

    def case(self, number: int) -> Case:
        """The run of that number, 0 to len(self) - 1."""
        sheet, rest = divmod(number, self.campaign.runs_a_sheet)
        which = 0
        while rest >= self.campaign.runs[which].count:
            rest -= self.campaign.runs[which].count
            which += 1
        runs = self.campaign.runs[which]
        generator = np.random.default_rng([self.campaign.seed, 1 + which, rest])
        seed = int(generator.integers(2**31))
        start = float(generator.random())
        faults: tuple[Fault, ...] = ()
        category = ""
        if runs.faults is not None:
            faults, category = _drawn_faults(self.campaign.seed, which, runs, runs.faults, rest, generator)
        flight = self._flight_of(runs, rest)
        return Case(number, self.campaign.sheets[sheet], runs, rest, flight, start, seed, faults, category)

    def _flight_of(self, runs: RunSet, index: int) -> int:
        """Flights in order of length, each as often as any other: neighbours among the runs are of like length."""
        available = self.flight_count(runs.flights)
        return (
            index * available // runs.count
            if runs.count >= available
            else (2 * index + 1) * available // (2 * runs.count)
        )

    def flight_count(self, name: str) -> int:
        """Flights of a set."""
        flights = self.campaign.flight_set(name)
        return flights.count if isinstance(flights, DrawnFlights) else len(flights.recordings)

    @cached_property
    def chunks(self) -> tuple[Chunk, ...]:
        """All chunks, in order of their runs; the same on every machine."""
        return tuple(self._chunks())

    def _chunks(self) -> Iterator[Chunk]:
        number = first = 0
        for _ in self.campaign.sheets:
            for runs in self.campaign.runs:
                stop = first + runs.count
                while first < stop:
                    size = self._chunk_size(runs, stop - first, runs.count - (stop - first))
                    yield Chunk(number, first, first + size)
                    number, first = number + 1, first + size

    def _chunk_size(self, runs: RunSet, left: int, index: int) -> int:
        size = 1
        while size < min(left, MOST_RUNS):
            frames = self.frames_about(runs, index + size)
            if size >= FEWEST and (size + 1) * frames > MOST_FRAMES:
                break
            size += 1
        return size

    def frames_about(self, runs: RunSet, index: int) -> int:
        """Frames of a run, without looking at its flight: of a drawn flight or a part exactly."""
        flights = self.campaign.flight_set(runs.flights)
        if isinstance(flights, DrawnFlights):
            return round(duration_of(flights, self._flight_of(runs, index)) / FRAME_PERIOD) + 1
        return round((flights.part or 90.0) / FRAME_PERIOD)


def duration_of(flights: DrawnFlights, index: int) -> float:
    """[s], log-uniform, in strata of equal probability: the flights of a set are in order of length."""
    low, high = flights.duration.low, flights.duration.high
    share = (index + np.random.default_rng([flights.seed, 7, index]).random()) / flights.count
    return round(float(low * (high / low) ** share), 3)


def part_of(flights: RecordedFlights, frames: int, start: float) -> tuple[int, int]:
    """First frame and number of frames of a run on a recording of so many ``frames``."""
    if flights.part is None:
        return 0, frames
    wanted = min(frames, round(flights.part / FRAME_PERIOD))
    return min(int(start * (frames - wanted + 1)), frames - wanted), wanted


# -- faults


def _drawn_faults(
    seed: int, which: int, runs: RunSet, mix: FaultMix, index: int, generator: np.random.Generator
) -> tuple[tuple[Fault, ...], str]:
    hit = _sensors_hit(seed, which, runs, mix, index, generator)
    faults = []
    for place, sensor in enumerate(SENSORS):
        kind = _shuffled(len(mix.kinds), (seed, which, 11 + place, index // len(mix.kinds)))[index % len(mix.kinds)]
        fault = _drawn_fault(mix, mix.kinds[kind], sensor, hit[place], generator)
        if fault is not None:
            faults.append(fault)
    return tuple(faults), category_of(len(hit[0]), len(hit[1]))


def category_of(alpha: int, vc: int) -> str:
    """Table I, by the number of faulty sensors of each kind."""
    return CATEGORIES[(alpha == 3) + 2 * (vc == 3)]


def _sensors_hit(
    seed: int, which: int, runs: RunSet, mix: FaultMix, index: int, generator: np.random.Generator
) -> tuple[tuple[int, ...], tuple[int, ...]]:
    """Numbers of the faulty AOA and VCAS sensors."""
    if mix.weights is None:
        named = [name.rsplit("_", 1) for name in mix.sensors]
        alpha, vc = (tuple(sorted(int(i) for s, i in named if s == sensor)) for sensor in SENSORS)
        return alpha, vc
    category = int(_categories(seed, which, runs.count, mix.weights)[index])
    pairs = [(a, v) for a in range(4) for v in range(4) if (a, v) != (0, 0) and (a == 3) + 2 * (v == 3) == category]
    numbers = pairs[int(generator.integers(len(pairs)))]
    alpha, vc = (tuple(sorted(int(i) + 1 for i in generator.permutation(3)[:n])) for n in numbers)
    return alpha, vc


@lru_cache(maxsize=8)
def _categories(seed: int, which: int, count: int, weights: tuple[int, int, int, int]) -> NDArray[np.int8]:
    """The category of every run: in the given shares (the largest remainders get what is left), in drawn order."""
    exact = [count * weight / sum(weights) for weight in weights]
    numbers = [int(share) for share in exact]
    by_remainder = sorted(range(4), key=lambda c: (numbers[c] - exact[c], c))
    for c in by_remainder[: count - sum(numbers)]:
        numbers[c] += 1
    categories = np.repeat(np.arange(4, dtype=np.int8), numbers)
    return np.random.default_rng([seed, which, 10]).permutation(categories)


@lru_cache(maxsize=64)
def _shuffled(count: int, seed: tuple[int, ...]) -> tuple[int, ...]:
    return tuple(int(i) for i in np.random.default_rng(seed).permutation(count))


def _drawn_fault(
    mix: FaultMix, kind: str, sensor: str, which: tuple[int, ...], generator: np.random.Generator
) -> Fault | None:
    """Draws the same numbers whether a sensor is hit or not, so that one fault does not change the other."""
    onset = mix.onset.low + (mix.onset.high - mix.onset.low) * float(generator.random())
    negative = generator.random() < 0.5
    shares = {field: float(generator.random()) for field in ("amplitude", "rate", "frequency")}
    if not which:
        return None
    values: dict[str, float] = {}
    for level in mix.levels:
        if (level.kind, level.sensor) == (kind, sensor):
            value = level.low * (level.high / level.low) ** shares[level.field]
            signed = negative and kind in SIGNED and level.field != "frequency"
            values[level.field] = -value if signed else value
    return Fault(kind, sensor, which, onset=round(onset, 3), **values)
