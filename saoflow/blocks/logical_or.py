"""``or``: a decision symbol; true if any operand is true."""

from __future__ import annotations

from typing import ClassVar

from saoflow.blocks.gate import Gate
from saoflow.blocks.symbol import Port
from saoflow.operations import Kind


class LogicalOr(Gate):
    """See :class:`saoflow.blocks.gate.Gate`."""

    name: ClassVar[str] = "or"
    kind: ClassVar[Kind] = Kind.OR
    summary: ClassVar[str] = "true if any operand is true"
    equation: ClassVar[str] = "y = u1 ∨ u2 ∨ ..."
    glyph: ClassVar[str] = '<text class="sign">≥1</text>'
    examples: ClassVar[tuple[str, ...]] = ("{or: [p, q]}",)
    ports: ClassVar[tuple[Port, ...]] = (Port("u", "a boolean", boolean=True),)
    variadic: ClassVar[bool] = True
