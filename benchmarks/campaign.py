"""A Monte-Carlo campaign, in ratios: ``python benchmarks/campaign.py [--flights 10000]``.

- 10 000 flights of a minute on two processes against the numpy reference, time for a flight's frame;
- two processes against one;
- memory against the number of flights.

Everything in one run; each campaign in a new process. Other programs disturb clocks, so times are processor times:
that of a campaign on two processes is the larger of half of what its workers used (chunks are handed out as workers
become free) and what the process used that hands out and keeps. The clock's ratio of two processes against one stands
beside it; it is the same on a machine that does nothing else.
"""

from __future__ import annotations

import argparse
import json
import os
import resource
import statistics
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from verification.campaigns.plan import FaultMix

NEEDED_REFERENCE, NEEDED_TWO, NEEDED_MEMORY = 500.0, 1.8, 1.1
REFERENCE_FRAMES = 400
PARTS = ("reference", "two", "memory")
"""Against the numpy reference; two processes against one; memory against flights."""
SHORT = 12
"""Seconds of the flights over which memory is measured: the rows of a run are as many as for a long one."""


@dataclass(frozen=True)
class Spent:
    """What one campaign took: seconds by the clock and of processors, and the largest memory [MB]."""

    flights: int
    frames: int
    clock: float
    own: float
    workers: float
    memory: float
    worker_memory: float

    @property
    def on_two(self) -> float:
        """Processor seconds on the longest way through, with two workers."""
        return max(self.workers / 2.0, self.own)

    @property
    def alone(self) -> float:
        """Processor seconds with one."""
        return self.own + self.workers


def main() -> None:
    """Print medians and ratios."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--flights", type=int, default=10_000)
    parser.add_argument(
        "--repeat", type=int, default=3, help="of the reference, and of two processes against one, with a fifth of the flights"
    )
    parser.add_argument("--only", choices=PARTS, action="append", default=[], help="this part; may be repeated")
    parser.add_argument("--one", nargs=3, type=int, metavar=("FLIGHTS", "WORKERS", "SECONDS"), help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.one:
        print(json.dumps(_campaign(*options.one).__dict__))
        return
    parts, few = options.only or PARTS, max(options.flights // 5, 200)
    _measured(min(200, options.flights), 1)  # compiled, before anything is measured
    if "reference" in parts:
        references = [_reference()]
        whole = _measured(options.flights, 2)
        references += [_reference() for _ in range(options.repeat - 1)]
        _against_reference(whole, statistics.median(references))
    if "two" in parts:
        _two_against_one([(_measured(few, 1), _measured(few, 2)) for _ in range(options.repeat)])
    if "memory" in parts:
        _memory([_measured(factor * options.flights // 4, 2, SHORT) for factor in (1, 4, 16)])


def _against_reference(whole: Spent, reference: float) -> None:
    each = whole.on_two / whole.frames
    print(
        f"{whole.flights} flights, {whole.frames} frames: {whole.clock:.1f} s by the clock, {whole.alone:.1f} s of processors"
    )
    print(
        f"numpy reference / campaign on two cores   {1e6 * reference:8.1f} us / {1e6 * each:6.3f} us = "
        f"{reference / each:7.0f}; needed: {NEEDED_REFERENCE:g}"
    )


def _two_against_one(pairs: list[tuple[Spent, Spent]]) -> None:
    one, two = (statistics.median(t) for t in ([p.alone for p, _ in pairs], [p.on_two for _, p in pairs]))
    ratio = statistics.median(a.alone / b.on_two for a, b in pairs)
    clock = statistics.median(a.clock / b.clock for a, b in pairs)
    print(
        f"one process / two, {pairs[0][0].flights} flights          {one:8.2f} s  / {two:6.2f} s  = {ratio:7.2f}; "
        f"needed: {NEEDED_TWO:g} (by the clock {clock:.2f}, load {os.getloadavg()[0]:.1f})"
    )


def _memory(runs: list[Spent]) -> None:
    for run in runs:
        print(f"memory, {run.flights:6d} flights: {run.memory:6.1f} MB, a worker {run.worker_memory:6.1f} MB")
    few, many = runs[-2:]
    ratio = max(many.memory / few.memory, many.worker_memory / few.worker_memory)
    print(f"memory, {many.flights} flights / {few.flights}: {ratio:.2f}; needed: at most {NEEDED_MEMORY:g}")


def _reference() -> float:
    """Processor seconds of the numpy reference for a frame."""
    from verification.flights import load_recording, sensors
    from verification.reference import cmhe_fte

    recorded = sensors(load_recording("a320_wind_350kt_5000ft"), seed=1).inputs()
    few = {name: array[:REFERENCE_FRAMES] for name, array in recorded.items()}
    start = time.process_time()
    cmhe_fte.run(few)
    return (time.process_time() - start) / REFERENCE_FRAMES


def _measured(flights: int, workers: int, seconds: int = 60) -> Spent:
    command = [sys.executable, __file__, "--one", str(flights), str(workers), str(seconds)]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    return Spent(**json.loads(done.stdout))


def _campaign(flights: int, workers: int, seconds: int) -> Spent:
    """In this process and its workers: the shipped Monte-Carlo with so many flights, half of them with faults."""
    from verification.campaigns.metrics import metrics_of
    from verification.campaigns.plan import RecordedFlights
    from verification.campaigns.reader import load_campaign
    from verification.campaigns.run import run_campaign
    from verification.campaigns.store import rows_of

    plan = load_campaign("monte_carlo")
    (recorded,) = plan.flights
    assert isinstance(recorded, RecordedFlights)
    plan = replace(
        plan,
        flights=(replace(recorded, part=float(seconds)),),
        runs=tuple(replace(runs, count=flights // 2, faults=_early(runs.faults, seconds)) for runs in plan.runs),
    )
    start = time.perf_counter()
    with tempfile.TemporaryDirectory() as folder:
        outcome = run_campaign(plan, Path(folder) / "out", workers)
        (metrics,) = metrics_of(rows_of(outcome.results))
    clock = time.perf_counter() - start
    assert metrics.fault_free.runs + metrics.faulty.runs == plan.total
    own, children = resource.getrusage(resource.RUSAGE_SELF), resource.getrusage(resource.RUSAGE_CHILDREN)
    return Spent(
        plan.total,
        plan.total * round(seconds / 0.048),
        clock,
        own.ru_utime + own.ru_stime,
        children.ru_utime + children.ru_stime,
        own.ru_maxrss / 1024.0,
        children.ru_maxrss / 1024.0,
    )


def _early(faults: FaultMix | None, seconds: int) -> FaultMix | None:
    """The faults, in time for a short flight."""
    from verification.campaigns.plan import Range

    return faults and replace(faults, onset=Range(min(10.0, seconds / 3.0), min(30.0, seconds / 2.0)))


if __name__ == "__main__":
    sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
    main()
