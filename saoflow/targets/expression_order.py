"""The order that a compiler writes operations in before it schedules: what is read once stands where it is read.

GCC expands its statements into instructions expression by expression: a value with one reader in the same straight line is
computed right before that reader (tree-ssa-ter.c), of two operands that may change places the one of more operations first
(cfgexpand.c, reorder_operands). So a product that an output waits for is computed next to the store, far from where the
sheet has it, and few values are alive meanwhile.
"""

from __future__ import annotations

from collections.abc import Sequence

from saoflow.operations import Kind
from saoflow.scheduler.program import Operation
from saoflow.targets.peephole import branches

MOVED = frozenset(
    {Kind.ADD, Kind.SUBTRACT, Kind.MULTIPLY, Kind.RECIPROCAL, Kind.LESS, Kind.LESS_EQUAL, Kind.AND, Kind.OR, Kind.NOT, Kind.READ}
)
"""Operations that move to their one reader."""

READERS = (MOVED | {Kind.WRITE, Kind.CALL}) - {Kind.READ}
"""Operations that a reader may be: those that branch read their operands on more than one way."""

COMMUTATIVE = frozenset({Kind.ADD, Kind.MULTIPLY})


def expression_order(operations: Sequence[Operation], kept: Sequence[object], conditional_moves: bool) -> list[Operation]:
    """The operations, each that one other reads right before it; ``kept``: what the body returns in a register."""
    readers: dict[int, list[int]] = {}
    for k, o in enumerate(operations):
        for a in o.reads:
            if isinstance(a, int):
                readers.setdefault(a, []).append(k)
    for r in kept:
        if isinstance(r, int):
            readers.setdefault(r, []).append(-1)
    line, stores = _lines(operations, conditional_moves)
    made: dict[int, int] = {}
    """By value: the operation that moves to its reader."""
    for k, o in enumerate(operations):
        if o.kind in MOVED and len(o.results) == 1:
            (reader, *others) = readers.get(o.results[0], [-1])
            if reader < 0 or others or operations[reader].kind not in READERS or line[reader] != line[k]:
                continue
            if o.kind is not Kind.READ or stores[reader] == stores[k]:
                made[o.results[0]] = k
    moved = set(made.values())
    weight = _weights(operations, made)
    found: list[Operation] = []
    for k in range(len(operations)):
        if k not in moved:
            _expand(k, operations, made, weight, found)
    return found


def _lines(operations: Sequence[Operation], conditional_moves: bool) -> tuple[list[int], list[int]]:
    """By operation: how many before it branch, how many write to memory."""
    line: list[int] = []
    stores: list[int] = []
    count = writes = 0
    for o, branch in zip(operations, branches(operations, conditional_moves), strict=True):
        line.append(count)
        stores.append(writes)
        count += branch
        writes += o.kind in (Kind.WRITE, Kind.CALL)
    return line, stores


def _weights(operations: Sequence[Operation], made: dict[int, int]) -> list[int]:
    """By operation: how many stand in its expression."""
    weight: list[int] = []
    for o in operations:
        weight.append(1 + sum(weight[made[a]] for a in o.operands if isinstance(a, int) and a in made))
    return weight


def _expand(
    root: int, operations: Sequence[Operation], made: dict[int, int], weight: list[int], found: list[Operation]
) -> None:
    """Append an operation after everything that stands in its expression."""
    waiting = [(root, False)]
    while waiting:
        k, ready = waiting.pop()
        o = operations[k]
        if ready:
            found.append(o)
            continue
        waiting.append((k, True))
        inner = [made[a] for a in o.operands if isinstance(a, int) and a in made]
        if o.kind in COMMUTATIVE and len(inner) == 2 and weight[inner[1]] > weight[inner[0]]:
            inner.reverse()
        waiting += [(j, False) for j in reversed(inner)]
