"""``switch``: a decision symbol; one of two values by a condition. Both are computed: every frame costs the same."""

from __future__ import annotations

from typing import ClassVar

from saoflow.blocks.elementwise import common_shape, common_units, element
from saoflow.blocks.symbol import Arguments, Port, Symbol, SymbolProblem, connected, need_boolean, present
from saoflow.operations import Expander, Tensor
from saoflow.wires import WireType


class Switch(Symbol[None]):
    """No parameters."""

    name: ClassVar[str] = "switch"
    profile: ClassVar[str] = "sao"
    summary: ClassVar[str] = "passes the first value if the condition is true, else the second"
    equation: ClassVar[str] = "y = condition ? a : b"
    glyph: ClassVar[str] = '<path class="stroke" d="M-18-10H-9M-18 10H-9M9 0H18M-9-10L9 0"/><circle class="dot" cx="-9" cy="-10" r="2"/><circle class="dot" cx="-9" cy="10" r="2"/>'
    examples: ClassVar[tuple[str, ...]] = (
        "{switch: [p, x, y]}",
        "{switch: [p, v, 0]}",
    )
    ports: ClassVar[tuple[Port, ...]] = (
        Port("condition", "which of the two", boolean=True),
        Port("a", "the value if true"),
        Port("b", "the value if false"),
    )

    def configure(self, arguments: Arguments, signs: tuple[int, ...]) -> None:
        """Nothing to configure."""

    def output_type(self, inputs: tuple[WireType | None, ...], configuration: None) -> WireType:
        """The common shape of all three; the kind and unit of the two values. Raises SymbolProblem E210."""
        condition, a, b = present(inputs)
        need_boolean((condition,), self.name)
        shape = common_shape(inputs, self.name)
        if a.boolean != b.boolean:
            raise SymbolProblem(
                "E210",
                "`switch` needs two values of one kind",
                f"one is {a}, the other is {b}",
                "make both real or both boolean",
                operand=2,
            )
        return WireType(shape, a.boolean, common_units((None, a, b), shape, self.name))

    def expand(
        self, inputs: tuple[Tensor | None, ...], output: WireType, configuration: None, emit: Expander
    ) -> Tensor:
        """One selection per element."""
        condition, a, b = connected(inputs)
        atoms = (emit.select(element(condition, i), element(a, i), element(b, i)) for i in range(output.size))
        return Tensor(output.shape, tuple(atoms))
