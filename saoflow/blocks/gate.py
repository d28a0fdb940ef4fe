"""What ``and``, ``or`` and ``not`` share: booleans in, a boolean of the common shape out."""

from __future__ import annotations

from functools import reduce
from typing import ClassVar

from saoflow.blocks.elementwise import common_shape, element
from saoflow.blocks.symbol import Arguments, Symbol, connected, need_boolean
from saoflow.operations import Atom, Expander, Kind, Tensor
from saoflow.wires import WireType


class Gate(Symbol[None]):
    """No parameters; ``kind`` is the scalar operation."""

    kind: ClassVar[Kind]
    profile: ClassVar[str] = "sao"

    def configure(self, arguments: Arguments, signs: tuple[int, ...]) -> None:
        """Nothing to configure."""

    def output_type(self, inputs: tuple[WireType | None, ...], configuration: None) -> WireType:
        """Boolean, of the common shape. Raises SymbolProblem E204, E210."""
        need_boolean(inputs, self.name)
        return WireType(common_shape(inputs, self.name), True)

    def expand(
        self, inputs: tuple[Tensor | None, ...], output: WireType, configuration: None, emit: Expander
    ) -> Tensor:
        """Left to right, per element."""
        operands = connected(inputs)
        if self.kind is Kind.NOT:
            return Tensor(output.shape, tuple(emit.logic(self.kind, atom) for atom in operands[0].atoms))

        def joined(i: int) -> Atom:
            atoms = [element(u, i) for u in operands]
            return reduce(lambda a, b: emit.logic(self.kind, a, b), atoms)

        return Tensor(output.shape, tuple(joined(i) for i in range(output.size)))
