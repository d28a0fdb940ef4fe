"""Two ways in which GCC schedules a straight line under register pressure (haifa-sched.cc, -fsched-pressure).

``written_order``: SCHED_PRESSURE_WEIGHTED, Arm's. Of what is ready, first what adds least to the excess over the registers,
judged at the highest pressure between here and its place in the written order; then what has the longest way to go.

``model_order``: SCHED_PRESSURE_MODEL, PowerPC's. First an order is made that keeps few values alive; what exceeds the highest
pressure of that order costs, unless it has so much longer a way to go that the cost is worth its cycles.
"""

from __future__ import annotations

from bisect import bisect_left, insort

import numpy as np

from saoflow.targets.straight_line import WINDOW, Alive, Issue, StraightLine

COST = 40
"""Cycles that a value too many counts as: a load and a store, 10 each in GCC, of two single registers."""


def written_order(line: StraightLine) -> list[int]:
    """Places of the units in their new order: pressure judged along the written order."""
    count = len(line)
    issue, alive = Issue(line), Alive(line)
    net = [len(made) for made in line.made]
    last = {a: found[-1] for a, found in line.ending.items()}
    for k in last.values():
        net[k] -= 1
    done = [False] * count
    order: list[int] = []
    oldest = 0
    while len(order) < count:
        able = [k for k in issue.able() if k < oldest + WINDOW]
        if not able:
            issue.wait()
            continue
        pressure = most = alive.count
        at, found = oldest, able[0]
        best: tuple[int, ...] = (1 << 30,)
        for k in able:
            for j in range(at, k):
                pressure += net[j]
                most = max(most, pressure)
            at = k
            added = max(0, most + alive.change[k] - line.registers) - max(0, most - line.registers)
            late = issue.late(k)
            key = (added * COST + late, late, -line.height[k], k in issue.last, -len(line.after[k]), -line.timings[k].latency)
            if key < best:
                best, found = key, k
        if issue.late(found):
            issue.wait()
            continue
        issue.take(found)
        alive.take(found)
        order.append(found)
        done[found] = True
        net[found] = 0
        for a in line.read[found]:
            if last.get(a) == found and alive.readers[a]:
                last[a] = max(alive.readers[a])
                net[last[a]] -= 1
        while oldest < count and done[oldest]:
            oldest += 1
    return order


def model_order(line: StraightLine) -> list[int]:
    """Places of the units in their new order: pressure judged along an order made to keep few values alive."""
    model = _narrow_order(line)
    count = len(line)
    place = [0] * count
    for p, k in enumerate(model):
        place[k] = p
    issue, alive = Issue(line), Alive(line)
    pressure = _pressures(line, model, place)
    ends = {a: max(place[k] for k in found) for a, found in line.ending.items()}
    most = int(pressure.max())
    base = max(most, line.registers)
    done = [False] * count
    order: list[int] = []
    here = 0
    while len(order) < count:
        highest = int(np.argmax(pressure[here:])) + here
        limit = int(pressure[highest])
        able = issue.able(place)
        costs = [_excess(alive.count, alive.change[k], place[k], highest, limit, base) for k in able]
        urgent = [line.height[k] - issue.late(k) for k in able]
        cheap = max((u - c for u, c in zip(urgent, costs, strict=True) if c <= 0), default=0)
        found = able[0]
        best: tuple[int, ...] = (1 << 30,)
        for k, cost, u in zip(able, costs, urgent, strict=True):
            late = issue.late(k)
            cost = max(0, min(cost, cost + cheap - u)) if cost > 0 else 0
            key = (cost + late, late, -line.height[k], k in issue.last, place[k])
            if key < best:
                best, found = key, k
        if issue.late(found):
            issue.wait()
            continue
        issue.take(found)
        p = place[found]
        done[p] = True
        order.append(found)
        _brought_forward(line, alive, found, place, here, ends, pressure)
        alive.take(found)
        while here < count and done[here]:
            here += 1
    return order


