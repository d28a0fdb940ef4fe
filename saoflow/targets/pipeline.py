"""An in-order pipeline: when each instruction of a straight line issues, and when the last result is there.

The model: instructions issue in their order, at most ``issue_width`` in a cycle (branches beside them where the target
folds them); one waits until what it reads is ready (the latency of its writer), and until its unit takes another (the
interval of the instruction before it there). Every load and store hits; every branch is predicted; nothing is
reordered. It is no worst-case execution time.
"""

from __future__ import annotations

from collections.abc import Sequence

from saoflow.targets.instructions import Instruction
from saoflow.targets.target import Target


def cycles(instructions: Sequence[Instruction], target: Target, real: int) -> int:
    """Cycles from the first issue until every result is there, reals of ``real`` bits (64 or 32)."""
    timings = {kind: target.timing(kind, real) for kind in target.kinds()}
    ready: dict[int, int] = {}
    free: dict[str, list[int]] = {unit: [0] * count for unit, count in target.units.items()}
    now = issued = end = 0
    alone_at = -1
    for instruction in instructions:
        timing = timings[instruction.kind]
        pool = free[timing.unit]
        k = pool.index(min(pool))
        start = max(now, pool[k], max((ready.get(r, 0) for r in instruction.reads), default=0))
        slots = 0 if timing.folded else 1
        if (
            start == now
            and slots
            and (issued + slots > target.issue_width or alone_at == now or (timing.alone and issued))
        ):
            start += 1
        if start > now:
            now, issued = start, 0
        issued += slots
        if timing.alone:
            alone_at = now
        pool[k] = start + timing.interval
        done = start + timing.latency
        if instruction.write >= 0:
            ready[instruction.write] = done
        end = max(end, done, start + 1)
    return end
