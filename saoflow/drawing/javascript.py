"""A frame program as JavaScript that keeps the value of every wire of every instance: what a page plays a flight with.

One function per body, from mangled names alone. A body writes its values into ``T`` from its base on, and passes each
procedure that it calls a base of its own; so a wire of an instance is found by adding up bases along its path. Numbers
in JavaScript are IEEE-754 binary64 without contraction: the bits are the interpreter's.
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np

from saoflow.operations import Atom, Kind, Literal, Table
from saoflow.scheduler.program import FrameProgram, ProgramBody
from saoflow.tables.evaluation import prepare

TEMPLATES = {
    Kind.ADD: "{0}+{1}",
    Kind.SUBTRACT: "{0}-{1}",
    Kind.MULTIPLY: "{0}*{1}",
    Kind.RECIPROCAL: "1/{0}",
    Kind.MINIMUM: "{0}<{1}?{0}:{1}",
    Kind.MAXIMUM: "{0}>{1}?{0}:{1}",
    Kind.LESS: "{0}<{1}",
    Kind.LESS_EQUAL: "{0}<={1}",
    Kind.AND: "{0}&&{1}",
    Kind.OR: "{0}||{1}",
    Kind.NOT: "!{0}",
    Kind.SELECT: "{0}?{1}:{2}",
}


@dataclass(frozen=True, slots=True)
class TracedJavaScript:
    """The text of the functions, and where every wire is."""

    text: str
    """``p0``, ``p1``, ... and ``frame(i, s, n, T)``: inputs, state, new state, trace."""
    bodies: tuple[dict[str, Any], ...]
    """For the page, by body (the frame's is the last): ``scopes`` by path, each a list of atoms by wire, and ``calls`` by
    path: procedure and base."""
    size: int
    """Elements of the trace."""
    initial: tuple[float, ...]
    """The state before the first frame."""


def print_javascript(program: FrameProgram) -> TracedJavaScript:
    """Print a program that was lowered with ``traced`` in binary64."""
    assert program.real == 64 and len(program.groups) == 1
    sizes: list[int] = []
    texts, bodies = [], []
    for number, body in enumerate((*program.procedures, program.groups[0].body)):
        layout = _Layout(body, sizes)
        sizes.append(layout.size)
        is_frame = number == len(program.procedures)
        texts.append(_frame(body, layout, len(program.states)) if is_frame else _procedure(number, body, layout))
        bodies.append(layout.described())
    tables = f"const tables={_tables(program.tables)};"
    initial = tuple(float(slot.initial) for slot in program.states)
    return TracedJavaScript("\n".join([tables, *texts]), tuple(bodies), sizes[-1], initial)


class _Layout:
    """Where a body's values are in the trace, from its base on."""

    def __init__(self, body: ProgramBody, sizes: list[int]) -> None:
        self.body = body
        wanted = {
            atom
            for scope in body.traced
            for tensor in scope.tensors
            if tensor is not None
            for atom in tensor.atoms
            if isinstance(atom, int)
        }
        self.place = {value: i for i, value in enumerate(sorted(wanted))}
        self.bases: dict[int, int] = {}
        """By number of the operation that calls."""
        self.size = len(self.place)
        for number, op in enumerate(body.operations):
            if op.kind is Kind.CALL:
                self.bases[number] = self.size
                self.size += sizes[op.detail]

    def described(self) -> dict[str, Any]:
        """For the page. An atom is its place, or ``[number]`` for a literal; runs of places are ``[first, last]`` texts."""
        body = self.body
        calls = {
            body.origins[op.origin].path: [op.detail, self.bases[n]]
            for n, op in enumerate(body.operations)
            if op.kind is Kind.CALL
        }
        scopes = {
            scope.path: [None if t is None else self._tensor(t.atoms) for t in scope.tensors] for scope in body.traced
        }
        return {"scopes": scopes, "calls": calls}

    def _tensor(self, atoms: tuple[Atom, ...]) -> Any:
        first = atoms[0] if atoms else None
        if isinstance(first, int) and len(atoms) > 1:
            start = self.place[first]
            if all(isinstance(a, int) and self.place[a] == start + k for k, a in enumerate(atoms)):
                return start
        return [self._atom(a) for a in atoms]

    def _atom(self, atom: Atom) -> Any:
        return [_shown(float(atom.value))] if isinstance(atom, Literal) else self.place[atom]


def _procedure(number: int, body: ProgramBody, layout: _Layout) -> str:
    given = ",".join([*(f"v{v}" for v in body.parameters), "T", "b"])
    lines = [f"function p{number}({given}){{", *_statements(body, layout, "b+"), *_kept(layout, "b+")]
    return "\n".join([*lines, f"return[{_listed(body.results)}];}}"])


def _frame(body: ProgramBody, layout: _Layout, slots: int) -> str:
    lines = ["function frame(i,s,n,T){"]
    lines += [f"const v{v}=i[{k}];" for k, v in enumerate(body.parameters)]
    lines += _statements(body, layout, "")
    written = {op.detail: op.operands[0] for op in body.operations if op.kind is Kind.WRITE}
    lines += [f"n[{slot}]={_text(written[slot]) if slot in written else f's[{slot}]'};" for slot in range(slots)]
    return "\n".join([*lines, *_kept(layout, ""), "}"])


def _statements(body: ProgramBody, layout: _Layout, base: str) -> Iterable[str]:
    for number, op in enumerate(body.operations):
        operands = [_text(a) for a in op.operands]
        if op.kind is Kind.WRITE:
            continue
        if op.kind is Kind.CALL:
            given = ",".join([*operands, "T", f"{base}{layout.bases[number]}"])
            held = "" if op.guard is None else f":[{_listed(op.otherwise)}]"
            when = "" if op.guard is None else f"{_text(op.guard)}?"
            yield f"const r{number}={when}p{op.detail}({given}){held};"
            for k, value in enumerate(op.results):
                yield f"const v{value}=r{number}[{k}];"
            continue
        if op.kind is Kind.READ:
            boolean = body.booleans[op.results[0]]
            text = f"s[{op.detail}]" + ("!==0" if boolean else "")
        elif op.kind is Kind.LOOKUP:
            text = f"look{len(op.operands)}(tables[{op.detail}],{','.join(operands)})"
        else:
            text = TEMPLATES[op.kind].format(*operands)
        yield f"const v{op.results[0]}={text};"


def _kept(layout: _Layout, base: str) -> Iterable[str]:
    return (f"T[{base}{place}]=v{value};" for value, place in layout.place.items())


def _listed(atoms: Iterable[Atom]) -> str:
    return ",".join(_text(atom) for atom in atoms)


def _text(atom: Atom) -> str:
    if not isinstance(atom, Literal):
        return f"v{atom}"
    value = atom.value
    if isinstance(value, bool):
        return "true" if value else "false"
    if math.isnan(value):
        return "NaN"
    if math.isinf(value):
        return "Infinity" if value > 0 else "(-Infinity)"
    return f"({value!r})" if value < 0 or math.copysign(1.0, value) < 0 else repr(value)


def _shown(value: float) -> float | str:
    return value if math.isfinite(value) else str(value)


def _tables(tables: tuple[Table, ...]) -> str:
    """The numbers of the tables, as the interpreter has them."""

    def numbers(array: np.ndarray) -> Any:
        return array.tolist()

    parts = []
    for table in tables:
        made = prepare(table)
        parts.append(
            {
                "linear": made.linear,
                "x": [numbers(axis) for axis in made.breakpoints],
                "z": numbers(made.values),
                "d": numbers(made.slopes),
                "r": [numbers(reciprocal) for reciprocal in made.reciprocals],
            }
        )
    return json.dumps(parts, allow_nan=False, separators=(",", ":"))
