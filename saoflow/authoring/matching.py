"""Which block of one sheet is which block of another: by name where the symbol agrees, else by what it does.

Work is proportional to blocks and wires: a block is looked up once, as soon as all that it reads has a partner.
"""

from __future__ import annotations

from collections.abc import Hashable, Iterator
from dataclasses import dataclass, field, fields, is_dataclass
from typing import Any

import numpy as np

from saoflow.diagnosis import Position
from saoflow.diagrams.netlist import Body, Node

WIRING = "#"
"""In the path of a node that stands for an operand (``C.T``, ``v[0]``): it has no name of its own."""


def is_wiring(node: Node) -> bool:
    """Whether a node is none of the blocks that a sheet names: an operand, a number, a port of a sheet laid out in place.

    Two of them that do the same with the same wires are one.
    """
    return WIRING in node.path or node.declared is not None or (node.symbol is not None and node.symbol.name == "constant")


@dataclass(slots=True)
class Matching:
    """Partners of two bodies, from before to after: nodes by number, wires by number."""

    before: Body
    after: Body
    nodes: dict[int, int] = field(default_factory=dict)
    wires: dict[int, int] = field(default_factory=dict)
    waiting: dict[int, int] = field(default_factory=dict)
    """How many inputs without a partner a node has that has no partner itself."""
    readers: dict[int, list[int]] = field(default_factory=dict)
    """The nodes of ``before`` that read a wire."""
    replaced: dict[int, int] = field(default_factory=dict)
    """Blocks of one name with another symbol: what reads them reads the same."""
    alike: dict[int, int] = field(default_factory=dict)
    """Wires of ``after`` that wiring makes anew, and the first that is the same."""
    free: dict[Hashable, list[int]] = field(default_factory=dict)
    """The nodes of ``after`` without a partner, by what they do and read; in the order of the text."""

    def pair(self, old: int, new: int) -> Iterator[int]:
        """Make two nodes partners; gives the nodes that wait for nothing more."""
        self.nodes[old] = new
        for a, b in zip(self.before.nodes[old].outputs, self.after.nodes[new].outputs, strict=False):
            yield from self.join(a, self.first(b))

    def first(self, wire: int) -> int:
        """The first wire of ``after`` that is the same as this one."""
        return self.alike.get(wire, wire)

    def reads(self, new: int) -> tuple[int | None, ...]:
        """The inputs of a node of ``after``."""
        return tuple(None if wire is None else self.first(wire) for wire in self.after.nodes[new].inputs)

    def join(self, a: int, b: int) -> Iterator[int]:
        """Make two wires partners."""
        self.wires[a] = b
        for reader in self.readers.get(a, ()):
            self.waiting[reader] -= 1
            if not self.waiting[reader]:
                yield reader


def match(before: Body, after: Body) -> Matching:
    """Find the partners of two bodies."""
    found = Matching(before, after)
    for number, node in enumerate(before.nodes):
        sources = {wire for wire in node.inputs if wire is not None}
        found.waiting[number] = len(sources)
        for wire in sources:
            found.readers.setdefault(wire, []).append(number)
    ready: list[int] = []
    inputs = {port.name: port.wire for port in after.structure.inputs}
    for port in before.structure.inputs:
        if port.name in inputs:
            ready += found.join(port.wire, found.first(inputs[port.name]))
    named = {(node.path, kind(node)): n for n, node in enumerate(after.nodes) if not is_wiring(node)}
    for number, node in enumerate(before.nodes):
        other = named.pop((node.path, kind(node)), None)
        if other is not None:
            ready += found.pair(number, other)
    _wiring(found)
    others = {node.path: n for n, node in enumerate(after.nodes) if (node.path, kind(node)) in named}
    for number, node in enumerate(before.nodes):
        other = others.get(node.path)
        if number not in found.nodes and other is not None and not is_wiring(node):
            found.replaced[number] = other
            ready += _replace(found, number, other)
    taken = {*found.nodes.values(), *found.replaced.values()}
    open_nodes = [n for n, node in enumerate(after.nodes) if n not in taken and not is_wiring(node)]
    for number in reversed(open_nodes):
        found.free.setdefault(_does(after, number, found.reads(number)), []).append(number)
    ready += [number for number, waits in found.waiting.items() if not waits]
    _follow(found, ready)
    _states(found, open_nodes)
    return found


