"""In which frames things run that run every n-th frame: ``offset: auto`` levels the cost of the frames.

Longest processing time first: the tasks in the order of their cost a run, each at the offset that makes the dearest
frame cheapest, then the sum of the frames' squares least, then the earliest; then each is placed anew among the others
until nothing moves. ``tests/scheduler/test_balance.py`` compares it with the exact optimum of small cases.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

PASSES = 20
"""Of placing every task anew, at most."""

@dataclass(frozen=True, slots=True)
class Task:
    """What runs every ``every`` frames at a cost; ``offset`` None: to be chosen."""

    every: int
    offset: int | None
    cost: int


def balanced(tasks: Sequence[Task]) -> tuple[int, ...]:
    """The offset of every task."""
    load = np.zeros(math.lcm(1, *(task.every for task in tasks)), dtype=np.int64)
    offsets = [task.offset or 0 for task in tasks]
    for task in tasks:
        if task.offset is not None:
            load[task.offset :: task.every] += task.cost
    free = sorted((i for i, task in enumerate(tasks) if task.offset is None), key=lambda i: -tasks[i].cost)
    for i in free:
        offsets[i] = _best(load, tasks[i])
        load[offsets[i] :: tasks[i].every] += tasks[i].cost
    for _ in range(PASSES):
        moved = False
        for i in free:
            task, old = tasks[i], offsets[i]
            load[old :: task.every] -= task.cost
            offsets[i] = _best(load, task)
            load[offsets[i] :: task.every] += task.cost
            moved |= offsets[i] != old
        if not moved:
            break
    return tuple(offsets)


def _best(load: NDArray[np.int64], task: Task) -> int:
    """Where the task makes the dearest frame cheapest, then the sum of squares least, then the earliest."""
    frames = load.reshape(-1, task.every).T  # row k: the frames of offset k
    highest = frames.max(axis=1)
    first = int(highest.argmax())
    second = int(np.delete(highest, first).max(initial=0))
    others = np.where(np.arange(task.every) == first, second, highest[first])
    dearest = np.maximum(highest + task.cost, others)
    growth = 2 * task.cost * frames.sum(axis=1)  # of the sum of squares, up to what is the same for all
    return int(np.lexsort((np.arange(task.every), growth, dearest))[0])
