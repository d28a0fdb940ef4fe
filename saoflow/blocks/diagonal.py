"""``diagonal``: a diagonal matrix from a vector. Wiring: costs nothing, and its zeros are structure."""

from __future__ import annotations

from typing import ClassVar

from saoflow.blocks.symbol import Arguments, Port, Symbol, SymbolProblem, connected, need_real, need_room, present
from saoflow.operations import ZERO, Expander, Tensor
from saoflow.units import Unit, collapse
from saoflow.wires import WireType, shape_text


class Diagonal(Symbol[None]):
    """In an operand it is written ``diag(R)``."""

    name: ClassVar[str] = "diagonal"
    summary: ClassVar[str] = "the diagonal matrix of a vector; as an operand: diag(R)"
    equation: ClassVar[str] = "y_ii = u_i, y_ij = 0"
    glyph: ClassVar[str] = '<path class="stroke" d="M-10-14H-14V14H-10M10-14H14V14H10M-8-8L8 8"/>'
    examples: ClassVar[tuple[str, ...]] = ("{diagonal: v}",)
    ports: ClassVar[tuple[Port, ...]] = (Port("u", "a vector"),)

    def configure(self, arguments: Arguments, signs: tuple[int, ...]) -> None:
        """Nothing to configure."""

    def output_type(self, inputs: tuple[WireType | None, ...], configuration: None) -> WireType:
        """n x n. Elements off the diagonal are plain zeros: they state no unit. Raises SymbolProblem E204."""
        need_real(inputs, self.name)
        (wire,) = present(inputs)
        if len(wire.shape) != 1:
            raise SymbolProblem(
                "E204",
                "`diagonal` takes a vector",
                f"the operand is {shape_text(wire.shape)}",
                "join scalars with concatenate first",
                operand=0,
            )
        n = wire.shape[0]
        need_room(n * n, "the diagonal matrix")
        flat: list[Unit | None] = [None] * (n * n)
        flat[:: n + 1] = wire.element_units()
        return WireType((n, n), False, collapse(flat))

    def expand(
        self, inputs: tuple[Tensor | None, ...], output: WireType, configuration: None, emit: Expander
    ) -> Tensor:
        """Atoms on the diagonal, structural zeros elsewhere."""
        (u,) = connected(inputs)
        n = len(u.atoms)
        return Tensor((n, n), tuple(u.atoms[r] if r == c else ZERO for r in range(n) for c in range(n)))
