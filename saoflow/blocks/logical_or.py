"""``or``: a decision symbol; true if any operand is true."""

from __future__ import annotations

from functools import reduce
from typing import ClassVar

from saoflow.blocks.elementwise import common_shape, element
from saoflow.blocks.symbol import Arguments, Port, Symbol, connected, need_boolean
from saoflow.operations import Atom, Expander, Kind, Tensor
from saoflow.wires import WireType


class LogicalOr(Symbol[None]):
    """No parameters."""

    name: ClassVar[str] = "or"
    profile: ClassVar[str] = "sao"
    summary: ClassVar[str] = "true if any operand is true"
    equation: ClassVar[str] = "y = u1 ∨ u2 ∨ ..."
    examples: ClassVar[tuple[str, ...]] = ("{or: [p, q]}",)
    ports: ClassVar[tuple[Port, ...]] = (Port("u", "a boolean", boolean=True),)
    variadic: ClassVar[bool] = True

    def configure(self, arguments: Arguments, signs: tuple[int, ...]) -> None:
        """Nothing to configure."""

    def output_type(self, inputs: tuple[WireType | None, ...], configuration: None) -> WireType:
        """Boolean, of the common shape."""
        need_boolean(inputs, self.name)
        return WireType(common_shape(inputs, self.name), True)

    def expand(
        self, inputs: tuple[Tensor | None, ...], output: WireType, configuration: None, emit: Expander
    ) -> Tensor:
        """Left to right, per element."""
        operands = connected(inputs)

        def both(a: Atom, b: Atom) -> Atom:
            return emit.logic(Kind.OR, a, b)

        atoms = (
            reduce(both, (element(u, i) for u in operands[1:]), element(operands[0], i)) for i in range(output.size)
        )
        return Tensor(output.shape, tuple(atoms))
