"""Offsets that level the frames: against the exact optimum of small cases."""

from __future__ import annotations

import itertools
import math

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from saoflow.scheduler.balance import Task, balanced


def dearest(tasks: list[Task], offsets: tuple[int, ...]) -> int:
    load = np.zeros(math.lcm(*(task.every for task in tasks)), dtype=int)
    for task, offset in zip(tasks, offsets, strict=True):
        load[offset :: task.every] += task.cost
    return int(load.max())


def optimum(tasks: list[Task]) -> int:
    return min(dearest(tasks, offsets) for offsets in itertools.product(*(range(task.every) for task in tasks)))


TASKS = st.lists(st.builds(Task, st.sampled_from([1, 2, 3, 4, 6]), st.none(), st.integers(1, 100)), min_size=1, max_size=4)


@settings(max_examples=100, deadline=None)
@given(TASKS)
def test_no_single_move_is_better(tasks: list[Task]) -> None:
    offsets = balanced(tasks)
    assert all(0 <= offset < task.every for task, offset in zip(tasks, offsets, strict=True))
    for i, task in enumerate(tasks):
        for other in range(task.every):
            assert dearest(tasks, offsets) <= dearest(tasks, (*offsets[:i], other, *offsets[i + 1 :]))


def test_mostly_the_optimum() -> None:
    rng = np.random.default_rng(1)
    cases = [
        [Task(int(rng.choice([1, 2, 3, 4, 6])), None, int(rng.integers(1, 101))) for _ in range(rng.integers(1, 5))]
        for _ in range(300)
    ]
    equal = sum(dearest(tasks, balanced(tasks)) == optimum(tasks) for tasks in cases)
    assert equal >= 0.98 * len(cases)


def test_equal_rates_of_two_are_level() -> None:
    tasks = [Task(2, None, 30), Task(2, None, 20), Task(2, None, 10), Task(2, None, 40)]
    assert dearest(tasks, balanced(tasks)) == 50 == optimum(tasks)


def test_what_is_stated_is_kept_and_worked_around() -> None:
    tasks = [Task(2, 0, 5), Task(2, None, 100), Task(4, None, 60), Task(4, 1, 1)]
    offsets = balanced(tasks)
    assert offsets[0] == 0 and offsets[3] == 1 and offsets[1] == 1 and offsets[2] in (0, 2)
