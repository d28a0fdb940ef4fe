"""Look-ups of frames compiled for this machine: the search starts from a guide (:mod:`saoflow.codegen.guide`), so that a
step or two find what the plain search takes nine for; what a breakpoint has (input, value, slope) lies side by side.
"""

from __future__ import annotations

import numpy as np

from saoflow.codegen.dialect import Dialect, Lanes, Scalar
from saoflow.codegen.guide import Guide, guide_of
from saoflow.codegen.quads import guarded, quads_fit, turned
from saoflow.codegen.tables_c import search_steps, table_items
from saoflow.codegen.tree import (
    AddressOf,
    Assign,
    Binary,
    Call,
    Cast,
    Compound,
    ConstantArray,
    Declare,
    Do,
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
from saoflow.tables.evaluation import PreparedTable, prepare


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
        self.stride = 4 if table.linear else 2
        points = table.values.size
        self.halves = [1 << k for k in reversed(range(guide.steps))] if guide else list(search_steps(points))
        self.places = [Variable(f"i{lane}") for lane in range(max(lanes, 1))]

    def items(self) -> tuple[Item, ...]:
        """The arrays, then the function."""
        (x,) = self.table.breakpoints
        # A step may look beyond the last breakpoint: there nothing is at or below the input.
        rows = np.zeros((x.size + (sum(self.halves) if self.guide else 0), self.stride), dtype=x.dtype)
        rows[:, 0] = np.inf
        rows[: x.size, 0], rows[: x.size, 1] = x, self.table.values
        if self.table.linear:
            rows[: x.size, 2] = self.table.slopes
            rows[:-1, 3], rows[-1, 3] = rows[1:, 0], np.inf
        numbers = tuple(Real(float(v), self.bits) for v in rows.ravel())
        items: list[Item] = [ConstantArray(self.element, f"{self.name}_r", numbers, "input, value, slope, next input")]
        if self.guide is not None:
            first = tuple(Integer(int(i) * self.stride) for i in self.guide.first)
            kind = "unsigned short" if rows.size < 1 << 16 else "unsigned int"
            items.append(ConstantArray(kind, f"{self.name}_guide", first, ""))
        kind = self.dialect.real
        name = f"{self.name}_lanes" if self.lanes else self.name
        parameters = (Parameter(f"const {kind}", "u"),)

        def function(quads: bool) -> Function:
            return Function(f"inline {kind}", name, parameters, tuple(self._body(x, quads)), True)

        whole_rows = self.table.linear and quads_fit(self.lanes)
        return (*items, *(guarded([function(True)], [function(False)]) if whole_rows else [function(False)]))

    def _body(self, x: np.ndarray, quads: bool) -> list[Statement]:
        low, high = (self.dialect.literal(Literal(float(v))) for v in (x[0], x[-1]))
        kind, limited = f"const {self.dialect.real}", Variable("x")
        body: list[Statement] = [
            Declare(kind, "a", self.dialect.operation(Kind.MAXIMUM, [Variable("u"), low], False)),
            Declare(kind, "x", self.dialect.operation(Kind.MINIMUM, [Variable("a"), high], False)),
            *self._begin(limited),
        ]
        if quads and self.halves == [1]:
            body += self._step_of_lanes(limited)
        else:
            body += self._steps(limited)
            if not self.table.linear:
                return [*body, Return(self._found(1))]
            columns = {0: "p", 1: "y", 2: "s"}
            if quads:
                body += turned(f"{self.name}_r", self.places, 0, columns, self.bits)
            else:
                body += [Declare(kind, name, self._found(k)) for k, name in columns.items()]
        rise = Binary("*", Binary("-", limited, Variable("p")), Variable("s"))
        return [*body, Return(Binary("+", Variable("y"), rise))]

    def _steps(self, limited: Variable) -> list[Statement]:
        """The search goes on from where it began, in steps that halve; every lane for itself."""
        body: list[Statement] = []
        for half in self.halves:
            for lane, place in enumerate(self.places):
                there = Binary("<=", self._row(place, half * self.stride), self._at(limited, lane))
                # No branch: which lane goes on cannot be predicted.
                step = Binary("*", Cast("unsigned int", there), Integer(half * self.stride, True))
                body.append(Assign(place, Binary("+", place, step)))
        return body

    def _step_of_lanes(self, limited: Variable) -> list[Statement]:
        """One step is left: the row of the beginning and the next one for all lanes, then a choice."""
        array = f"{self.name}_r"
        body = turned(array, self.places, 0, {0: "p0", 1: "y0", 2: "s0", 3: "p1"}, self.bits)
        body += turned(array, self.places, self.stride, {1: "y1", 2: "s1"}, self.bits)
        on = self.dialect.operation(Kind.LESS_EQUAL, [Variable("p1"), limited], True)
        body.append(Declare("const masks", "on", on))
        for name in ("p", "y", "s"):
            operands: list[Expression] = [Variable("on"), Variable(f"{name}1"), Variable(f"{name}0")]
            body.append(Declare("const reals", name, self.dialect.operation(Kind.SELECT, operands, False)))
        return body

    def _begin(self, limited: Variable) -> list[Statement]:
        """Where the search of every lane begins: at its bucket's first, or at the first of all."""
        guide = self.guide
        if guide is None:
            return [Declare("unsigned int", place.name, Integer(0, True)) for place in self.places]
        scale, shift = (self.dialect.literal(Literal(v)) for v in (guide.scale, guide.shift))
        scaled = Binary("+", limited if guide.scale == 1.0 else Binary("*", limited, scale), shift)
        whole, number = "long long" if self.bits == 64 else "int", Variable("n")
        body: list[Statement] = [Declare(f"const {self.dialect.real}", "w", scaled)]
        if self.lanes:
            # Shifted and less the base in all lanes at once; the last 32 bits are what counts.
            key: Expression = Cast("masks", Variable("w"))
            key = Binary(">>", key, Integer(guide.drop)) if guide.drop else key
            base = Call("every_mask", (Integer(guide.base),))
            body.append(Declare("const masks", "n", Binary("-", key, base) if guide.base else key))
        else:
            copy = Call("__builtin_memcpy", (AddressOf(number), AddressOf(Variable("w")), Integer(self.bits // 8, True)))
            body += [Declare(whole, "n", None), Do(copy)]
        for lane, place in enumerate(self.places):
            found: Expression = self._at(number, lane)
            if self.lanes:
                found = Cast("unsigned int", found)
            else:
                found = Cast("unsigned int", Binary(">>", found, Integer(guide.drop)) if guide.drop else found)
                found = Binary("-", found, Integer(guide.base, True)) if guide.base else found
            body.append(Declare("unsigned int", place.name, Element(Variable(f"{self.name}_guide"), found)))
        return body

    def _row(self, place: Variable, further: int) -> Expression:
        return Element(Variable(f"{self.name}_r"), Binary("+", place, Integer(further, True)) if further else place)

    def _at(self, value: Variable, lane: int) -> Expression:
        return Element(value, Integer(lane)) if self.lanes else value

    def _found(self, which: int) -> Expression:
        """What lies in the rows at the places of every lane."""
        found = tuple(self._row(place, which) for place in self.places)
        return Compound("reals", found) if self.lanes else found[0]
