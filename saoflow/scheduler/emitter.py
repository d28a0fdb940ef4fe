"""Emitting scalar operations into a body: structural zeros and ones left out, equal operations shared."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from saoflow.operations import COMMUTATIVE, ONE, ZERO, Atom, Kind, Literal, Table
from saoflow.scheduler.program import Operation, Origin, ProgramBody, TracedScope


class TableNumbers:
    """The tables of a program, each once."""

    def __init__(self) -> None:
        self.tables: list[Table] = []
        self._numbers: dict[int, int] = {}

    def number(self, table: Table) -> int:
        """The number of a table, given on first sight."""
        if id(table) not in self._numbers:
            self._numbers[id(table)] = len(self.tables)
            self.tables.append(table)
        return self._numbers[id(table)]


class Emitter:
    """Builds one body. Implements :class:`saoflow.operations.Expander`.

    With ``simplify``, operations on literals are computed now (in the real type of the program, so that the bits are those
    of the frame), and an operation that was emitted before with the same operands is used again.
    """

    def __init__(self, name: str, tables: TableNumbers, real: int, simplify: bool) -> None:
        self.name = name
        self.tables = tables
        self.real = real
        self.simplify = simplify
        self.operations: list[Operation] = []
        self.booleans: list[bool] = []
        self.parameters: list[int] = []
        self.origins: list[Origin] = []
        self.traced: list[TracedScope] = []
        self._shared: dict[tuple[Kind, tuple[Atom, ...], int], int] = {}
        self._origin = -1

    def at(self, origin: Origin) -> None:
        """What is emitted next comes from here."""
        self.origins.append(origin)
        self._origin = len(self.origins) - 1
        if not self.simplify:
            self._shared.clear()

    def value(self, boolean: bool) -> int:
        """The number of a further value."""
        self.booleans.append(boolean)
        return len(self.booleans) - 1

    def parameter(self, boolean: bool) -> int:
        """A value that is given to the body."""
        number = self.value(boolean)
        self.parameters.append(number)
        return number

    def body(self, results: tuple[Atom, ...]) -> ProgramBody:
        """The finished body."""
        return ProgramBody(
            self.name,
            tuple(self.parameters),
            tuple(self.operations),
            results,
            tuple(self.booleans),
            tuple(self.origins),
            tuple(self.traced),
        )

    def is_boolean(self, atom: Atom) -> bool:
        """Boolean or real."""
        return isinstance(atom.value, bool) if isinstance(atom, Literal) else self.booleans[atom]

    def raw(
        self,
        kind: Kind,
        operands: tuple[Atom, ...],
        results: tuple[int, ...],
        detail: int,
        guard: int | None = None,
        otherwise: tuple[Atom, ...] = (),
    ) -> None:
        """Append an operation as it is."""
        self.operations.append(Operation(kind, results, operands, detail, self._origin, guard, otherwise))

    def literal(self, value: float | bool) -> Literal:
        """A constant, rounded to the real type of the program."""
        if isinstance(value, bool) or self.real == 64:
            return Literal(value)
        with np.errstate(all="ignore"):
            return Literal(float(np.float32(value)))

    def add(self, a: Atom, b: Atom) -> Atom:
        """``a + b``; a structural zero is left out."""
        if isinstance(a, Literal) and a.is_zero:
            return b
        if isinstance(b, Literal) and b.is_zero:
            return a
        return self._emit(Kind.ADD, (a, b), False, lambda x, y: x + y)

    def subtract(self, a: Atom, b: Atom) -> Atom:
        """``a - b``; a structural zero is left out."""
        if isinstance(b, Literal) and b.is_zero:
            return a
        if isinstance(a, Literal) and a.is_zero:
            return self.multiply(Literal(-1.0), b)
        return self._emit(Kind.SUBTRACT, (a, b), False, lambda x, y: x - y)

    def multiply(self, a: Atom, b: Atom) -> Atom:
        """``a * b``; a structural zero gives zero, a structural one is left out."""
        if (isinstance(a, Literal) and a.is_zero) or (isinstance(b, Literal) and b.is_zero):
            return ZERO
        if a == ONE:
            return b
        if b == ONE:
            return a
        return self._emit(Kind.MULTIPLY, (a, b), False, lambda x, y: x * y)

    def reciprocal(self, a: Atom) -> Atom:
        """``1 / a``; of a structural one, one."""
        if a == ONE:
            return ONE
        return self._emit(Kind.RECIPROCAL, (a,), False, _reciprocal)

    def minimum(self, a: Atom, b: Atom) -> Atom:
        """``a < b ? a : b``."""
        return self._emit(Kind.MINIMUM, (a, b), False, lambda x, y: x if x < y else y)

    def maximum(self, a: Atom, b: Atom) -> Atom:
        """``a > b ? a : b``."""
        return self._emit(Kind.MAXIMUM, (a, b), False, lambda x, y: x if x > y else y)

    def compare(self, relation: str, a: Atom, b: Atom) -> Atom:
        """``a relation b``; ``a > b`` is ``b < a``."""
        if relation in (">", ">="):
            a, b = b, a
        if relation in ("<", ">"):
            return self._emit(Kind.LESS, (a, b), True, lambda x, y: x < y)
        return self._emit(Kind.LESS_EQUAL, (a, b), True, lambda x, y: x <= y)

    def logic(self, kind: Kind, *operands: Atom) -> Atom:
        """AND, OR of two operands, NOT of one."""
        meaning: dict[Kind, Callable[..., bool]] = {
            Kind.AND: lambda x, y: x and y,
            Kind.OR: lambda x, y: x or y,
            Kind.NOT: lambda x: not x,
        }
        return self._emit(kind, operands, True, meaning[kind])

    def select(self, condition: Atom, a: Atom, b: Atom) -> Atom:
        """``condition ? a : b``; a literal condition or equal values decide now."""
        if self.simplify:
            if isinstance(condition, Literal):
                return a if condition.value else b
            if a == b:
                return a
        return self._emit(Kind.SELECT, (condition, a, b), self.is_boolean(a), None)

    def lookup(self, table: Table, *operands: Atom) -> Atom:
        """The table at the operands."""
        return self._emit(Kind.LOOKUP, operands, False, None, self.tables.number(table))

    def _emit(
        self,
        kind: Kind,
        operands: tuple[Atom, ...],
        boolean: bool,
        meaning: Callable[..., float | bool] | None,
        detail: int = -1,
    ) -> Atom:
        if self.simplify and meaning is not None and all(isinstance(a, Literal) for a in operands):
            return self._fold(meaning, [a.value for a in operands if isinstance(a, Literal)])
        key = (kind, _canonical(kind, operands), detail)
        found = self._shared.get(key)
        if found is None:
            found = self.value(boolean)
            self.raw(kind, operands, (found,), detail)
            self._shared[key] = found
        return found

    def _fold(self, meaning: Callable[..., float | bool], values: list[float | bool]) -> Literal:
        if self.real == 32:
            with np.errstate(all="ignore"):
                single = meaning(*(v if isinstance(v, bool) else np.float32(v) for v in values))
            return Literal(bool(single) if isinstance(single, (bool, np.bool_)) else float(single))
        return Literal(meaning(*values))


def _canonical(kind: Kind, operands: tuple[Atom, ...]) -> tuple[Atom, ...]:
    if kind not in COMMUTATIVE or len(operands) != 2:
        return operands
    a, b = operands
    if isinstance(a, int) and isinstance(b, int):
        return (a, b) if a <= b else (b, a)
    return (b, a) if isinstance(a, Literal) else (a, b)


def _reciprocal(x: float) -> float:
    """1 / x as IEEE has it."""
    if isinstance(x, np.floating):
        return np.float32(1.0) / x
    return 1.0 / x if x else math.copysign(math.inf, x)
