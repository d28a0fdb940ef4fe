"""Leaving out what no output, probe or state needs: operations, results of procedures, whole procedures.

Constants and common subexpressions are dealt with while lowering (``emitter.py``); nothing here or there changes a bit of
what remains.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from saoflow.operations import Kind
from saoflow.scheduler.program import FrameProgram, Operation, ProgramBody


def simplify(program: FrameProgram) -> FrameProgram:
    """The program without dead operations, and without parameters of procedures that nothing reads."""
    while True:
        program = _without_dead(program)
        unread = [_unread(body) for body in program.procedures]
        if not any(unread):
            return program
        program = _without_parameters(program, unread)


def _unread(body: ProgramBody) -> frozenset[int]:
    """Which parameters, by place, neither an operation nor a result reads."""
    read = {atom for op in body.operations for atom in op.reads} | set(body.results)
    return frozenset(i for i, value in enumerate(body.parameters) if value not in read)


def _without_parameters(program: FrameProgram, unread: Sequence[frozenset[int]]) -> FrameProgram:
    def narrowed(body: ProgramBody) -> ProgramBody:
        operations = tuple(
            op
            if op.kind is not Kind.CALL
            else replace(op, operands=tuple(a for i, a in enumerate(op.operands) if i not in unread[op.detail]))
            for op in body.operations
        )
        return replace(body, operations=operations)

    procedures = tuple(
        replace(narrowed(body), parameters=tuple(v for i, v in enumerate(body.parameters) if i not in dropped))
        for body, dropped in zip(program.procedures, unread, strict=True)
    )
    groups = tuple(replace(group, body=narrowed(group.body)) for group in program.groups)
    return replace(program, procedures=procedures, groups=groups)


def _without_dead(program: FrameProgram) -> FrameProgram:
    used: list[set[int]] = [set() for _ in program.procedures]
    called = [False] * len(program.procedures)
    groups = [
        replace(group, body=_live(group.body, set(range(len(group.body.results))), used, called))
        for group in program.groups
    ]
    bodies: list[ProgramBody] = list(program.procedures)
    for number in range(len(bodies) - 1, -1, -1):
        bodies[number] = _live(bodies[number], used[number], used, called) if called[number] else bodies[number]
    kept = [number for number in range(len(bodies)) if called[number]]
    renumbered = {number: i for i, number in enumerate(kept)}
    procedures = tuple(
        _narrow_calls(_narrow_results(bodies[number], used[number]), used, renumbered) for number in kept
    )
    return replace(
        program,
        procedures=procedures,
        groups=tuple(replace(g, body=_narrow_calls(g.body, used, renumbered)) for g in groups),
    )


def _live(body: ProgramBody, results: set[int], used: list[set[int]], called: list[bool]) -> ProgramBody:
    """Keep the operations that the given results need; note which results of procedures they use."""
    needed = {atom for i, atom in enumerate(body.results) if i in results and isinstance(atom, int)}
    kept: list[Operation] = []
    for op in reversed(body.operations):
        live = [i for i, value in enumerate(op.results) if value in needed]
        if not live and op.kind is not Kind.WRITE:
            continue
        needed.update(atom for atom in op.reads if isinstance(atom, int))
        if op.kind is Kind.CALL:
            used[op.detail].update(live)
            called[op.detail] = True
        kept.append(op)
    return replace(body, operations=tuple(reversed(kept)))


def _narrow_results(body: ProgramBody, used: set[int]) -> ProgramBody:
    return replace(body, results=tuple(atom for i, atom in enumerate(body.results) if i in used))


def _narrow_calls(body: ProgramBody, used: list[set[int]], renumbered: dict[int, int]) -> ProgramBody:
    operations = tuple(
        op
        if op.kind is not Kind.CALL
        else replace(
            op,
            results=tuple(value for i, value in enumerate(op.results) if i in used[op.detail]),
            otherwise=tuple(atom for i, atom in enumerate(op.otherwise) if i in used[op.detail]),
            detail=renumbered[op.detail],
        )
        for op in body.operations
    )
    return replace(body, operations=operations)
