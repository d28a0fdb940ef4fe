"""List scheduling, as optimising compilers do it: within a straight line between branches, the longest way first."""

from __future__ import annotations

import heapq
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
        height[k] = timings[block[k].kind].latency + max((height[j] for j in after[k]), default=0)
    ready_at = [0] * len(block)
    ready = [(-height[k], k) for k in range(len(block)) if not waits[k]]
    heapq.heapify(ready)
    later: list[tuple[int, int]] = []
    free: dict[str, int] = {}
    order: list[int] = []
    done = [False] * len(block)
    oldest = now = 0
    while len(order) < len(block):
        while later and later[0][0] <= now:
            _, k = heapq.heappop(later)
            heapq.heappush(ready, (-height[k], k))
        issued = 0
        passed: list[tuple[int, int]] = []
        while ready and issued < width:
            entry = heapq.heappop(ready)
            k = entry[1]
            timing = timings[block[k].kind]
            if k >= oldest + window or free.get(timing.unit, 0) > now:
                passed.append(entry)
                continue
            issued += 1
            order.append(k)
            done[k] = True
            free[timing.unit] = now + timing.interval
            for j in after[k]:
                waits[j] -= 1
                ready_at[j] = max(ready_at[j], now + timing.latency)
                if not waits[j]:
                    heapq.heappush(later, (ready_at[j], j))
        for entry in passed:
            heapq.heappush(ready, entry)
        while oldest < len(block) and done[oldest]:
            oldest += 1
        now += 1
    return order
