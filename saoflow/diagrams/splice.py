"""Laying sub-sheets out in place: their nodes join those of the sheet that uses them."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import replace

from saoflow.blocks.library import SYMBOLS
from saoflow.blocks.select import Selection
from saoflow.diagnosis import Position
from saoflow.diagrams.netlist import POISON, InputPort, Node, OutputPort, Structure

IDENTITY = Selection(())


def splice(
    path: str,
    structure: Structure,
    offset: int,
    inputs: Mapping[str, int],
    positions: Mapping[str, Position | None],
    outputs: Mapping[str, int],
) -> list[Node]:
    """The nodes of a sub-sheet as nodes of its user; its ports become free wiring.

    ``offset`` is added to the sub-sheet's wire numbers; ``inputs`` and ``outputs`` are wires of the user.
    """
    select = SYMBOLS["select"]
    taken = {node.path for node in structure.nodes} | {port.name for port in structure.inputs}

    def identity(name: str, port: InputPort | OutputPort, source: int, place: Position | None, target: int) -> Node:
        return Node(f"{path}.{name}", port.position, select, IDENTITY, None, (source,), (place,), (target,), port)

    nodes = [
        identity(p.name, p, inputs[p.name], positions.get(p.name) or p.position, p.wire + offset)
        for p in structure.inputs
    ]
    for node in structure.nodes:
        wires = tuple(w if w is None or w == POISON else w + offset for w in node.inputs)
        nodes.append(
            replace(node, path=f"{path}.{node.path}", inputs=wires, outputs=tuple(w + offset for w in node.outputs))
        )
    for port in structure.outputs:
        if port.wire != POISON:
            name = port.name if port.name not in taken else f"{port.name}#out"
            nodes.append(identity(name, port, port.wire + offset, port.position, outputs[port.name]))
    return nodes


def laid_out(structure: Structure, which: Collection[int]) -> Structure:
    """The structure with the calls of the given nodes replaced by what they call."""
    nodes: list[Node] = []
    wire_count = structure.wire_count
    for i, node in enumerate(structure.nodes):
        if i not in which or node.child is None:
            nodes.append(node)
            continue
        child = node.child
        wires = {p.name: w for p, w in zip(child.inputs, node.inputs, strict=True) if w is not None}
        positions = {p.name: q for p, q in zip(child.inputs, node.operand_positions, strict=True)}
        outputs = {p.name: w for p, w in zip(child.outputs, node.outputs, strict=True)}
        nodes += splice(node.path, child, wire_count, wires, positions, outputs)
        wire_count += child.wire_count
    return replace(structure, nodes=tuple(nodes), wire_count=wire_count)
