"""An instrumented run: executes a frame program operation by operation and counts what it executes.

Slow and simple on purpose: it confirms the derived counts, and the generated Python bit by bit.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field

from saoflow.operations import Atom, Kind, Literal
from saoflow.scheduler.program import FrameProgram, ProgramBody
from saoflow.tables.evaluation import prepare

Scalar = float | bool


@dataclass(slots=True)
class CountingRun:
    """State and counts of an instrumented run in binary64, one flight."""

    program: FrameProgram
    state: list[Scalar] = field(default_factory=list)
    kinds: Counter[str] = field(default_factory=Counter)
    paths: Counter[str] = field(default_factory=Counter)

    def __post_init__(self) -> None:
        self.state = [slot.initial for slot in self.program.states]
        self._tables = [prepare(table).scalar_function() for table in self.program.tables]

    _tables: list[object] = field(default_factory=list, init=False)

    def frame(self, inputs: Sequence[Scalar]) -> tuple[Scalar, ...]:
        """One frame: the elements of all outputs and probes in order."""
        results: tuple[Scalar, ...] = ()
        stored: dict[int, Scalar] = {}
        for group in self.program.groups:
            results += self._execute(group.body, inputs, "", stored)
        for slot, value in stored.items():
            self.state[slot] = value
        return results

    def _execute(
        self, body: ProgramBody, given: Sequence[Scalar], prefix: str, stored: dict[int, Scalar]
    ) -> tuple[Scalar, ...]:
        values: dict[int, Scalar] = dict(zip(body.parameters, given, strict=True))

        def value(atom: Atom) -> Scalar:
            return atom.value if isinstance(atom, Literal) else values[atom]

        for op in body.operations:
            operands = [value(atom) for atom in op.operands]
            if op.kind is Kind.READ:
                values[op.results[0]] = self.state[op.detail]
            elif op.kind is Kind.WRITE:
                stored[op.detail] = operands[0]
            elif op.guard is not None and not values[op.guard]:
                values.update(zip(op.results, map(value, op.otherwise), strict=True))
            elif op.kind is Kind.CALL:
                path = f"{prefix}{body.origins[op.origin].path}."
                found = self._execute(self.program.procedures[op.detail], operands, path, stored)
                values.update(zip(op.results, found, strict=True))
            else:
                self.kinds[op.kind.counted_as] += 1
                self.paths[prefix + body.origins[op.origin].path] += 1
                values[op.results[0]] = self._scalar(op.kind, operands, op.detail)
        return tuple(value(atom) for atom in body.results)

    def _scalar(self, kind: Kind, u: list[Scalar], detail: int) -> Scalar:
        match kind:
            case Kind.ADD:
                return u[0] + u[1]
            case Kind.SUBTRACT:
                return u[0] - u[1]
            case Kind.MULTIPLY:
                return u[0] * u[1]
            case Kind.RECIPROCAL:
                return 1.0 / u[0] if u[0] != 0.0 else math.copysign(math.inf, u[0])
            case Kind.MINIMUM:
                return u[0] if u[0] < u[1] else u[1]
            case Kind.MAXIMUM:
                return u[0] if u[0] > u[1] else u[1]
            case Kind.LESS:
                return u[0] < u[1]
            case Kind.LESS_EQUAL:
                return u[0] <= u[1]
            case Kind.AND:
                return bool(u[0]) and bool(u[1])
            case Kind.OR:
                return bool(u[0]) or bool(u[1])
            case Kind.NOT:
                return not u[0]
            case Kind.SELECT:
                return u[1] if u[0] else u[2]
            case _:
                table = self._tables[detail]
                assert callable(table)
                return float(table(*u))
