"""Operations in the order in which a compiler has them when it gives out registers: scheduled once already.

Compilers for in-order processors schedule before they allocate, to have long ways started early, and hold back what
would make more values alive than there are registers. This is GCC's rule (haifa-sched.c, -fsched-pressure, on for
PowerPC and Arm): of what is ready, first what adds least to the excess over the registers, then what has the longest
way to go. What an operation adds is judged at the highest pressure between here and its place in the written order.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from saoflow.operations import Kind
from saoflow.scheduler.program import Operation, ProgramBody
from saoflow.targets.instructions import Instruction, Machine
from saoflow.targets.operation_form import machine_of
from saoflow.targets.peephole import BRANCHING
from saoflow.targets.target import Target

WINDOW = 100
"""How far ahead of the oldest operation left another may be taken (GCC keeps at most 100 in its ready list)."""

BARRIERS = BRANCHING | {Kind.CALL}
"""Nothing is moved across these."""


def scheduled_early(body: ProgramBody, target: Target, real: int, procedure: bool) -> ProgramBody:
    """The body with its operations, the loads of the frame's inputs and the stores of results, list-scheduled.

    Operations stay between the branches that they are between. A body that returns one real keeps it as its result; the
    results of all others are written by operations of their own.
    """
    single = procedure and len(body.results) == 1
    stores = [] if single else [Operation(Kind.WRITE, (), (r,), -1, 0) for r in body.results]
    operations = [*([] if procedure else _input_loads(body)), *body.operations, *stores]
    state = _Pressure(body, operations, body.results if single else (), target.instruction_set.registers)
    if procedure:
        state.arrive(body.parameters, target.instruction_set.arguments)
    order: list[Operation] = []
    block: list[Operation] = []
    for o in operations:
        if o.kind in BARRIERS:
            order += [*_reordered(block, target, real, state), o]
            state.pass_by(o)
            block = []
        else:
            block.append(o)
    order += _reordered(block, target, real, state)
    return replace(body, operations=tuple(order), results=body.results if single else ())


def _input_loads(body: ProgramBody) -> list[Operation]:
    read = {a for o in body.operations for a in o.operands} | set(body.results)
    return [Operation(Kind.READ, (v,), (), 0, 0) for v in body.parameters if v in read and not body.booleans[v]]


class _Pressure:
    """Which reals are alive, and how often each will be read."""

    def __init__(self, body: ProgramBody, operations: Sequence[Operation], kept: Sequence[object], registers: int) -> None:
        self.booleans = body.booleans
        self.registers = registers
        self.left: dict[int, int] = {}
        self.alive: set[int] = set()
        for o in operations:
            for a in self.read(o):
                self.left[a] = self.left.get(a, 0) + 1
        for r in kept:
            if isinstance(r, int) and not self.booleans[r]:
                self.left[r] = self.left.get(r, 0) + 1

    def read(self, o: Operation) -> set[int]:
        return {a for a in o.operands if isinstance(a, int) and not self.booleans[a]}

    def made(self, o: Operation) -> list[int]:
        return [r for r in o.results if not self.booleans[r] and self.left.get(r, 0)]

    def arrive(self, parameters: Sequence[int], most: int) -> None:
        reals = [v for v in parameters if not self.booleans[v]][:most]
        self.alive |= {v for v in reals if self.left.get(v, 0)}

    def pass_by(self, o: Operation) -> None:
        for a in self.read(o):
            self.left[a] -= 1
            if not self.left[a]:
                self.alive.discard(a)
        self.alive.update(self.made(o))


def _reordered(block: list[Operation], target: Target, real: int, state: _Pressure) -> list[Operation]:
    order = range(len(block)) if len(block) < 2 else _Block(block, target, real, state).order()
    for o in block:
        state.pass_by(o)
    return [block[k] for k in order]


class _Block:
    """A straight line being scheduled: what waits for what, and what each operation does to the number of reals alive."""

    def __init__(self, block: list[Operation], target: Target, real: int, state: _Pressure) -> None:
        self.registers, self.width = state.registers, target.issue_width
        kinds = {kind: target.timing(kind, real) for kind in target.kinds()}
        self.timings = [kinds[_instruction(o).kind] for o in block]
        self.read = [state.read(o) for o in block]
        writer = {r: k for k, o in enumerate(block) for r in o.results}
        self.after: list[list[int]] = [[] for _ in block]
        self.waits = [0] * len(block)
        self.readers: dict[int, list[int]] = {}
        for k, o in enumerate(block):
            for a in {a for a in o.operands if isinstance(a, int)}:
                if writer.get(a, k) < k:
                    self.after[writer[a]].append(k)
                    self.waits[k] += 1
            for a in self.read[k]:
                self.readers.setdefault(a, []).append(k)
        made = [state.made(o) for o in block]
        ending = {a: readers for a, readers in self.readers.items() if state.left[a] == len(readers)}
        self.readers = ending
        self.net = [len(m) for m in made]
        """Change of the number alive by each operation left, in the written order."""
        self.change = [len(m) for m in made]
        """The same if the operation came next."""
        for readers in ending.values():
            self.net[readers[-1]] -= 1
            if len(readers) == 1:
                self.change[readers[0]] -= 1
        self.alive = len(state.alive)
        self.height = [t.latency for t in self.timings]
        for k in range(len(block) - 1, -1, -1):
            self.height[k] += max((self.height[j] for j in self.after[k]), default=0)

    def order(self) -> list[int]:
        """Places in the block, in their new order."""
        count = len(self.net)
        ready = [k for k in range(count) if not self.waits[k]]
        tick = [0] * count
        done = [False] * count
        free: dict[str, int] = {}
        order: list[int] = []
        oldest = now = issued = 0
        while len(order) < count:
            far = oldest + WINDOW
            able = [k for k in ready if k < far and tick[k] <= now and free.get(self.timings[k].unit, 0) <= now]
            if issued >= self.width or not able:
                now, issued = now + 1, 0
                continue
            k = able[0] if len(able) == 1 else self._best(able, oldest)
            ready.remove(k)
            order.append(k)
            done[k] = True
            issued += 1
            self._take(k)
            timing = self.timings[k]
            free[timing.unit] = now + timing.interval
            for j in self.after[k]:
                self.waits[j] -= 1
                tick[j] = max(tick[j], now + timing.latency)
                if not self.waits[j]:
                    ready.append(j)
            while oldest < count and done[oldest]:
                oldest += 1
        return order

    def _best(self, able: list[int], oldest: int) -> int:
        """Of what can issue: least added to the excess over the registers, then the longest way, then the first."""
        able.sort()
        net, registers, height = self.net, self.registers, self.height
        alive = most = self.alive
        at = oldest
        best, found = (1 << 30, 0), able[0]
        for k in able:
            for j in range(at, k):
                alive += net[j]
                if alive > most:
                    most = alive
            at = k
            added = max(0, most + self.change[k] - registers) - max(0, most - registers)
            key = (added, -height[k])
            if key < best:
                best, found = key, k
        return found

    def _take(self, k: int) -> None:
        self.alive += self.change[k]
        self.net[k] = 0
        for a in self.read[k]:
            readers = self.readers.get(a)
            if readers is None:
                continue
            last = readers[-1]
            readers.remove(k)
            if readers and last == k:
                self.net[readers[-1]] -= 1
            if len(readers) == 1:
                self.change[readers[0]] -= 1


def _instruction(o: Operation) -> Instruction:
    kind = machine_of(o) or {Kind.READ: Machine.LOAD, Kind.WRITE: Machine.STORE}.get(o.kind, Machine.COMPARE)
    reads = tuple(a for a in o.operands if isinstance(a, int))
    return Instruction(kind, reads, o.results[0] if o.results else -1)
