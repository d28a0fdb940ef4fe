"""A straight line of instructions to be scheduled: what waits for what, and what each does to the number of reals alive."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass

from saoflow.scheduler.program import Operation
from saoflow.targets.instructions import Machine
from saoflow.targets.target import Timing

WINDOW = 100
"""How many instructions that nothing holds back are compared (GCC keeps at most 100 in its ready list)."""


@dataclass(frozen=True, slots=True)
class Unit:
    """What becomes one instruction: an operation, or a sum with the product that it takes up."""

    operations: tuple[Operation, ...]
    kind: Machine
    reads: frozenset[int]
    """All values, booleans too."""
    results: tuple[int, ...]


class StraightLine:
    """The units of a line; ``made`` and ``read``: reals alone; ``ending``: the readers of what dies in the line."""

    def __init__(
        self,
        units: Sequence[Unit],
        timings: Mapping[Machine, Timing],
        width: int,
        registers: int,
        alive: int,
        reals: Callable[[Iterable[int]], set[int]],
        left: Mapping[int, int],
    ) -> None:
        self.width, self.registers, self.alive = width, registers, alive
        self.timings = [timings[u.kind] for u in units]
        self.read = [reals(u.reads) for u in units]
        self.made = [[r for r in reals(u.results) if left.get(r, 0)] for u in units]
        writer = {r: k for k, u in enumerate(units) for r in u.results}
        self.after: list[list[int]] = [[] for _ in units]
        self.before: list[list[int]] = [[] for _ in units]
        readers: dict[int, list[int]] = {}
        for k, u in enumerate(units):
            for a in u.reads:
                if writer.get(a, k) < k:
                    self.after[writer[a]].append(k)
                    self.before[k].append(writer[a])
            for a in self.read[k]:
                readers.setdefault(a, []).append(k)
        self.ending = {a: found for a, found in readers.items() if left[a] == len(found)}
        self.height = [t.latency for t in self.timings]
        """Cycles of the longest way to the end."""
        self.steps = [0] * len(units)
        """Instructions on the longest way to the end."""
        for k in range(len(units) - 1, -1, -1):
            for j in self.after[k]:
                self.steps[k] = max(self.steps[k], self.steps[j] + 1)
            self.height[k] += max((self.height[j] for j in self.after[k]), default=0)

    def __len__(self) -> int:
        return len(self.made)


class Alive:
    """How many reals are alive as units of a line come one by one, and by how many each next one would change it."""

    def __init__(self, line: StraightLine) -> None:
        self.line = line
        self.count = line.alive
        self.readers = {a: set(found) for a, found in line.ending.items()}
        self.change = [len(made) for made in line.made]
        for found in line.ending.values():
            if len(found) == 1:
                self.change[found[0]] -= 1

    def take(self, k: int) -> None:
        """Unit ``k`` comes next."""
        self.count += self.change[k]
        for a in self.line.read[k]:
            found = self.readers.get(a)
            if found is not None:
                found.discard(k)
                if len(found) == 1:
                    (only,) = found
                    self.change[only] -= 1


class Issue:
    """Cycle by cycle, which units could issue: the rest of a list scheduler."""

    def __init__(self, line: StraightLine) -> None:
        self.line = line
        self.waits = [len(found) for found in line.before]
        self.ready = [k for k in range(len(line)) if not self.waits[k]]
        self.tick = [0] * len(line)
        self.now = 0
        self.last: frozenset[int] = frozenset()
        """What reads the result of the unit before."""
        self._issued = 0
        self._free: dict[str, int] = {}

    def able(self, order: Sequence[int] | None = None) -> list[int]:
        """Units whose operands will come and whose functional unit is free, in the order of ``order``; time goes on until there is one."""
        while True:
            if self._issued >= self.line.width:
                self.wait()
            found = [k for k in self.ready if self._free.get(self.line.timings[k].unit, 0) <= self.now]
            if found:
                found.sort(key=None if order is None else order.__getitem__)
                return found[:WINDOW]
            self.wait()

    def late(self, k: int) -> int:
        """Cycles until the operands of a unit are there."""
        return max(0, self.tick[k] - self.now)

    def wait(self) -> None:
        """The next cycle."""
        self.now, self._issued = self.now + 1, 0

    def take(self, k: int) -> None:
        """Issue a unit."""
        self.ready.remove(k)
        self._issued += 1
        timing = self.line.timings[k]
        self._free[timing.unit] = self.now + timing.interval
        self.last = frozenset(self.line.after[k])
        for j in self.line.after[k]:
            self.waits[j] -= 1
            self.tick[j] = max(self.tick[j], self.now + timing.latency)
            if not self.waits[j]:
                self.ready.append(j)
