"""The loop over frames in C, for this machine: recordings and state as flat arrays of reals, one flight or lanes of them.

    void saoflow_run(double *slots, const long *span, const double *const *in, const long *in_step,
                     REAL *const *out, const long *out_step)

``span``: number of flights, first flight of the lanes, frames. ``slots``: (slots, flights). ``in[p]``, ``out[p]``: the
port's element 0 of flight 0 in the first frame; ``in_step[2p]``, ``in_step[2p+1]``: how many elements further the next
flight and the next frame are. The elements of a port lie side by side.
"""

from __future__ import annotations

from saoflow.codegen.dialect import Lanes
from saoflow.codegen.interface import ENTRY, Interface
from saoflow.codegen.tree import (
    AddressOf,
    Assign,
    Binary,
    Call,
    Cast,
    Conditional,
    Declare,
    Directive,
    Do,
    Element,
    Expression,
    Function,
    Integer,
    Item,
    Member,
    Parameter,
    Real,
    Repeat,
    Statement,
    Variable,
    When,
)
from saoflow.scheduler.program import FrameProgram, ProgramPort

RESERVED = frozenset(
    {ENTRY, "reals", "masks", "quads", "every_real", "every_mask", "chosen", "chosen_mask", "smaller", "larger"}
)
"""Names of the file that holds a runner."""

_FRAME, _FLIGHT, _LANE, _ELEMENT = Variable("t"), Variable("f"), Variable("l"), Variable("k")


def strictness() -> tuple[Item, ...]:
    """Refuse a compiler that would not compute the interpreter's bits."""
    return (
        Directive("if defined(__FAST_MATH__) || (defined(__FLT_EVAL_METHOD__) && __FLT_EVAL_METHOD__ != 0)"),
        Directive("error reals would not be rounded after every operation"),
        Directive("endif"),
    )


def runner(program: FrameProgram, face: Interface, lanes: Lanes | None) -> Function:
    """The function above."""
    return _Runner(program, face, lanes).function()


class _Runner:
    def __init__(self, program: FrameProgram, face: Interface, lanes: Lanes | None) -> None:
        self.program = program
        self.face = face
        self.lanes = lanes
        self.real = "double" if program.real == 64 else "float"

    def function(self) -> Function:
        face, span = self.face, Variable("span")
        outputs = (*self.program.outputs, *self.program.probes)
        inside = [
            *self._each_lane([self._input(p, port, n) for p, (port, n) in self._numbered(self.program.inputs)]),
            Do(Call(face.step, tuple(AddressOf(Variable(name)) for name in ("state", "input", "output")))),
            *self._each_lane([self._output(p, port, n) for p, (port, n) in self._numbered(outputs)], True),
        ]
        body: list[Statement] = [
            Declare("const long", "flights", Element(span, Integer(0))),
            Declare("const long", "first", Element(span, Integer(1))),
            Declare(face.state_struct, "state", None),
            Declare(face.input_struct, "input", None),
            Declare(face.output_struct, "output", None),
            *self._each_lane(self._slots(into=False)),
            Repeat("t", Element(span, Integer(2)), tuple(inside), "long"),
            *self._each_lane(self._slots(into=True), True),
        ]
        used = {"slots": self.program.states, "in": self.program.inputs, "out": outputs}
        unused = [name for name, there in used.items() if not there] + (["flights", "first"] if not self.lanes else [])
        unused += [f"{name}_step" for name in ("in", "out") if not used[name]]
        body += [Do(Call("(void)", (Variable(name),))) for name in unused]
        parameters = (
            Parameter("double *", "slots"),
            Parameter("const long *", "span"),
            Parameter("const double *const *", "in"),
            Parameter("const long *", "in_step"),
            Parameter(f"{self.real} *const *", "out"),
            Parameter("const long *", "out_step"),
        )
        return Function("void", ENTRY, parameters, tuple(body), False)

    def _numbered(self, ports: tuple[ProgramPort, ...]) -> enumerate[tuple[ProgramPort, str]]:
        names = self.face.inputs if ports is self.program.inputs else self.face.outputs
        return enumerate(zip(ports, names, strict=True))

    def _each_lane(self, statements: list[Statement], only_flights: bool = False) -> list[Statement]:
        """For one flight as they are; for lanes in a loop. Lanes beyond the last flight repeat it, and give nothing."""
        if not self.lanes or not statements:
            return statements
        here = Binary("+", Variable("first"), _LANE)
        there = Binary("<", here, Variable("flights"))
        last = Binary("-", Variable("flights"), Integer(1))
        inner: tuple[Statement, ...] = (
            Declare("const long", "f", Conditional(there, here, last)),
            *((When(there, tuple(statements)),) if only_flights else statements),
        )
        return [Repeat("l", Integer(self.lanes.count), inner, "long")]

    def _slots(self, into: bool) -> list[Statement]:
        statements: list[Statement] = []
        for field in self.face.states:
            slot = Binary("+", Integer(field.first), _ELEMENT)
            if self.lanes:
                slot = Binary("+", Binary("*", slot, Variable("flights")), _FLIGHT)
            remembered = Element(Variable("slots"), slot)
            here = self._lane(Element(Member(Variable("state"), field.name), _ELEMENT))
            if into:
                move = Assign(remembered, self._given_back(here, field.boolean, "double"))
            else:
                move = Assign(here, self._taken(remembered, field.boolean))
            statements.append(Repeat("k", Integer(field.size), (move,), "long"))
        return statements

    def _input(self, p: int, port: ProgramPort, name: str) -> Statement:
        here: Expression = Member(Variable("input"), name)
        given = Element(Element(Variable("in"), Integer(p)), self._place("in_step", p, bool(port.type.shape)))
        if not port.type.shape:
            return Assign(self._lane(here), self._taken(given, port.type.boolean))
        move = Assign(self._lane(Element(here, _ELEMENT)), self._taken(given, port.type.boolean))
        return Repeat("k", Integer(port.type.size), (move,), "long")

    def _output(self, p: int, port: ProgramPort, name: str) -> Statement:
        here: Expression = Member(Variable("output"), name)
        place = self._place("out_step", p, bool(port.type.shape))
        target = Element(Element(Variable("out"), Integer(p)), place)
        if not port.type.shape:
            return Assign(target, self._given_back(self._lane(here), port.type.boolean, self.real))
        value = self._given_back(self._lane(Element(here, _ELEMENT)), port.type.boolean, self.real)
        return Repeat("k", Integer(port.type.size), (Assign(target, value),), "long")

    def _place(self, steps: str, p: int, elements: bool) -> Expression:
        place: Expression = Binary("*", _FRAME, Element(Variable(steps), Integer(2 * p + 1)))
        if self.lanes:
            place = Binary("+", place, Binary("*", _FLIGHT, Element(Variable(steps), Integer(2 * p))))
        return Binary("+", place, _ELEMENT) if elements else place

    def _lane(self, value: Expression) -> Expression:
        return Element(value, _LANE) if self.lanes else value

    def _taken(self, value: Expression, boolean: bool) -> Expression:
        """A number of an array as a value; anything but zero is true, also NaN."""
        if not boolean:
            return value if self.real == "double" else Cast(self.real, value)
        return Conditional(Binary("!=", value, Real(0.0, 64)), Integer(-1 if self.lanes else 1), Integer(0))

    def _given_back(self, value: Expression, boolean: bool, kind: str) -> Expression:
        if boolean:
            bits = 64 if kind == "double" else 32
            return Conditional(value, Real(1.0, bits), Real(0.0, bits))
        return value if kind == self.real else Cast(kind, value)