def _excess(alive: int, change: int, place: int, highest: int, limit: int, base: int) -> int:
    """What a unit adds beyond the highest pressure of the model order (baseECC)."""
    if change < 0 and place >= highest:
        return max(base, alive + change) - max(base, alive)
    if change > 0:
        after = limit + change if place > highest else alive + change
        if after > limit:
            return max(0, after - base)
    return 0


def _pressures(line: StraightLine, model: list[int], place: list[int]) -> np.ndarray:
    """Reals alive before each place of the model order, and at its end."""
    change = np.zeros(len(line) + 1, dtype=int)
    for p, k in enumerate(model):
        change[p + 1] += len(line.made[k])
    for found in line.ending.values():
        change[max(place[k] for k in found) + 1] -= 1
    return line.alive + np.cumsum(change)


def _brought_forward(
    line: StraightLine, alive: Alive, k: int, place: list[int], here: int, ends: dict[int, int], pressure: np.ndarray
) -> None:
    """Pressure along what is left of the model order, once a unit has been taken out of its place and put first."""
    p = place[k]
    if p > here:
        pressure[here + 1 : p + 1] += len(line.made[k])
    for a in line.read[k]:
        if ends.get(a) == p:
            left = [place[j] for j in alive.readers[a] if j != k]
            ends[a] = max(left, default=-1)
            pressure[max(ends[a], here) + 1 : p + 1] -= 1


def _narrow_order(line: StraightLine) -> list[int]:
    """An order that keeps few values alive: what adds none first, else what finishes what was begun (the model schedule)."""
    alive, work = Alive(line), _Work(line)
    waits = [len(found) for found in line.before]
    order: list[int] = []
    while work.first is not None:
        chosen = fallback = -1
        for k in work.best():
            if waits[k]:
                if fallback < 0 and work.rank[k] == work.rank[work.first] and alive.change[k] < 0:
                    fallback = k
            elif alive.change[k] <= 0:
                chosen = k
                break
        if chosen < 0:
            chosen = fallback if fallback >= 0 else work.first
        if waits[chosen]:
            work.promote(chosen)
            continue
        work.finish(chosen)
        order.append(chosen)
        alive.take(chosen)
        for j in line.after[chosen]:
            waits[j] -= 1
    return order


class _Work:
    """Units that could come next or soon: first the highest rank, then the longest way through, then the most of it behind."""

    def __init__(self, line: StraightLine) -> None:
        self.line = line
        self.rank = [0] * len(line)
        self._depth = [0] * len(line)
        self._listed = [not found for found in line.before]
        self._done = [False] * len(line)
        self._top = 1
        self._list = sorted((self._key(k), k) for k in range(len(line)) if self._listed[k])

    def _key(self, k: int) -> tuple[int, ...]:
        through = self._depth[k] + self.line.steps[k]
        return -self.rank[k], -through, -self._depth[k], -self.line.height[k], k

    @property
    def first(self) -> int | None:
        """The unit that comes before all others in the list."""
        return self._list[0][1] if self._list else None

    def best(self) -> list[int]:
        """The first units of the list."""
        return [k for _, k in self._list[:WINDOW]]

    def _remove(self, k: int) -> None:
        if self._listed[k]:
            del self._list[bisect_left(self._list, (self._key(k), k))]

    def _insert(self, k: int) -> None:
        insort(self._list, (self._key(k), k))

    def finish(self, k: int) -> None:
        """Unit ``k`` has its place: what reads its result moves up."""
        self._remove(k)
        self._done[k] = True
        for j in self.line.after[k]:
            if self._depth[j] <= self._depth[k]:
                self._remove(j)
                self._depth[j] = self._depth[k] + 1
                self._listed[j] = True
                self._insert(j)

    def promote(self, k: int) -> None:
        """Give a unit the highest rank, and all that it waits for a higher one still."""
        self._give(k, self._top)
        self._top += 1
        waiting = [k]
        while waiting:
            for j in self.line.before[waiting.pop()]:
                if self.rank[j] != self._top and not self._done[j]:
                    self._give(j, self._top)
                    if not self._listed[j]:
                        waiting.append(j)
        self._top += 1

    def _give(self, k: int, rank: int) -> None:
        self._remove(k)
        self.rank[k] = rank
        if self._listed[k]:
            self._insert(k)
