"""``not``: a decision symbol; true if the operand is false."""

from __future__ import annotations

from typing import ClassVar

from saoflow.blocks.gate import Gate
from saoflow.blocks.symbol import Port
from saoflow.operations import Kind


class LogicalNot(Gate):
    """See :class:`saoflow.blocks.gate.Gate`."""

    name: ClassVar[str] = "not"
    kind: ClassVar[Kind] = Kind.NOT
    summary: ClassVar[str] = "true if the operand is false"
    equation: ClassVar[str] = "y = ¬u"
    glyph: ClassVar[str] = '<text class="sign">¬</text>'
    examples: ClassVar[tuple[str, ...]] = ("{not: p}",)
    ports: ClassVar[tuple[Port, ...]] = (Port("u", "a boolean", boolean=True),)
