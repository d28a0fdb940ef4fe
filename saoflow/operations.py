"""The scalar operations: the closed set that every symbol expands into and every back end gives a meaning to.

An atom is what an operation reads: the number of a scalar value, or a literal. A tensor is the atoms of one wire in
row-major order; structure (zeros, ones, diagonals, symmetry) is nothing but literals and repeated values in it.
"""

from __future__ import annotations

import struct
from dataclasses import dataclass
from enum import Enum
from typing import Protocol

import numpy as np

from saoflow.formula import Formula


class Kind(Enum):
    """The kinds of scalar operation; the value is the name under which it is counted ("" is free)."""

    ADD = "add"
    SUBTRACT = "subtract"
    MULTIPLY = "multiply"
    RECIPROCAL = "reciprocal"
    MINIMUM = "minimum"
    MAXIMUM = "maximum"
    LESS = "compare", "<"
    LESS_EQUAL = "compare", "<="
    AND = "logic", "and"
    OR = "logic", "or"
    NOT = "logic", "not"
    SELECT = "select"
    LOOKUP = "lookup"
    READ = "", "read"
    WRITE = "", "write"
    CALL = "", "call"

    def __init__(self, counted_as: str, detail: str = "") -> None:
        self.counted_as = counted_as
        self.detail = detail


COUNTED_KINDS: tuple[str, ...] = (
    "add", "subtract", "multiply", "reciprocal", "minimum", "maximum", "compare", "logic", "select", "lookup",
)  # fmt: skip
"""What a budget can limit, in the order of reports."""

COMMUTATIVE = frozenset({Kind.ADD, Kind.MULTIPLY, Kind.AND, Kind.OR})
"""Operations whose result has the same bits with the operands exchanged (any NaN equals any NaN)."""


@dataclass(frozen=True, slots=True, eq=False)
class Literal:
    """A constant atom. Equal if equal in every bit (signed zeros differ); any NaN equals any NaN."""

    value: float | bool

    def _key(self) -> tuple[bool, bytes]:
        v = self.value
        if isinstance(v, bool):
            return True, b"\x01" if v else b"\x00"
        return False, b"nan" if v != v else struct.pack("<d", v)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Literal) and self._key() == other._key()

    def __hash__(self) -> int:
        return hash(self._key())

    @property
    def is_zero(self) -> bool:
        """A real zero of either sign: left out of sums, and annihilates products."""
        return not isinstance(self.value, bool) and self.value == 0.0


Atom = int | Literal
"""The number of a value of the body, or a literal."""

ZERO = Literal(0.0)
ONE = Literal(1.0)
MINUS_ONE = Literal(-1.0)


@dataclass(frozen=True, slots=True)
class Tensor:
    """The atoms of one wire, row-major; shape () is a scalar."""

    shape: tuple[int, ...]
    atoms: tuple[Atom, ...]

    def __getitem__(self, index: tuple[int, ...]) -> Atom:
        """The atom at a full index."""
        flat = 0
        for i, n in zip(index, self.shape, strict=True):
            flat = flat * n + i
        return self.atoms[flat]

    @property
    def scalar(self) -> Atom:
        """The only atom of a tensor of one element."""
        (atom,) = self.atoms
        return atom


@dataclass(frozen=True, slots=True, eq=False)
class Table:
    """A look-up table in one or two dimensions (identity is the object).

    One dimension: ``breakpoints[0]`` (n,), ``values`` (n,). Two: ``breakpoints`` (n,), (m,), ``values`` (n, m).
    The input is limited to the ends (NaN gives the first value). ``linear``: value + (u - breakpoint) * slope, where the
    slope at the last breakpoint is 0; ``hold``: the value at the breakpoint at or left of the input.
    """

    name: str
    breakpoints: tuple[np.ndarray, ...]
    values: np.ndarray
    linear: bool
    function: Formula | None = None
    """What the table approximates: takes its place in exact mode."""
    error: float = 0.0
    """The proved largest error against ``function`` (absolute, or relative if ``relative``); 0 for data."""
    relative: bool = False


class Expander(Protocol):
    """What a symbol's expansion may do: emit scalar operations. Structural zeros and ones are left out by the emitter."""

    def literal(self, value: float | bool) -> Literal:
        """A constant, rounded to the real type of the program."""
        ...

    def add(self, a: Atom, b: Atom) -> Atom:
        """``a + b``; a structural zero is left out."""
        ...

    def subtract(self, a: Atom, b: Atom) -> Atom:
        """``a - b``; a structural zero is left out (``0 - b`` is a negation)."""
        ...

    def multiply(self, a: Atom, b: Atom) -> Atom:
        """``a * b``; a structural zero gives zero, a structural one is left out."""
        ...

    def reciprocal(self, a: Atom) -> Atom:
        """``1 / a``."""
        ...

    def minimum(self, a: Atom, b: Atom) -> Atom:
        """``a < b ? a : b``."""
        ...

    def maximum(self, a: Atom, b: Atom) -> Atom:
        """``a > b ? a : b``."""
        ...

    def compare(self, relation: str, a: Atom, b: Atom) -> Atom:
        """``a relation b`` for ``< <= > >=``; false with NaN."""
        ...

    def logic(self, kind: Kind, *operands: Atom) -> Atom:
        """AND, OR of two operands, NOT of one."""
        ...

    def select(self, condition: Atom, a: Atom, b: Atom) -> Atom:
        """``condition ? a : b``; both are evaluated."""
        ...

    def lookup(self, table: Table, *operands: Atom) -> Atom:
        """The table at the operands (one, or two)."""
        ...
