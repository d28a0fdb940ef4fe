"""Operations in the order in which a compiler has them when it gives out registers: scheduled once already.

Compilers for in-order processors schedule before they allocate, to have long ways started early; more values are then
alive at a time, and more of them go to memory and back.
"""

from __future__ import annotations

from dataclasses import replace

from saoflow.operations import Kind
from saoflow.scheduler.program import Operation, ProgramBody
from saoflow.targets.instructions import Instruction, Machine
from saoflow.targets.operation_form import machine_of
from saoflow.targets.scheduling import block_order
from saoflow.targets.target import Target

WINDOW = 128
"""How far ahead of the oldest operation left another may be taken (GCC keeps at most 100 in its ready list)."""

BARRIERS = frozenset({Kind.MINIMUM, Kind.MAXIMUM, Kind.SELECT, Kind.LOOKUP, Kind.CALL})
"""Operations that branch: nothing is moved across them."""


def scheduled_early(body: ProgramBody, target: Target, real: int, procedure: bool, window: int = WINDOW) -> ProgramBody:
    """The body with its operations, and the loads of the frame's inputs, list-scheduled between branches."""
    order: list[Operation] = []
    block = [] if procedure else _input_loads(body)
    for o in body.operations:
        if o.kind in BARRIERS:
            order += [*_reordered(block, target, real, window), o]
            block = []
        else:
            block.append(o)
    order += _reordered(block, target, real, window)
    return replace(body, operations=tuple(order))


def _input_loads(body: ProgramBody) -> list[Operation]:
    read = {a for o in body.operations for a in o.operands} | set(body.results)
    return [Operation(Kind.READ, (v,), (), 0, 0) for v in body.parameters if v in read and not body.booleans[v]]


def _reordered(block: list[Operation], target: Target, real: int, window: int) -> list[Operation]:
    return [block[k] for k in block_order([_instruction(o) for o in block], target, real, window)]


def _instruction(o: Operation) -> Instruction:
    kind = machine_of(o) or {Kind.READ: Machine.LOAD, Kind.WRITE: Machine.STORE}.get(o.kind, Machine.COMPARE)
    reads = tuple(a for a in o.operands if isinstance(a, int))
    return Instruction(kind, reads, o.results[0] if o.results else -1)
