"""The sheet instances inside one netlist body: sub-sheets with state are laid out in place and found again by their paths."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

from saoflow.diagrams.netlist import Body, InputPort, Node, OutputPort


@dataclass(slots=True)
class Scope:
    """One sheet instance of a body: its members by name, and its ports."""

    path: str
    members: dict[str, int | None] = field(default_factory=dict)
    """By name: the number of the node, or None for a sub-sheet that is laid out in place."""
    inputs: list[int] = field(default_factory=list)
    """Nodes that stand for its input ports."""
    outputs: list[int] = field(default_factory=list)
    """Nodes that stand for its output ports."""

    def child(self, name: str) -> str:
        """The path of a sub-sheet that is laid out in place."""
        return f"{self.path}.{name}" if self.path else name


class Scopes:
    """A body by its scopes; "" is the body itself."""

    def __init__(self, body: Body, order: tuple[int, ...]) -> None:
        self.body = body
        self.producer: dict[int, int] = {w: i for i, node in enumerate(body.nodes) for w in node.outputs}
        self._scopes: dict[str, Scope] = {"": Scope("")}
        self._known: dict[str, int] = {}
        for turn, i in enumerate(order):
            self._place(i, turn, body.nodes[i])

    def __getitem__(self, path: str) -> Scope:
        return self._scopes[path]

    def turn(self, scope: Scope, name: str) -> int:
        """When a member's outputs are known: -1 for a delay, which knows its output when the frame begins.

        Drawn in this order, wires run forward but for those into delays.
        """
        return self._known.get(scope.child(name), -1)

    def _place(self, i: int, turn: int, node: Node) -> None:
        path, _, name = node.path.rpartition(".")
        scope = self._scope(path)
        if isinstance(node.declared, InputPort):
            scope.inputs.append(i)
        elif isinstance(node.declared, OutputPort):
            scope.outputs.append(i)
            self._known[path] = turn
        elif not is_wiring(node):
            scope.members[name] = i
            self._known[node.path] = turn if node.feeds_through else -1

    def _scope(self, path: str) -> Scope:
        if path not in self._scopes:
            self._scopes[path] = Scope(path)
            outer, _, name = path.rpartition(".")
            self._scope(outer).members.setdefault(name, None)
        return self._scopes[path]

    def wires_of_ends(self, wire: int) -> Iterator[int]:
        """The wires that a wire comes from, through the wiring of operands."""
        stack, seen = [wire], set()
        while stack:
            here = stack.pop()
            if here in seen:
                continue
            seen.add(here)
            i = self.producer.get(here)
            node = None if i is None else self.body.nodes[i]
            if node is not None and is_wiring(node):
                stack.extend(w for w in reversed(node.inputs) if w is not None)
            else:
                yield here


def is_wiring(node: Node) -> bool:
    """Whether a node is part of an operand as written (``C.T``, a number), not a block of its own."""
    return node.declared is None and "#" in node.path.rpartition(".")[2]
