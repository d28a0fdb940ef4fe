"""``saturation``: keeps a value between two limits, constant or wired."""

from __future__ import annotations

from typing import ClassVar

from saoflow.blocks.elementwise import common_shape, common_units, element
from saoflow.blocks.symbol import Arguments, Port, Symbol, SymbolProblem, need_real
from saoflow.operations import Expander, Tensor
from saoflow.wires import WireType


class Saturation(Symbol[None]):
    """Limits are operands: a number, a parameter, or a wire. With one of them only, it is a maximum or a minimum."""

    name: ClassVar[str] = "saturation"
    summary: ClassVar[str] = "limits a value; NaN comes out as the lower limit"
    equation: ClassVar[str] = "y = min(max(u, low), high)"
    glyph: ClassVar[str] = '<path class="stroke" d="M-18 0H18M0-18V18"/><path class="curve" d="M-17 11H-9L9-11H17"/>'
    examples: ClassVar[tuple[str, ...]] = (
        "{saturation: x, low: -1, high: y}",
        "{saturation: v, low: 0}",
    )
    ports: ClassVar[tuple[Port, ...]] = (
        Port("u", "what is limited"),
        Port("low", "lower limit", optional=True),
        Port("high", "upper limit", optional=True),
    )

    def configure(self, arguments: Arguments, signs: tuple[int, ...]) -> None:
        """Nothing to configure."""

    def output_type(self, inputs: tuple[WireType | None, ...], configuration: None) -> WireType:
        """The common shape and unit. Raises SymbolProblem E205 with no limit at all."""
        need_real(inputs, self.name)
        if inputs[1] is None and inputs[2] is None:
            raise SymbolProblem(
                "E205",
                "a saturation needs a limit",
                "neither low nor high is connected",
                "write {saturation: x, low: -1, high: 1}, or only one of the two",
            )
        shape = common_shape(inputs, self.name)
        return WireType(shape, False, common_units(inputs, shape, self.name))

    def expand(
        self, inputs: tuple[Tensor | None, ...], output: WireType, configuration: None, emit: Expander
    ) -> Tensor:
        """The lower limit first, then the upper."""
        u, low, high = inputs
        assert u is not None
        atoms = []
        for i in range(output.size):
            atom = element(u, i)
            if low is not None:
                atom = emit.maximum(atom, element(low, i))
            if high is not None:
                atom = emit.minimum(atom, element(high, i))
            atoms.append(atom)
        return Tensor(output.shape, tuple(atoms))
