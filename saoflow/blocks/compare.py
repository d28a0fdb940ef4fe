"""``compare``: a decision symbol; an order relation between two reals."""

from __future__ import annotations

from typing import ClassVar

from saoflow.blocks.elementwise import common_shape, common_units, element
from saoflow.blocks.symbol import Arguments, Parameter, Port, Symbol, connected, need_real, word_of
from saoflow.operations import Expander, Tensor
from saoflow.wires import WireType

RELATION = Parameter("relation", "word", "the relation between a and b", (">", ">=", "<", "<="))


class Compare(Symbol[str]):
    """Configured by its relation."""

    name: ClassVar[str] = "compare"
    profile: ClassVar[str] = "sao"
    summary: ClassVar[str] = "is the relation true? with NaN it is false"
    equation: ClassVar[str] = "y = (a relation b)"
    glyph: ClassVar[str] = '<text class="sign">&lt;</text>'
    examples: ClassVar[tuple[str, ...]] = (
        '{compare: [x, y], relation: ">"}',
        '{compare: [v, 0], relation: "<="}',
    )
    ports: ClassVar[tuple[Port, ...]] = (Port("a", "left side"), Port("b", "right side"))
    parameters: ClassVar[tuple[Parameter, ...]] = (RELATION,)

    def configure(self, arguments: Arguments, signs: tuple[int, ...]) -> str:
        """The relation. Raises SymbolProblem E208."""
        return word_of(arguments, RELATION)

    def glyph_of(self, configuration: str) -> str:
        """The relation."""
        shown = {"<": "&lt;", ">": "&gt;", "<=": "≤", ">=": "≥"}[configuration]
        return f'<text class="sign">{shown}</text>'

    def output_type(self, inputs: tuple[WireType | None, ...], configuration: str) -> WireType:
        """Boolean, of the common shape; both sides in one unit."""
        need_real(inputs, self.name)
        shape = common_shape(inputs, self.name)
        common_units(inputs, shape, self.name)
        return WireType(shape, True)

    def expand(self, inputs: tuple[Tensor | None, ...], output: WireType, configuration: str, emit: Expander) -> Tensor:
        """One comparison per element."""
        a, b = connected(inputs)
        atoms = (emit.compare(configuration, element(a, i), element(b, i)) for i in range(output.size))
        return Tensor(output.shape, tuple(atoms))
