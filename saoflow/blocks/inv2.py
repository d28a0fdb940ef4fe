"""``inv2``: the inverse of a 2x2 matrix by its adjugate."""

from __future__ import annotations

from typing import ClassVar

from saoflow.blocks.summation import signed_sum
from saoflow.blocks.symbol import Arguments, Port, Symbol, SymbolProblem, connected, need_real, present
from saoflow.operations import MINUS_ONE, Expander, Tensor
from saoflow.units import Unit, Units, collapse, conversion_hint
from saoflow.wires import WireType, shape_text


class Inv2(Symbol[None]):
    """No parameters. A determinant of zero gives infinity and NaN, as the arithmetic has it."""

    name: ClassVar[str] = "inv2"
    summary: ClassVar[str] = "inverse of a 2x2 matrix by its adjugate; of diag(x, 1): one reciprocal"
    equation: ClassVar[str] = "[[a, b], [c, d]]^-1 = [[d, -b], [-c, a]] · (1 / (a d - b c))"
    glyph: ClassVar[str] = '<text class="sign">M<tspan class="up" dy="-7">−1</tspan></text>'
    examples: ClassVar[tuple[str, ...]] = (
        "{inv2: A}",
        '{inv2: "[[x, 0], [0, 1]]"}',
    )
    ports: ClassVar[tuple[Port, ...]] = (Port("u", "a 2x2 matrix"),)

    def configure(self, arguments: Arguments, signs: tuple[int, ...]) -> None:
        """Nothing to configure."""

    def output_type(self, inputs: tuple[WireType | None, ...], configuration: None) -> WireType:
        """2x2; unit of element (i, j): that of the adjugate over the determinant. Raises SymbolProblem E204, E211."""
        need_real(inputs, self.name)
        (wire,) = present(inputs)
        if wire.shape != (2, 2):
            raise SymbolProblem(
                "E204",
                "`inv2` inverts 2x2 matrices",
                f"the operand is {shape_text(wire.shape)}",
                "use the library sheets reciprocal, inverse_4x4, inverse_8x8 for other sizes",
                operand=0,
            )
        return WireType((2, 2), False, _inverse_units(wire))

    def expand(
        self, inputs: tuple[Tensor | None, ...], output: WireType, configuration: None, emit: Expander
    ) -> Tensor:
        """a d, b c, their difference, its reciprocal, then the adjugate times it."""
        (u,) = connected(inputs)
        a, b, c, d = u.atoms
        determinant = signed_sum(((1, emit.multiply(a, d)), (-1, emit.multiply(b, c))), emit)
        r = emit.reciprocal(determinant)
        minus_b = emit.multiply(MINUS_ONE, emit.multiply(b, r))
        minus_c = minus_b if b == c else emit.multiply(MINUS_ONE, emit.multiply(c, r))
        return Tensor((2, 2), (emit.multiply(d, r), minus_b, minus_c, emit.multiply(a, r)))


def _inverse_units(wire: WireType) -> Units:
    if not isinstance(wire.units, tuple):
        return None if wire.units is None else Unit.parse("1") / wire.units
    a, b, c, d = wire.units
    main = a * d if a is not None and d is not None else None
    cross = b * c if b is not None and c is not None else None
    if main is not None and cross is not None and main != cross:
        raise SymbolProblem(
            "E211",
            "the determinant sums different units",
            f"{main} meets {cross}: {conversion_hint(main, cross)}",
            "check the units of the matrix elements",
            operand=0,
        )
    determinant = main if main is not None else cross
    over = [None if u is None or determinant is None else u / determinant for u in (d, b, c, a)]
    return collapse(over)
