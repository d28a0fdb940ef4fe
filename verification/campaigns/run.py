"""A whole campaign: check, record what is missing, fly chunk by chunk, put the table together."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from saoflow.diagnosis import Diagnosis, DiagnosisError
from verification.campaigns.cases import Cases, Chunk
from verification.campaigns.check import check_campaign, missing_flights
from verification.campaigns.cluster import Cluster
from verification.campaigns.fingerprint import fingerprint
from verification.campaigns.flights import record_drawn
from verification.campaigns.plan import Campaign, DrawnFlights
from verification.campaigns.pool import cores, spread
from verification.campaigns.row import Row
from verification.campaigns.store import Store
from verification.campaigns.work import failed, fly_chunk

Progress = Callable[[str, int, int], None]
"""Called with what is being done, how much of it is done, and how much there is."""


@dataclass(frozen=True)
class Outcome:
    """Where the results of a campaign are, and how they came about."""

    results: Path
    runs: int
    flown: int
    """Runs flown now; the others were there."""
    warnings: tuple[Diagnosis, ...]


def run_campaign(
    campaign: Campaign,
    folder: str | os.PathLike[str],
    workers: int | None = None,
    dask: str | None = None,
    progress: Progress | None = None,
) -> Outcome:
    """Run a campaign into ``folder``, or go on with it there. ``workers``: processes, by default one a core.

    The results have the same bytes however often it was interrupted, however many workers there are and whatever
    machine of one kind they run on. Raises DiagnosisError as reading, checking and :class:`Store` do.
    """
    tell = progress or (lambda stage, done, total: None)
    processes = cores() if workers is None else workers
    cluster = Cluster(dask) if dask is not None else None
    try:
        found = check_campaign(campaign)
        with Store(folder, campaign.name, fingerprint(campaign)) as store:
            if cluster is None:
                _record(campaign, processes, tell)
            flown = _fly(campaign, store, processes, cluster, tell)
            results = store.finish(Cases(campaign).chunks)
    finally:
        if cluster is not None:
            cluster.close()
    return Outcome(results, campaign.total, flown, tuple(found))


def _record(campaign: Campaign, processes: int, tell: Progress) -> None:
    """Flights that are not kept yet. One that cannot be flown is told by its runs, later."""
    missing = sorted(missing_flights(campaign), key=lambda item: -item[1])  # the longest first
    if not missing:
        return
    tell("recording flights", 0, len(missing))
    for done, _ in enumerate(spread(_recorded, missing, min(processes, len(missing)), lambda item: None), start=1):
        tell("recording flights", done, len(missing))


def _recorded(item: tuple[DrawnFlights, int]) -> None:
    try:
        record_drawn(*item)
    except DiagnosisError:
        return


def _fly(campaign: Campaign, store: Store, processes: int, cluster: Cluster | None, tell: Progress) -> int:
    cases = Cases(campaign)
    total = len(cases)
    left = [chunk for chunk in cases.chunks if not store.has(chunk)]
    done = before = total - sum(map(len, left))
    tell("flying", done, total)
    work, lost = partial(fly_chunk, campaign), partial(_lost, campaign)
    results: Iterator[tuple[Chunk, list[Row]]]
    if cluster is not None:
        results = cluster.spread(work, left, lost)
    else:
        results = spread(work, left, min(processes, max(len(left), 1)), lost)
    for chunk, rows in results:
        store.keep(chunk, rows)
        done += len(chunk)
        tell("flying", done, total)
    return total - before


def _lost(campaign: Campaign, chunk: Chunk) -> list[Row]:
    """The rows of a chunk that twice took its process with it."""
    cases = Cases(campaign)
    numbers = range(chunk.first, chunk.stop)
    return [failed(cases.case(number), "its process was killed, twice (out of memory?)") for number in numbers]
