"""Work spread over processes of this machine: results as they come, no process lost for long, none left behind."""

from __future__ import annotations

import os
import signal
import threading
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from typing import TypeVar

from saoflow.diagnosis import refusal

T = TypeVar("T")
R = TypeVar("R")

AHEAD = 2
"""Items that wait or run for each process: enough to keep it busy, few enough to stop soon."""


def cores() -> int:
    """Processors that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def spread(work: Callable[[T], R], items: Iterable[T], workers: int, lost: Callable[[T], R]) -> Iterator[tuple[T, R]]:
    """Yields (item, ``work(item)``) as they are done; with one worker in this process, in order.

    ``work`` must be importable. A process that dies (out of memory, killed) takes the others with it: a new pool goes
    on, each of the items that were under way is tried alone, and the one that kills its process again gets
    ``lost(item)``. Raises DiagnosisError E808 if processes do not even start.
    """
    if workers <= 1:
        for item in items:
            yield item, work(item)
        return
    source = iter(items)
    while True:
        suspects: list[T] = []
        yield from _until_broken(work, source, workers, suspects)
        if not suspects:
            return
        for item in suspects:
            yield item, _alone(work, item, lost)


def _until_broken(
    work: Callable[[T], R], source: Iterator[T], workers: int, suspects: list[T]
) -> Iterator[tuple[T, R]]:
    """Until the source is empty, or a process dies: then ``suspects`` holds what was under way."""
    pending: dict[Future[R], T] = {}
    with _executor(workers) as pool:
        try:
            while True:
                while len(pending) < AHEAD * workers and not suspects:
                    try:
                        item = next(source)
                    except StopIteration:
                        break
                    try:
                        pending[pool.submit(work, item)] = item
                    except BrokenProcessPool:
                        suspects.append(item)
                if not pending:
                    return
                done, _ = wait(pending, return_when=FIRST_COMPLETED)
                for future in done:
                    item = pending.pop(future)
                    try:
                        result = future.result()
                    except BrokenProcessPool:
                        suspects.append(item)
                        continue
                    yield item, result
        finally:
            pool.shutdown(wait=True, cancel_futures=True)


def _alone(work: Callable[[T], R], item: T, lost: Callable[[T], R]) -> R:
    """Raises DiagnosisError E808 if not even a process starts that could do the work: then no item is to blame."""
    with _executor(1) as pool:
        try:
            pool.submit(_ready, work).result()
        except BrokenProcessPool:
            raise refusal(
                "E808",
                "worker processes do not start",
                cause="a new one died before it had anything to do; what it said stands above",
                remedy="free memory, or run with --workers 1",
            ) from None
        try:
            return pool.submit(work, item).result()
        except BrokenProcessPool:
            return lost(item)


def _ready(work: Callable[[T], R]) -> None:
    """Nothing; that the worker has received it means that it could import the work."""


def _executor(workers: int) -> ProcessPoolExecutor:
    from multiprocessing import get_context

    # Not forked: this process has threads (a progress bar), and a fork would copy their locks.
    return ProcessPoolExecutor(workers, mp_context=get_context("spawn"), initializer=_worker)


def _worker() -> None:
    """Ctrl-C is for the process that was asked; a worker whose parent has gone goes, too."""
    from multiprocessing import parent_process
    from multiprocessing.connection import wait as wait_for

    signal.signal(signal.SIGINT, signal.SIG_IGN)
    parent = parent_process()
    if parent is None:
        return

    def watch() -> None:
        wait_for([parent.sentinel])
        os._exit(1)

    threading.Thread(target=watch, daemon=True).start()
