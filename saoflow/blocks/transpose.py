"""``transpose``: rows become columns. Wiring: costs nothing."""

from __future__ import annotations

from typing import ClassVar

import numpy as np

from saoflow.blocks.symbol import Arguments, Port, Symbol, SymbolProblem, connected, present
from saoflow.operations import Expander, Tensor
from saoflow.units import collapse
from saoflow.wires import WireType, shape_text


class Transpose(Symbol[None]):
    """In an operand it is written ``C.T``."""

    name: ClassVar[str] = "transpose"
    summary: ClassVar[str] = "the transpose of a matrix; as an operand: C.T"
    equation: ClassVar[str] = "y_ij = u_ji"
    glyph: ClassVar[str] = '<text class="sign">M<tspan class="up" dy="-7">T</tspan></text>'
    examples: ClassVar[tuple[str, ...]] = ("{transpose: A}",)
    ports: ClassVar[tuple[Port, ...]] = (Port("u", "a matrix"),)

    def configure(self, arguments: Arguments, signs: tuple[int, ...]) -> None:
        """Nothing to configure."""

    def output_type(self, inputs: tuple[WireType | None, ...], configuration: None) -> WireType:
        """Raises SymbolProblem E204 for anything but a matrix."""
        (wire,) = present(inputs)
        if len(wire.shape) != 2:
            raise SymbolProblem(
                "E204",
                "only a matrix has a transpose",
                f"the operand is {shape_text(wire.shape)}",
                "leave out .T: a vector serves as row and as column",
                operand=0,
            )
        units = wire.units
        if isinstance(units, tuple):
            units = collapse([units[int(i)] for i in _order(wire.shape)])
        return WireType((wire.shape[1], wire.shape[0]), wire.boolean, units)

    def expand(
        self, inputs: tuple[Tensor | None, ...], output: WireType, configuration: None, emit: Expander
    ) -> Tensor:
        """Reorders atoms."""
        (u,) = connected(inputs)
        return Tensor(output.shape, tuple(u.atoms[int(i)] for i in _order(u.shape)))


def _order(shape: tuple[int, ...]) -> np.ndarray:
    return np.arange(shape[0] * shape[1]).reshape(shape).T.ravel()