def _replace(found: Matching, old: int, new: int) -> Iterator[int]:
    """Join the outputs of one name of two blocks."""
    first, second = found.before.nodes[old], found.after.nodes[new]
    outputs = dict(zip(_ports(second), second.outputs, strict=True))
    for name, wire in zip(_ports(first), first.outputs, strict=True):
        if name in outputs:
            yield from found.join(wire, outputs[name])


def _ports(node: Node) -> list[str]:
    """The names of a node's outputs; that of an only one does not matter."""
    if node.child is None or len(node.outputs) == 1:
        return ["" for _ in node.outputs]
    return [port.name for port in node.child.outputs]


def _wiring(found: Matching) -> None:
    """Find the wiring of ``after`` that is the same; a part of it stands behind what it reads."""
    for number, node in enumerate(found.after.nodes):
        if not is_wiring(node):
            continue
        key = _does(found.after, number, found.reads(number))
        first = found.free.setdefault(key, [number])[0]
        if first != number:
            found.alike.update(zip(node.outputs, found.after.nodes[first].outputs, strict=True))


def _follow(found: Matching, ready: list[int]) -> None:
    """Pair what does the same with the same wires, and then what reads it."""
    while ready:
        number = ready.pop()
        if number in found.nodes or number in found.replaced:
            continue
        inputs = tuple(None if w is None else found.wires.get(w) for w in found.before.nodes[number].inputs)
        others = found.free.get(_does(found.before, number, inputs))
        if others:
            wiring = is_wiring(found.before.nodes[number])
            ready += found.pair(number, others[0] if wiring else others.pop())


def _states(found: Matching, open_nodes: list[int]) -> None:
    """Pair delays whose inputs hang on themselves: those that are alike, in the order of the text."""
    taken = set(found.nodes.values())
    alike: dict[Hashable, list[int]] = {}
    for number in reversed([n for n in open_nodes if n not in taken]):
        if not found.after.nodes[number].feeds_through:
            alike.setdefault(_does(found.after, number, ()), []).append(number)
    for number, node in enumerate(found.before.nodes):
        if number in found.nodes or number in found.replaced or node.feeds_through:
            continue
        others = alike.get(_does(found.before, number, ()))
        while others:
            other = others.pop()
            same = found.free.get(_does(found.after, other, found.reads(other)), [])
            if other in same:
                same.remove(other)
                _follow(found, list(found.pair(number, other)))
                break


def kind(node: Node) -> str:
    """The symbol, or the sheet, that a node is."""
    return node.symbol.name if node.symbol is not None else node.child.sheet if node.child is not None else "?"


def _does(body: Body, number: int, inputs: tuple[int | None, ...]) -> Hashable:
    node = body.nodes[number]
    return is_wiring(node), kind(node), key_of(node.configuration), key_of(node.rate), inputs, tuple(body.types[w] for w in node.outputs)


def key_of(value: Any) -> Hashable:
    """A value of a configuration as one that can be compared: arrays by content, places left out."""
    if isinstance(value, np.ndarray):
        return value.shape, value.dtype.str, value.tobytes()
    if isinstance(value, Position):
        return None
    if is_dataclass(value) and not isinstance(value, type):
        return (type(value).__name__, *(key_of(getattr(value, f.name)) for f in fields(value)))
    if isinstance(value, list | tuple):
        return tuple(map(key_of, value))
    return value if isinstance(value, int | float | str | bool | type(None)) else repr(value)
