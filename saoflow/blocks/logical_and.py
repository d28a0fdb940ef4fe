"""``and``: a decision symbol; true if every operand is true."""

from __future__ import annotations

from typing import ClassVar

from saoflow.blocks.gate import Gate
from saoflow.blocks.symbol import Port
from saoflow.operations import Kind


class LogicalAnd(Gate):
    """See :class:`saoflow.blocks.gate.Gate`."""

    name: ClassVar[str] = "and"
    kind: ClassVar[Kind] = Kind.AND
    summary: ClassVar[str] = "true if every operand is true"
    equation: ClassVar[str] = "y = u1 ∧ u2 ∧ ..."
    glyph: ClassVar[str] = '<text class="sign">&amp;</text>'
    examples: ClassVar[tuple[str, ...]] = ("{and: [p, q]}",)
    ports: ClassVar[tuple[Port, ...]] = (Port("u", "a boolean", boolean=True),)
    variadic: ClassVar[bool] = True
