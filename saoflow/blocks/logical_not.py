"""``not``: a decision symbol; true if the operand is false."""

from __future__ import annotations

from typing import ClassVar

from saoflow.blocks.elementwise import common_shape
from saoflow.blocks.symbol import Arguments, Port, Symbol, connected, need_boolean
from saoflow.operations import Expander, Kind, Tensor
from saoflow.wires import WireType


class LogicalNot(Symbol[None]):
    """No parameters."""

    name: ClassVar[str] = "not"
    profile: ClassVar[str] = "sao"
    summary: ClassVar[str] = "true if the operand is false"
    equation: ClassVar[str] = "y = ¬u"
    examples: ClassVar[tuple[str, ...]] = ("{not: p}",)
    ports: ClassVar[tuple[Port, ...]] = (Port("u", "a boolean", boolean=True),)

    def configure(self, arguments: Arguments, signs: tuple[int, ...]) -> None:
        """Nothing to configure."""

    def output_type(self, inputs: tuple[WireType | None, ...], configuration: None) -> WireType:
        """Boolean, of the common shape."""
        need_boolean(inputs, self.name)
        return WireType(common_shape(inputs, self.name), True)

    def expand(
        self, inputs: tuple[Tensor | None, ...], output: WireType, configuration: None, emit: Expander
    ) -> Tensor:
        """One negation per element."""
        (u,) = connected(inputs)
        return Tensor(output.shape, tuple(emit.logic(Kind.NOT, atom) for atom in u.atoms))
