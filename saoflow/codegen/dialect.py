"""How scalar operations are written: for one flight in plain C99, or for a register of flights side by side.

Both compute the same bits: a lane does what the scalar code does. Lanes use the vectors of gcc and clang, whose
comparisons give masks; a selection takes bits by mask. They are for this machine only and never fly.
"""

from __future__ import annotations

from typing import Protocol

from saoflow.codegen.tree import (
    Binary,
    Call,
    Cast,
    Compound,
    Conditional,
    Element,
    Expression,
    Function,
    Integer,
    Item,
    Not,
    Parameter,
    Real,
    Return,
    Statement,
    TypeAlias,
    Variable,
)
from saoflow.operations import Kind, Literal

ARITHMETIC = {Kind.ADD: "+", Kind.SUBTRACT: "-", Kind.MULTIPLY: "*"}
RELATIONS = {Kind.LESS: "<", Kind.LESS_EQUAL: "<="}
LOGIC = {Kind.AND: "&&", Kind.OR: "||"}
BITWISE = {Kind.AND: "&", Kind.OR: "|"}


class Dialect(Protocol):
    """The types of values, literals, and every operation but look-ups, state and calls."""

    real: str
    boolean: str
    bits: int

    def literal(self, literal: Literal) -> Expression:
        """A constant as an operand of anything."""
        ...

    def operation(self, kind: Kind, operands: list[Expression], boolean: bool) -> Expression:
        """The value of an operation; ``boolean``: whether the result is one."""
        ...

    def whether(self, guard: Expression) -> Expression:
        """The condition of an ``if`` from a boolean that is the same in all flights."""
        ...


class Scalar:
    """Plain C99: ``double`` or ``float``, and ``_Bool``."""

    def __init__(self, bits: int) -> None:
        self.bits = bits
        self.real = "double" if bits == 64 else "float"
        self.boolean = "_Bool"

    def literal(self, literal: Literal) -> Expression:
        """A number, exactly; 0 or 1."""
        if isinstance(literal.value, bool):
            return Integer(int(literal.value))
        return Real(literal.value, self.bits)

    def operation(self, kind: Kind, operands: list[Expression], boolean: bool) -> Expression:
        """One C expression without side effects."""
        for written in (ARITHMETIC, RELATIONS, LOGIC):
            if kind in written:
                return Binary(written[kind], operands[0], operands[1])
        match kind:
            case Kind.RECIPROCAL:
                return Binary("/", Real(1.0, self.bits), operands[0])
            case Kind.MINIMUM:
                return Conditional(Binary("<", operands[0], operands[1]), operands[0], operands[1])
            case Kind.MAXIMUM:
                return Conditional(Binary(">", operands[0], operands[1]), operands[0], operands[1])
            case Kind.NOT:
                return Not(operands[0])
            case _:
                assert kind is Kind.SELECT
                return Conditional(operands[0], operands[1], operands[2])

    def whether(self, guard: Expression) -> Expression:
        """The boolean."""
        return guard


class Lanes:
    """``count`` flights side by side: ``reals`` and masks of the same width, and the helpers that they need."""

    def __init__(self, bits: int, count: int) -> None:
        self.bits = bits
        self.count = count
        self.element = "double" if bits == 64 else "float"
        self.real = "reals"
        self.boolean = "masks"

    def literal(self, literal: Literal) -> Expression:
        """The same constant in every lane."""
        if isinstance(literal.value, bool):
            return Call("every_mask", (Integer(-1 if literal.value else 0),))
        return Call("every_real", (Real(literal.value, self.bits),))

    def operation(self, kind: Kind, operands: list[Expression], boolean: bool) -> Expression:
        """One expression of vectors."""
        if kind in ARITHMETIC:
            return Binary(ARITHMETIC[kind], operands[0], operands[1])
        if kind in RELATIONS:
            return Cast("masks", Binary(RELATIONS[kind], operands[0], operands[1]))
        if kind in BITWISE:
            return Binary(BITWISE[kind], operands[0], operands[1])
        match kind:
            case Kind.RECIPROCAL:
                return Binary("/", Call("every_real", (Real(1.0, self.bits),)), operands[0])
            case Kind.MINIMUM:
                return Call("smaller", tuple(operands))
            case Kind.MAXIMUM:
                return Call("larger", tuple(operands))
            case Kind.NOT:
                return Binary("^", operands[0], Call("every_mask", (Integer(-1),)))
            case _:
                assert kind is Kind.SELECT
                return Call("chosen_mask" if boolean else "chosen", tuple(operands))

    def whether(self, guard: Expression) -> Expression:
        """The first lane's mask."""
        return Binary("!=", Element(guard, Integer(0)), Integer(0))

    def items(self) -> tuple[Item, ...]:
        """The types, and the helpers."""
        size = self.count * self.bits // 8
        whole = "long long" if self.bits == 64 else "int"
        a, b, c = Variable("a"), Variable("b"), Variable("c")
        mask, ra, rb = Parameter("const masks", "c"), Parameter("const reals", "a"), Parameter("const reals", "b")
        ma, mb = Parameter("const masks", "a"), Parameter("const masks", "b")

        def helper(result: str, name: str, parameters: tuple[Parameter, ...], *body: Statement) -> Function:
            return Function(f"inline {result}", name, parameters, body, True)

        def blended(condition: Expression) -> Expression:
            mixed = Binary("^", Cast("masks", a), Cast("masks", b))
            return Cast("reals", Binary("^", Cast("masks", b), Binary("&", condition, mixed)))

        def every(result: str, name: str, kind: str) -> Function:
            lanes = Compound(result, (Variable("x"),) * self.count)
            return helper(result, name, (Parameter(f"const {kind}", "x"),), Return(lanes))

        return (
            TypeAlias("reals", self.element, f"vector_size({size})"),
            TypeAlias("masks", whole, f"vector_size({size})"),
            every("reals", "every_real", self.element),
            every("masks", "every_mask", whole),
            helper("reals", "chosen", (mask, ra, rb), Return(blended(c))),
            helper("masks", "chosen_mask", (mask, ma, mb), Return(Binary("^", b, Binary("&", c, Binary("^", a, b))))),
            helper("reals", "smaller", (ra, rb), Return(blended(Cast("masks", Binary("<", a, b))))),
            helper("reals", "larger", (ra, rb), Return(blended(Cast("masks", Binary(">", a, b))))),
        )
