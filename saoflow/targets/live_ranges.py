"""Which values of a straight line are in registers, and where: what a colouring register allocator comes to.

A value is alive from where it is made to where it is last read. Where more are alive than there are registers, one of
them goes to memory for its whole life: the one with the least traffic for its length (Chaitin 1982: cost over degree). It is stored once, and loaded before each read;
between reads that are close and where a register is free it stays (GCC's inheritance of reloads).
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Sequence
from dataclasses import dataclass
from itertools import pairwise


@dataclass(frozen=True, slots=True)
class Life:
    """Where a value is made and read: places of operations. One that is in memory already is born by its first read."""

    value: Hashable
    born: int
    reads: tuple[int, ...]
    stored: bool
    """Whether memory holds it anyway (an input, a constant, a result of a call): no store if it is not kept."""
    made: bool
    """Whether it is in a register when it is born."""

    @property
    def end(self) -> int:
        """The last read."""
        return self.reads[-1]


@dataclass(frozen=True, slots=True)
class Registers:
    """What there is: registers for values, how many of these survive a call, how far a reloaded value is kept."""

    count: int
    preserved: int
    near: int


@dataclass(frozen=True, slots=True)
class Allocation:
    """What is not in a register all its life, and at which reads it is in one all the same."""

    in_memory: frozenset[Hashable]
    inherited: frozenset[tuple[Hashable, int]]
    saved: int
    """Registers that the caller wants back: stored at the beginning and loaded at the end."""

    def needs_load(self, value: Hashable, place: int) -> bool:
        """Whether a read at a place comes from memory."""
        return value in self.in_memory and (value, place) not in self.inherited


def allocate(lives: Sequence[Life], length: int, calls: Sequence[int], registers: Registers) -> Allocation:
    """Registers for the lives of ``length`` operations, with calls at some places."""
    cost: dict[Hashable, float] = {life.value: _traffic(life) / max(1, life.end - life.born) for life in lives}
    in_memory = _not_kept(lives, length, frozenset(calls), registers, lambda life: cost[life.value])
    free = [registers.count] * (length + 2)
    for k in calls:
        free[k + 1] = registers.preserved
    crossing = 0
    for life in lives:
        if life.value not in in_memory:
            for p in range(life.born + 1, life.end + 1):
                free[p] -= 1
    kept = [life for life in lives if life.value not in in_memory]
    for k in calls:
        crossing = max(crossing, sum(life.born < k < life.end for life in kept))
    inherited = _inherited([life for life in lives if life.value in in_memory], free, registers.near)
    called = {k + 1 for k in calls}
    most = max((registers.count - n for p, n in enumerate(free) if p not in called), default=0)
    saved = min(registers.preserved, max(most - (registers.count - registers.preserved), crossing))
    return Allocation(in_memory, inherited, saved)


def _traffic(life: Life) -> float:
    """Loads and stores if the value is not kept, beyond those that it needs anyway."""
    loads = len(life.reads) if life.made else len(life.reads) - 1
    return loads + (0 if life.stored else 1)


def _not_kept(
    lives: Sequence[Life], length: int, calls: frozenset[int], registers: Registers, cost: Callable[[Life], float]
) -> frozenset[Hashable]:
    waiting = sorted(lives, key=lambda life: life.born)
    active: list[Life] = []
    gone: set[Hashable] = set()
    at = 0
    for place in range(-1, length + 1):
        active = [life for life in active if life.end > place]
        while at < len(waiting) and waiting[at].born <= place:
            if waiting[at].end > place:
                active.append(waiting[at])
            at += 1
        while len(active) > registers.count:
            active.remove(worst := min(active, key=cost))
            gone.add(worst.value)
        if place in calls:
            across = [life for life in active if life.born < place]
            while len(across) > registers.preserved:
                across.remove(worst := min(across, key=cost))
                active.remove(worst)
                gone.add(worst.value)
    return frozenset(gone)


def _inherited(lives: Sequence[Life], free: list[int], near: int) -> frozenset[tuple[Hashable, int]]:
    gaps: list[tuple[int, int, int, Hashable]] = []
    for n, life in enumerate(lives):
        places = ([life.born] if life.made else []) + list(life.reads)
        gaps += [(b - a, a, n, life.value) for a, b in pairwise(places) if b - a <= near]
    found: set[tuple[Hashable, int]] = set()
    for size, start, _, value in sorted(gaps, key=lambda gap: gap[:3]):
        span = range(start + 1, start + size + 1)
        if all(free[p] > 0 for p in span):
            for p in span:
                free[p] -= 1
            found.add((value, start + size))
    return frozenset(found)

