"""What is drawn of one sheet instance: blocks with their ports, and where each port's value comes from.

A drawing holds names, wire numbers of the netlist and places in the YAML; no coordinates: the layout is found where it
is shown.
"""

from __future__ import annotations

from dataclasses import dataclass

from saoflow.diagnosis import Position


@dataclass(frozen=True, slots=True)
class Source:
    """Where a value comes from: an output port of a block of the same drawing, or an input of the drawing (block -1)."""

    block: int
    port: int


@dataclass(frozen=True, slots=True)
class InputOfBlock:
    """One connected input of a block."""

    name: str
    """The port's name; empty for a symbol's only kind of operand."""
    text: str
    """The operand as the sheet writes it, where it is more than the name of a wire: ``C.T``, ``dx[:-1]``, ``-K``, a number."""
    wire: int
    """Its wire in the netlist's body."""
    sources: tuple[Source, ...]
    """Several where a slice or a list joins wires; none for a number."""
    carried: bool = False
    """Of a stack: each instance takes this from the one before."""


@dataclass(frozen=True, slots=True)
class OutputOfBlock:
    """One output of a block."""

    name: str
    wire: int
    wires: tuple[int, ...] = ()
    """Of a stack: the wire of every instance."""


@dataclass(frozen=True, slots=True)
class Block:
    """A symbol, a sub-sheet, or the stack of instances of a fold or map."""

    name: str
    kind: str
    """``symbol``, ``sheet`` or ``stack``."""
    of: str
    """The symbol's or the sheet's name."""
    glyph: str
    """SVG inside a box of 48 by 48 about the origin; empty for a sheet."""
    inputs: tuple[InputOfBlock, ...]
    outputs: tuple[OutputOfBlock, ...]
    position: Position
    inside: int | None
    """The number of the drawing of what is inside."""
    call: str
    """The path of the netlist's node, if the sheet is called (not laid out in place)."""
    count: int = 1
    """Instances of a stack."""
    feeds_through: bool = True
    rate: str = ""
    """``every 2 from 1``, of what runs at a rate of its own."""
    table: tuple[tuple[float, float], ...] = ()
    """Of a table: the ends of its axes."""


@dataclass(frozen=True, slots=True)
class Terminal:
    """An input or output of the drawing."""

    name: str
    wire: int
    doc: str
    text: str = ""
    """Of an output: the wire that it shows, as written."""
    sources: tuple[Source, ...] = ()


@dataclass(frozen=True, slots=True)
class WireShown:
    """Type of a wire, for people."""

    shape: tuple[int, ...]
    unit: str
    boolean: bool


@dataclass(frozen=True, slots=True)
class Drawing:
    """One sheet instance, or one stack opened."""

    sheet: str
    kind: str
    """``sheet`` or ``stack``."""
    doc: str
    equations: str
    position: Position
    body: int
    """The netlist body that its wire numbers are of."""
    blocks: tuple[Block, ...]
    inputs: tuple[Terminal, ...]
    outputs: tuple[Terminal, ...]
    left_out: int = 0
    """How many instances of a very long stack are not shown."""


@dataclass(frozen=True, slots=True, eq=False)
class Drawings:
    """All drawings of a sheet; the first is the sheet itself. ``wires`` holds the types by body and wire."""

    drawings: tuple[Drawing, ...]
    wires: tuple[tuple[WireShown | None, ...], ...]
