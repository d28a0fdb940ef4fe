"""``add``: the sum of any number of operands, each with a sign."""

from __future__ import annotations

from typing import ClassVar

from saoflow.blocks.elementwise import common_shape, common_units, element
from saoflow.blocks.summation import signed_sum
from saoflow.blocks.symbol import Arguments, Port, Symbol, connected, need_real
from saoflow.operations import Expander, Tensor
from saoflow.wires import WireType


class Add(Symbol[tuple[int, ...]]):
    """Configured by the signs of its operands."""

    name: ClassVar[str] = "add"
    summary: ClassVar[str] = "sum of the operands, left to right; write -x to subtract"
    equation: ClassVar[str] = "y = ± u1 ± u2 ± ..."
    glyph: ClassVar[str] = '<text class="sign">Σ</text>'
    examples: ClassVar[tuple[str, ...]] = (
        "{add: [x, y, -z]}",
        "{add: [v, -w]}",
    )
    ports: ClassVar[tuple[Port, ...]] = (Port("u", "an operand; a scalar is added to every element"),)
    variadic: ClassVar[bool] = True
    takes_signs: ClassVar[bool] = True

    def configure(self, arguments: Arguments, signs: tuple[int, ...]) -> tuple[int, ...]:
        """The signs, +1 or -1, as written."""
        return signs

    def output_type(self, inputs: tuple[WireType | None, ...], configuration: tuple[int, ...]) -> WireType:
        """The common shape and unit."""
        need_real(inputs, self.name)
        shape = common_shape(inputs, self.name)
        return WireType(shape, False, common_units(inputs, shape, self.name))

    def expand(
        self,
        inputs: tuple[Tensor | None, ...],
        output: WireType,
        configuration: tuple[int, ...],
        emit: Expander,
    ) -> Tensor:
        """One signed sum per element."""
        operands = connected(inputs)
        atoms = (
            signed_sum(((s, element(u, i)) for s, u in zip(configuration, operands, strict=True)), emit)
            for i in range(output.size)
        )
        return Tensor(output.shape, tuple(atoms))
