"""Elaborated sheets: first the structure (what is wired to what), then the body (with the type of every wire).

A body is a sheet for one set of parameter numbers and input types. Its nodes are symbols, and calls of stateless sheets,
which are bodies of their own; sheets with state are laid out in place, so that a delay inside one can break a loop
around it.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from saoflow.diagnosis import Position
from saoflow.units import Units
from saoflow.wires import WireType

if TYPE_CHECKING:
    from saoflow.blocks.library import AnySymbol

POISON = -1
"""The wire of something that is already diagnosed: what hangs on it is not diagnosed again."""


@dataclass(frozen=True, slots=True)
class Rate:
    """When a node runs: in frames ``offset``, ``offset + every``, ...; between runs its outputs keep their values."""

    every: int
    offset: int | None
    """None: chosen to balance the frames."""
    held: float
    """What real outputs are before the first run; boolean ones are false."""


@dataclass(frozen=True, slots=True)
class Node:
    """One block: a symbol, or a call of a stateless sheet. ``path`` is its path inside its body: ``stages[1].K``."""

    path: str
    position: Position
    symbol: AnySymbol | None
    configuration: Any
    child: Structure | None
    inputs: tuple[int | None, ...]
    """Wire numbers; None for an optional port left open."""
    operand_positions: tuple[Position | None, ...]
    outputs: tuple[int, ...]
    declared: InputPort | OutputPort | None = None
    """The port of a sheet laid out in place that this wiring stands for: its declaration is checked here."""
    rate: Rate | None = None
    """Of a called sheet, which may then hold state: the frames in which it runs. None: every frame."""

    @property
    def feeds_through(self) -> bool:
        """Whether the outputs depend on the inputs within the frame."""
        return self.symbol is None or self.symbol.feeds_through


@dataclass(frozen=True, slots=True)
class InputPort:
    """A declared input: its wire and what is declared of its type (shape None: whatever is connected)."""

    name: str
    wire: int
    shape: tuple[int, ...] | None
    boolean: bool
    units: Units
    doc: str
    position: Position


@dataclass(frozen=True, slots=True)
class OutputPort:
    """A declared output: the wire that it shows, and its declared unit."""

    name: str
    wire: int
    units: Units
    doc: str
    position: Position


@dataclass(frozen=True, slots=True)
class Budget:
    """Limits of a frame: (kind or ``operations``, most), and the frame period in s (None: not stated)."""

    limits: tuple[tuple[str, float], ...]
    period: float | None
    position: Position


@dataclass(frozen=True, slots=True, eq=False)
class Structure:
    """A sheet with its parameters as numbers: nodes and wires, types not yet known."""

    sheet: str
    file: str
    doc: str
    position: Position
    inputs: tuple[InputPort, ...]
    outputs: tuple[OutputPort, ...]
    nodes: tuple[Node, ...]
    wire_count: int
    stateful: bool
    symbols_used: frozenset[str]
    budget: Budget | None


@dataclass(frozen=True, slots=True, eq=False)
class Body:
    """A structure with the type of every wire. ``children[i]`` is the body that node i calls, if it calls one."""

    structure: Structure
    types: tuple[WireType | None, ...]
    """By wire number; None where an algebraic loop hides the type."""
    children: tuple[Body | None, ...]

    @property
    def nodes(self) -> tuple[Node, ...]:
        """The nodes, in the order of the sheet."""
        return self.structure.nodes

    def type_of(self, wire: int) -> WireType:
        """The type of a wire of a complete body."""
        found = self.types[wire]
        assert found is not None
        return found


@dataclass(frozen=True, slots=True, eq=False)
class Netlist:
    """A root sheet with its whole hierarchy elaborated."""

    root: Body
    parameters: tuple[tuple[str, str], ...]
    """Name and value of the root's parameters, for reports."""
    sources: SourceLines


@dataclass(slots=True)
class SourceLines:
    """The text of every sheet that was read, for messages."""

    _lines: dict[str, tuple[str, ...]] = field(default_factory=dict)

    def add(self, file: str, lines: tuple[str, ...]) -> None:
        """Remember the text of a file."""
        self._lines[file] = lines

    def lines(self, file: str) -> tuple[str, ...]:
        """The text of a file; nothing if it was not read."""
        return self._lines.get(file, ())

    @property
    def files(self) -> tuple[str, ...]:
        """Every file that was read."""
        return tuple(self._lines)

    def line(self, position: Position | None) -> str | None:
        """The line at a position, if its file was read."""
        if position is None or position.file not in self._lines:
            return None
        lines = self._lines[position.file]
        return lines[position.line - 1] if 0 < position.line <= len(lines) else None

    def word(self, position: Position | None) -> str:
        """The text that a position covers."""
        text = self.line(position)
        if text is None or position is None:
            return "operand"
        start, end = position.column - 1, position.column - 1 + position.length
        if text[start - 1 : start] == ".":  # a member: the whole path is meant
            while start and (text[start - 1].isalnum() or text[start - 1] in "._"):
                start -= 1
        return text[start:end]


def flat_nodes(body: Body, prefix: str = "") -> Iterator[tuple[str, Node, Body]]:
    """Every symbol of every instance with its full path, its node and the body it stands in."""
    stack: list[tuple[Body, str]] = [(body, prefix)]
    while stack:
        here, path = stack.pop()
        for node, child in zip(here.nodes, here.children, strict=True):
            if child is None:
                yield path + node.path, node, here
            else:
                stack.append((child, f"{path}{node.path}."))


def count_instances(netlist: Netlist) -> tuple[int, int]:
    """How many blocks and how many sub-sheets a root sheet contains, every instance of a fold or map counted.

    Wiring inside operands (``C.T``) is no block.
    """
    known: dict[int, tuple[int, int]] = {}
    stack = [netlist.root]
    while stack:
        body = stack[-1]
        below = [child for child in body.children if child is not None]
        waiting = [child for child in below if id(child) not in known]
        if waiting:
            stack.extend(waiting)
            continue
        stack.pop()
        own = sum(1 for node in body.nodes if node.child is None and "#" not in node.path)
        blocks = own + sum(known[id(child)][0] for child in below)
        placed = {instance for node in body.nodes for instance in _instances(node.path)}
        known[id(body)] = (blocks, len(placed) + len(below) + sum(known[id(child)][1] for child in below))
    return known[id(netlist.root)]


def _instances(path: str) -> Iterator[str]:
    """The sheet instances that were laid out in place around a node: ``a`` and ``a.b[1]`` of ``a.b[1].c``."""
    end = path.rfind(".")
    while end > 0:
        yield path[:end]
        end = path.rfind(".", 0, end)
