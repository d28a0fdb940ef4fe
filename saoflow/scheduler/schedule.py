"""The static order of a body's nodes: feed-through decides, ties go to the order of the sheet."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from heapq import heapify, heappop, heappush

from saoflow.diagnosis import Diagnoses, Diagnosis, Note, Position
from saoflow.diagrams.loops import is_loop, strong_components
from saoflow.diagrams.netlist import POISON, Body, Netlist, Node, SourceLines


@dataclass(frozen=True, slots=True, eq=False)
class Schedule:
    """A body with the order of its nodes, and the schedules of the bodies that it calls."""

    body: Body
    order: tuple[int, ...]
    children: tuple[Schedule | None, ...]


def order(netlist: Netlist) -> Schedule:
    """The schedule of a netlist. Raises DiagnosisError E301 with every algebraic loop, wire by wire."""
    found = Diagnoses()
    done: dict[int, Schedule] = {}

    def schedule(body: Body) -> Schedule:
        if id(body) not in done:
            children = tuple(None if child is None else schedule(child) for child in body.children)
            done[id(body)] = Schedule(body, _order_nodes(body, found, netlist.sources), children)
        return done[id(body)]

    root = schedule(netlist.root)
    _check_rates(netlist, found)
    found.raise_if_errors()
    return root


LONGEST = 100_000
"""Frames of the longest hyperperiod: every one of them is counted."""


def _check_rates(netlist: Netlist, found: Diagnoses) -> None:
    """E224 if the rates of the root (all rates are the root's: what has one has state) repeat too seldom."""
    slow = [(node, node.rate.every) for node in netlist.root.nodes if node.rate is not None]
    frames = math.lcm(1, *(every for _, every in slow))
    if frames > LONGEST:
        node = slow[-1][0]
        found.add(
            Diagnosis(
                "E224",
                f"the rates repeat after {frames} frames only",
                node.position,
                f"every frame until then is counted, and at most {LONGEST} can be",
                "choose rates that divide each other",
                notes=tuple(Note(f"`{other.path}` runs every {every} frames", other.position) for other, every in slow[:6]),
                source_line=netlist.sources.line(node.position),
            )
        )


def _order_nodes(body: Body, found: Diagnoses, sources: SourceLines) -> tuple[int, ...]:
    nodes = body.nodes
    produced_by = {wire: i for i, node in enumerate(nodes) for wire in node.outputs}
    waiting = [0] * len(nodes)
    users: list[list[int]] = [[] for _ in nodes]
    for i, node in enumerate(nodes):
        for producer in _producers(node, produced_by):
            waiting[i] += 1
            users[producer].append(i)
    ready = [i for i, count in enumerate(waiting) if not count]
    heapify(ready)
    placed: list[int] = []
    while ready:
        i = heappop(ready)
        placed.append(i)
        for user in users[i]:
            waiting[user] -= 1
            if not waiting[user]:
                heappush(ready, user)
    if len(placed) < len(nodes):
        _report_loops(body, [i for i, count in enumerate(waiting) if count], produced_by, found, sources)
    return tuple(placed)


def _producers(node: Node, produced_by: dict[int, int]) -> list[int]:
    """The nodes whose outputs a node needs within the frame."""
    if not node.feeds_through:
        return []
    wires = {w for w in node.inputs if w is not None and w != POISON}
    return [produced_by[w] for w in sorted(wires) if w in produced_by]


def _report_loops(
    body: Body, stuck: list[int], produced_by: dict[int, int], found: Diagnoses, sources: SourceLines
) -> None:
    members = set(stuck)

    def before(i: int) -> list[int]:
        return [p for p in _producers(body.nodes[i], produced_by) if p in members]

    for component in strong_components(stuck, before):
        if is_loop(component, before):
            loop = _shortest_loop(set(component), before)
            _report_loop(body, loop, produced_by, found, sources)


def _shortest_loop(component: set[int], before: Callable[[int], list[int]]) -> list[int]:
    """A shortest loop of the component, in the direction of the wires; starts at its first node in the sheet."""
    best: list[int] = []
    for start in sorted(component)[:64]:
        came: dict[int, int] = {}
        queue = deque([start])
        while queue and start not in came:
            i = queue.popleft()
            for p in before(i):
                if p in component and p not in came:
                    came[p] = i
                    queue.append(p)
        loop, i = [start], came[start]
        while i != start:
            loop.append(i)
            i = came[i]
        if not best or len(loop) < len(best):
            best = loop
        if len(best) <= 2:
            break
    first = best.index(min(best))
    return best[first:] + best[:first]


def _operand_position(node: Node, following: Node) -> Position | None:
    """Where the sheet connects the output of a node to the one that follows."""
    wires = set(node.outputs)
    for wire, position in zip(following.inputs, following.operand_positions, strict=True):
        if wire in wires:
            return position
    return None


def _report_loop(
    body: Body, loop: list[int], produced_by: dict[int, int], found: Diagnoses, sources: SourceLines
) -> None:
    nodes = [body.nodes[i] for i in loop]
    names = [node.path for node in nodes if "#" not in node.path] or [nodes[0].path]
    notes = []
    last = names[-1]
    for i, node in enumerate(nodes):
        if "#" in node.path:
            continue  # wiring of an operand: the step from the block before it to this one is told as one
        place = _operand_position(nodes[i - 1], node) or node.position
        notes.append(Note(f"{last} -> {node.path}", place))
        last = node.path
    notes = [*notes[1:], *notes[:1]]
    start = next((node for node in nodes if "#" not in node.path), nodes[0])
    found.add(
        Diagnosis(
            "E301",
            f"algebraic loop: {' -> '.join([*names, names[0]])}",
            start.position,
            "each of these wires needs the next within the same frame",
            "put a delay into the loop, where a value of the frame before is meant",
            "the loop passes here",
            tuple(notes),
            sources.line(start.position),
        )
    )
