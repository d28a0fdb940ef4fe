"""Look-ups of frames compiled for this machine: the search starts from a guide, so that a step or two find what the plain search takes nine for.

The guide divides the range evenly: bucket(u) = (int)((u - low) * scale). Subtraction, multiplication by a positive number
and truncation never decrease with u, rounding included, so every breakpoint of an earlier bucket is below u and every one of
a later bucket above. The interval is therefore found by comparisons with breakpoints, as in the plain search, and so are
its bits; the guide only says where to begin.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from saoflow.codegen.dialect import Dialect, Lanes, Scalar
from saoflow.codegen.tables_c import search_steps, table_items
from saoflow.codegen.tree import (
    Assign,
    Binary,
    Call,
    Cast,
    Compound,
    ConstantArray,
    Declare,
    Element,
    Expression,
    Function,
    Integer,
    Item,
    Parameter,
    Real,
    Repeat,
    Return,
    Statement,
    Variable,
)
from saoflow.operations import Kind, Literal, Table
from saoflow.table_evaluation import PreparedTable, prepare

MOST_BUCKETS = 4096


@dataclass(frozen=True, slots=True, eq=False)
class Guide:
    """``first[bucket]``: the last breakpoint of an earlier bucket (0 if there is none); ``within``: most in one bucket."""

    scale: float
    first: np.ndarray
    within: int


def guide_of(x: np.ndarray) -> Guide | None:
    """A guide to increasing breakpoints (n,), made in their own type; None where it would not help."""
    best: Guide | None = None
    buckets = 1 << max(2, int(x.size - 1).bit_length())
    while buckets <= MOST_BUCKETS and (best is None or best.within > 1):
        scale = x.dtype.type(buckets) / (x[-1] - x[0])
        if not np.isfinite(scale):
            return None
        bucket = ((x - x[0]) * scale).astype(np.int64)
        before = np.searchsorted(bucket, np.arange(bucket[-1] + 1), side="left")
        guide = Guide(float(scale), np.maximum(before - 1, 0), int(np.bincount(bucket).max()))
        if best is None or _steps(guide) < _steps(best):
            best = guide
        buckets *= 2
    return best if best is not None and _steps(best) + 2 < int(x.size).bit_length() else None


def _steps(guide: Guide) -> int:
    return int(guide.within).bit_length()


def native_table_items(name: str, table: Table, bits: int, lanes: int) -> tuple[Item, ...]:
    """The arrays of a table and its function: ``name`` for one flight (``lanes`` 0), ``name_lanes`` for lanes."""
    prepared = prepare(table, np.float64 if bits == 64 else np.float32)
    if len(prepared.breakpoints) == 1 and prepared.breakpoints[0].size < 1 << 16:
        guide = guide_of(prepared.breakpoints[0])
        if guide is not None or lanes:
            return _Guided(name, prepared, guide, bits, lanes).items()
    plain = table_items(name, table, bits)
    return (*plain, _lane_by_lane(name, len(prepared.breakpoints), lanes)) if lanes else plain


def _lane_by_lane(name: str, axes: int, lanes: int) -> Function:
    given = [Variable(c) for c in "uv"[:axes]]
    lane, out = Variable("l"), Variable("out")
    look = Assign(Element(out, lane), Call(name, tuple(Element(u, lane) for u in given)))
    body = (Declare("reals", "out", None), Repeat("l", lanes, (look,)), Return(out))
    return Function("reals", f"{name}_lanes", tuple(Parameter("const reals", u.name) for u in given), body, True)


class _Guided:
    """A table with its guide (without one: the plain search, all lanes in step), for one flight or for lanes."""

    def __init__(self, name: str, table: PreparedTable, guide: Guide | None, bits: int, lanes: int) -> None:
        self.name = name
        self.table = table
        self.guide = guide
        self.bits = bits
        self.lanes = lanes
        self.element = "double" if bits == 64 else "float"
        self.dialect: Dialect = Lanes(bits, lanes) if lanes else Scalar(bits)
        points = table.values.size
        self.halves = [1 << k for k in reversed(range(_steps(guide)))] if guide else list(search_steps(points))
        self.places = [Variable(f"i{lane}") for lane in range(max(lanes, 1))]

    def items(self) -> tuple[Item, ...]:
        """The arrays, then the function."""
        (x,) = self.table.breakpoints
        # A step may look beyond the last breakpoint: there nothing is at or below the input.
        padded = np.append(x, np.full(sum(self.halves) if self.guide else 0, np.inf, dtype=x.dtype))
        arrays = [self._array("x", padded), self._array("y", self.table.values)]
        if self.table.linear:
            arrays.append(self._array("s", self.table.slopes))
        kind = self.dialect.real
        name = f"{self.name}_lanes" if self.lanes else self.name
        function = Function(kind, name, (Parameter(f"const {kind}", "u"),), tuple(self._body(x)), True)
        if self.guide is not None:
            first = tuple(Integer(int(i)) for i in self.guide.first)
            arrays.append(ConstantArray("unsigned short", f"{self.name}_guide", first, ""))
        return (*arrays, function)

    def _array(self, which: str, values: np.ndarray) -> ConstantArray:
        return ConstantArray(self.element, f"{self.name}_{which}", tuple(Real(float(v), self.bits) for v in values), "")

    def _body(self, x: np.ndarray) -> list[Statement]:
        low, high = (self.dialect.literal(Literal(float(v))) for v in (x[0], x[-1]))
        kind, limited = f"const {self.dialect.real}", Variable("x")
        body: list[Statement] = [
            Declare(kind, "a", self.dialect.operation(Kind.MAXIMUM, [Variable("u"), low], False)),
            Declare(kind, "x", self.dialect.operation(Kind.MINIMUM, [Variable("a"), high], False)),
            *self._begin(limited, low),
        ]
        for half in self.halves:
            for lane, place in enumerate(self.places):
                ahead = Binary("+", place, Integer(half, True))
                there = Binary("<=", Element(Variable(f"{self.name}_x"), ahead), self._at(limited, lane))
                # No branch: which lane goes on cannot be predicted.
                step = Cast("unsigned int", there)
                step_on = step if half == 1 else Binary("*", step, Integer(half, True))
                body.append(Assign(place, Binary("+", place, step_on)))
        body.append(Declare(kind, "y", self._found("y")))
        if not self.table.linear:
            return [*body, Return(Variable("y"))]
        body += [Declare(kind, "p", self._found("x")), Declare(kind, "s", self._found("s"))]
        rise = Binary("*", Binary("-", limited, Variable("p")), Variable("s"))
        return [*body, Return(Binary("+", Variable("y"), rise))]

    def _begin(self, limited: Variable, low: Expression) -> list[Statement]:
        """Where the search of every lane begins: at its bucket's first, or at the first of all."""
        if self.guide is None:
            return [Declare("unsigned int", place.name, Integer(0, True)) for place in self.places]
        scale = self.dialect.literal(Literal(self.guide.scale))
        scaled = Binary("*", Binary("-", limited, low), scale)
        whole = Call("__builtin_convertvector", (scaled, Variable("places"))) if self.lanes else Cast("int", scaled)
        bucket, guide = Variable("b"), Variable(f"{self.name}_guide")
        starts = [Element(guide, self._at(bucket, lane)) for lane in range(len(self.places))]
        return [
            Declare("const places" if self.lanes else "const int", "b", whole),
            *(Declare("unsigned int", place.name, at) for place, at in zip(self.places, starts, strict=True)),
        ]

    def _at(self, value: Variable, lane: int) -> Expression:
        return Element(value, Integer(lane)) if self.lanes else value

    def _found(self, which: str) -> Expression:
        """An array at the place of every lane."""
        found = tuple(Element(Variable(f"{self.name}_{which}"), place) for place in self.places)
        return Compound("reals", found) if self.lanes else found[0]
