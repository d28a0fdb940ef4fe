"""A sheet as it was read: names, expressions and positions; nothing is resolved yet."""

from __future__ import annotations

from dataclasses import dataclass

from saoflow.diagnosis import Position
from saoflow.diagrams.expression import Expression


@dataclass(frozen=True, slots=True)
class Named:
    """A word with its place."""

    text: str
    position: Position


@dataclass(frozen=True, slots=True)
class UnitText:
    """A unit as written: one for the whole wire (``kt/s``), or one per element (nested as the shape)."""

    items: tuple[UnitText, ...] | str
    position: Position


@dataclass(frozen=True, slots=True)
class Argument:
    """``key: value`` of a block, or of a parameter given to a sheet: an expression, or an option's word.

    The reader keeps the raw word beside the parsed expression: which of the two is meant, the symbol decides.
    """

    name: Named
    value: Expression | None
    """None if the text is no expression; then ``text`` is what was written."""
    text: str
    position: Position
    """Of the value."""


@dataclass(frozen=True, slots=True)
class ParameterDeclaration:
    """A parameter of a sheet: a default, or ``inherited`` (taken from the sheet that uses this one), or neither (must be given)."""

    name: Named
    value: Expression | None
    inherited: bool
    unit: UnitText | None
    doc: str
    source: str
    """Where the number comes from, or why it is so (key ``source``)."""
    range: Expression | None = None
    """``[least, most]`` that every element must lie in."""


@dataclass(frozen=True, slots=True)
class InputDeclaration:
    """An input port. ``shape`` None: whatever is connected; () a scalar."""

    name: Named
    shape: tuple[Expression, ...] | None
    boolean: bool
    unit: UnitText | None
    doc: str


@dataclass(frozen=True, slots=True)
class OutputDeclaration:
    """An output port and the wire that it shows."""

    name: Named
    wire: Expression
    unit: UnitText | None
    doc: str


@dataclass(frozen=True, slots=True)
class Connection:
    """An operand of a block: by position, or by port name."""

    port: Named | None
    wire: Expression


@dataclass(frozen=True, slots=True)
class RateDeclaration:
    """``every: n`` of a block, with ``offset``, ``transition`` and ``held``."""

    every: Expression
    position: Position
    """Of the key ``every``."""
    offset: Expression | None
    """None: not stated, which is 0, or ``auto``."""
    automatic: bool
    """``offset: auto``: saoflow chooses it."""
    transition: Named | None
    """``hold`` or ``delay``; None: not stated, which is diagnosed."""
    held: Expression | None
    """What the outputs are before the first run; None: 0."""


@dataclass(frozen=True, slots=True)
class BlockDeclaration:
    """``name: {symbol: operands, key: value...}``; the symbol may be a sheet."""

    name: Named
    symbol: Named
    operands: tuple[Connection, ...]
    arguments: tuple[Argument, ...]
    doc: str
    rate: RateDeclaration | None = None


@dataclass(frozen=True, slots=True)
class IterationDeclaration:
    """``fold`` (a chain: each instance takes the previous one's output) or ``map`` (independent instances) of a sheet."""

    name: Named
    kind: str
    """``fold`` or ``map``."""
    sheet: Named
    count: Expression
    reverse: bool
    carry: tuple[Connection, ...]
    each: tuple[Connection, ...]
    common: tuple[Connection, ...]
    """Key ``in``: the same wire for all instances."""
    arguments: tuple[Argument, ...]
    """Parameters given to the sheet; ``index`` in them is the instance's number from 0."""
    doc: str


@dataclass(frozen=True, slots=True)
class BudgetDeclaration:
    """``budget:``: limits by kind of operation (``multiply: 800``), ``operations`` in total, and the frame ``period`` in s."""

    limits: tuple[tuple[Named, Expression], ...]
    period: Expression | None
    position: Position


@dataclass(frozen=True, slots=True)
class Sheet:
    """One YAML diagram, read."""

    name: Named
    file: str
    doc: str
    equations: str
    profile: Named | None
    parameters: tuple[ParameterDeclaration, ...]
    inputs: tuple[InputDeclaration, ...]
    blocks: tuple[BlockDeclaration | IterationDeclaration, ...]
    outputs: tuple[OutputDeclaration, ...]
    budget: BudgetDeclaration | None
    lines: tuple[str, ...]
    """The text, line by line, for messages."""
    parameters_of: Named | None = None
    """A sheet whose parameters this one has too; those declared here take the place of its own."""

    def __hash__(self) -> int:
        return id(self)

    def __eq__(self, other: object) -> bool:
        return self is other
