"""One frame of a program with several rates, as a program of one rate: what is counted and costed."""

from __future__ import annotations

from dataclasses import replace

from saoflow.operations import Atom
from saoflow.scheduler.program import FrameProgram, Operation, ProgramBody


def frame_of(program: FrameProgram, frame: int) -> FrameProgram:
    """What runs in frame ``frame`` of the hyperperiod: guarded calls that do are calls, the others are what they hold."""
    if not program.rates:
        return program
    running = {rate.path for rate in program.rates if frame % rate.every == rate.offset}
    groups = tuple(replace(group, body=_body_of(group.body, running)) for group in program.groups)
    return replace(program, groups=groups, rates=())


def _body_of(body: ProgramBody, running: set[str]) -> ProgramBody:
    names: dict[int, Atom] = {}

    def renamed(atoms: tuple[Atom, ...]) -> tuple[Atom, ...]:
        return tuple(names.get(a, a) if isinstance(a, int) else a for a in atoms)

    kept: list[Operation] = []
    for op in body.operations:
        if op.guard is not None and body.origins[op.origin].path not in running:
            names.update(zip(op.results, renamed(op.otherwise), strict=True))
        else:
            kept.append(replace(op, operands=renamed(op.operands), guard=None, otherwise=()))
    return replace(body, operations=tuple(kept), results=renamed(body.results))
