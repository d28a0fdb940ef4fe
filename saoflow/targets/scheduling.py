"""List scheduling, as optimising compilers do it: within a straight line between branches, the longest way first."""

from __future__ import annotations

from collections.abc import Sequence

from saoflow.targets.instructions import Instruction, Machine
from saoflow.targets.target import Target

WINDOW = 16
"""How far ahead of the oldest instruction not yet issued another may be taken: registers bound what can be in flight."""


def scheduled(instructions: Sequence[Instruction], target: Target, real: int) -> list[Instruction]:
    """The same instructions, reordered between branches so that long ways to the end of the block start early."""
    found: list[Instruction] = []
    start = 0
    for end in range(1, len(instructions) + 1):
        if end == len(instructions) or instructions[end - 1].kind is Machine.BRANCH:
            block = list(instructions[start:end])
            last = [block[-1]] if block[-1].kind is Machine.BRANCH else []
            block = block[: len(block) - len(last)]
            found += [block[k] for k in block_order(block, target, real, WINDOW)] + last
            start = end
    return found


def block_order(block: Sequence[Instruction], target: Target, real: int, window: int) -> list[int]:
    """Cycle by cycle: of what is ready and within the window, what has the longest way to go; places in the block."""
    timings = {kind: target.timing(kind, real) for kind in target.kinds()}
    taken = [timings[instruction.kind] for instruction in block]
    units = [timing.unit for timing in taken]
    width = target.issue_width
    writer = {instruction.write: k for k, instruction in enumerate(block)}
    after: list[list[int]] = [[] for _ in block]
    waits = [0] * len(block)
    for k, instruction in enumerate(block):
        for r in set(instruction.reads):
            if r in writer and writer[r] < k:
                after[writer[r]].append(k)
                waits[k] += 1
    height = [0] * len(block)
    for k in range(len(block) - 1, -1, -1):
        height[k] = taken[k].latency + max((height[j] for j in after[k]), default=0)
    ready_at = [0] * len(block)
    free: dict[str, int] = {}
    order: list[int] = []
    done = [False] * len(block)
    oldest = now = issued = 0
    while len(order) < len(block):
        best, found = -1, -1
        if issued < width:
            for k in range(oldest, min(oldest + window, len(block))):
                if done[k] or waits[k] or ready_at[k] > now or height[k] <= best or free.get(units[k], 0) > now:
                    continue
                best, found = height[k], k
        if found < 0:
            now, issued = now + 1, 0
            continue
        issued += 1
        order.append(found)
        done[found] = True
        free[units[found]] = now + taken[found].interval
        for j in after[found]:
            waits[j] -= 1
            ready_at[j] = max(ready_at[j], now + taken[found].latency)
        while oldest < len(block) and done[oldest]:
            oldest += 1
    return order
