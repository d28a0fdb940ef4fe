"""Where values lie on the stack, and what it costs to form their addresses.

From the stack pointer up: arguments of calls, what registers had no room for (what is accessed most often nearest: GCC's
lra-spills.c), arrays that calls return results in, saved registers, the arguments that came in. A load or store reaches
only so far; beyond, its address is formed first (Thumb-2: ``addw``; beyond that, ``movw`` and ``add``).
"""

from __future__ import annotations

from collections.abc import Hashable, Sequence

import numpy as np

from saoflow.operations import Kind
from saoflow.scheduler.program import Operation, ProgramBody
from saoflow.targets.live_ranges import Life
from saoflow.targets.target import InstructionSet

BYTES = 8
"""Of a real in memory."""

BUCKETS = 512
"""Parts that a body is cut into to see what is on the stack at once."""

INPUT, RETURNED = -3, -2
"""Details of reads that the scheduler makes: of an input of the frame, of a result in the array that a call returned."""


class StackFrame:
    """The frame of a body: ``spilled`` are the lives that get a place of their own, ``saved`` registers are stored."""

    def __init__(
        self, body: ProgramBody, spilled: Sequence[Life], saved: int, isa: InstructionSet, procedure: bool
    ) -> None:
        self._reach = isa.stack_reach
        self._slot: dict[Hashable, int] = {}
        self._source: dict[int, int] = {}
        base = BYTES * max((_passed(body, o, isa) for o in body.operations if o.kind is Kind.CALL), default=0)
        at = base + BYTES * self._place(spilled, len(body.operations), base)
        for o in body.operations:
            if o.kind is Kind.READ and o.detail == RETURNED:
                self._source[o.results[0]] = self._address(at)
                at += BYTES
        at += BYTES * saved
        if procedure:
            for v in [v for v in body.parameters if not body.booleans[v]][isa.arguments :]:
                self._slot[v] = self._address(at)
                at += BYTES
        else:
            self._source.update((v, self.state(k)) for k, v in enumerate(body.parameters))

    def slot(self, value: Hashable) -> int:
        """Instructions that form the address of a value on the stack."""
        return self._slot.get(value, 0)

    def source(self, value: int) -> int:
        """The same for an input, or a result of a call in its array."""
        return self._source.get(value, 0)

    def state(self, number: int) -> int:
        """The same for the element of a number, of the state or of what else a pointer leads to; -1: unknown."""
        return min(1, self._address(BYTES * number))

    def _address(self, offset: int) -> int:
        far = sum(offset > reach for reach in self._reach)
        return 1 if far > 1 and offset // (offset & -offset) < 256 else far  # eight digits anywhere: one add.w

    def _place(self, spilled: Sequence[Life], length: int, base: int) -> int:
        """The address of each, the nearest slots to what is accessed most often; how many slots there are."""
        width = -(-(length + 2) // BUCKETS)
        waiting = sorted(spilled, key=lambda life: -len(life.reads))
        spans = {life.value: slice((life.born + 1) // width, life.end // width + 1) for life in waiting}
        whole = np.zeros(BUCKETS + 1, dtype=int)
        for span in spans.values():
            whole[span] += 1
        for tier, reach in enumerate(self._reach):
            slots = max(0, (reach + BYTES - base) // BYTES)
            free = np.full(BUCKETS + 1, slots)
            base += BYTES * slots
            left: list[Life] = []
            for life in waiting:
                span = spans[life.value]
                if free[span].min() > 0:
                    free[span] -= 1
                    self._slot[life.value] = tier
                else:
                    left.append(life)
            waiting = left
        self._slot.update((life.value, len(self._reach)) for life in waiting)
        return int(whole.max())


def _passed(body: ProgramBody, call: Operation, isa: InstructionSet) -> int:
    """Reals that a call passes on the stack."""
    return max(0, sum(not (isinstance(a, int) and body.booleans[a]) for a in call.operands) - isa.arguments)
