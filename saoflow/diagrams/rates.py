"""Blocks that run every n frames: their rate as numbers, and their place between the wires of the faster sheet.

A block with ``every: n`` runs in frames offset, offset + n, ... and holds its outputs between (``transition: hold``: a run's
results show from its own frame on). With ``transition: delay`` they show from the next frame on, so that nothing in a
frame waits for the run. What goes in is sampled when the block runs; delays inside it step only then.
"""

from __future__ import annotations

import math

import numpy as np

from saoflow.blocks.delay import Memory
from saoflow.blocks.library import SYMBOLS
from saoflow.diagnosis import Note
from saoflow.diagrams.netlist import Node, Rate, Structure
from saoflow.diagrams.operands import Operands
from saoflow.diagrams.scope import Scope
from saoflow.diagrams.sheet import BlockDeclaration, RateDeclaration

SLOWEST = 1000
"""The largest ``every``."""


def rate_of(scope: Scope, block: BlockDeclaration) -> Rate | None:
    """The rate of a block as numbers; None after a diagnosis (E216, E224, E225)."""
    declared = block.rate
    assert declared is not None
    operands = Operands(scope, block.name.text)
    every = operands.whole_number(declared.every, "`every`")
    offset = 0 if declared.offset is None else operands.whole_number(declared.offset, "`offset`")
    held = _held(scope, declared)
    if declared.transition is None:
        scope.report(
            "E225",
            f"`{block.name.text}` does not say how its outputs pass to the frames between its runs",
            declared.position,
            "it runs more seldom than what reads it",
            "add transition: hold (a run's results show from its own frame on), or transition: delay (from the next one on)",
        )
    if every is None or offset is None or held is None or declared.transition is None:
        return None
    if not 1 <= every <= SLOWEST:
        scope.report(
            "E224",
            f"`every` cannot be {every}",
            declared.every.position,
            f"a block runs every 1 to {SLOWEST} frames",
            "write every: 2",
        )
        return None
    if not 0 <= offset < every:
        assert declared.offset is not None
        scope.report(
            "E224",
            f"`offset` cannot be {offset}",
            declared.offset.position,
            f"it says in which of the {every} frames the block runs: 0 to {every - 1}",
            "write offset: 0, or offset: auto",
        )
        return None
    return Rate(every, None if declared.automatic else offset, held)


def _held(scope: Scope, declared: RateDeclaration) -> float | None:
    if declared.held is None:
        return 0.0
    quantity = scope.value_of(declared.held)
    if quantity is None:
        return None
    array = np.asarray(quantity.array if quantity.text is None else np.nan, dtype=np.float64)
    if array.ndim or not math.isfinite(float(array)):
        scope.report(
            "E208",
            "`held` must be one finite number",
            declared.held.position,
            "it is what every output is before the first run",
            "write held: 0",
        )
        return None
    return float(array)


def place_at_rate(scope: Scope, block: BlockDeclaration, rate: Rate, structure: Structure, node: Node) -> bool:
    """Add a called sheet as one that runs at its rate. False after a diagnosis (E224)."""
    inner = next((other for other in structure.nodes if other.rate is not None), None)
    assert block.rate is not None and block.rate.transition is not None
    if inner is not None:
        scope.report(
            "E224",
            f"`{block.name.text}` runs at a rate of its own, and so does a block inside it",
            block.rate.position,
            f"`{inner.path}` of `{structure.sheet}` has a rate; rates inside each other would multiply",
            "give only one of them a rate",
            notes=[Note(f"`{inner.path}`", inner.position)],
        )
        return False
    if block.rate.transition.text == "hold":
        scope.nodes.append(_at(node, rate, node.outputs))
        return True
    runs = tuple(scope.new_wire() for _ in node.outputs)
    scope.nodes.append(_at(node, rate, runs))
    memory = Memory(np.array(rate.held), 1, None, None, None)
    for port, run, output in zip(structure.outputs, runs, node.outputs, strict=True):
        path = f"{node.path}.{port.name}#before"
        position = block.rate.transition.position
        scope.nodes.append(Node(path, position, SYMBOLS["delay"], memory, None, (run,), (position,), (output,)))
    return True


def _at(node: Node, rate: Rate, outputs: tuple[int, ...]) -> Node:
    return Node(
        node.path, node.position, None, None, node.child, node.inputs, node.operand_positions, outputs, rate=rate
    )
