"""Which procedures a compiled frame lays out in place: passing a hundred arguments costs more than the work in between.

For this machine only; the code that flies keeps its functions. Placing a procedure changes no bit of its results.
"""

from __future__ import annotations

from saoflow.operations import Kind
from saoflow.scheduler.program import FrameProgram, ProgramBody

LARGEST = 1000
"""Operations of a procedure, with what is placed inside it, that is still placed in its callers."""
MOST = 20_000
"""Operations of all functions together after that; beyond it a compile would last too long, and nothing is placed."""


def placed_procedures(program: FrameProgram) -> frozenset[int]:
    """The procedures that are laid out in place, by number."""
    sizes: list[int] = []
    placed: set[int] = set()

    def size(body: ProgramBody) -> int:
        calls = [op.detail for op in body.operations if op.kind is Kind.CALL]
        return len(body.operations) + sum(sizes[number] for number in calls if number in placed)

    for number, body in enumerate(program.procedures):
        sizes.append(size(body))
        if sizes[number] <= LARGEST:
            placed.add(number)
    kept = sum(n for number, n in enumerate(sizes) if number not in placed)
    return frozenset(placed) if kept + sum(size(group.body) for group in program.groups) <= MOST else frozenset()
