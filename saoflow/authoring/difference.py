"""What differs in meaning between two sheets: parameters, ports, blocks, wires, shapes and units, rates, limits.

Texts, comments, the order of lines and the names of blocks are no difference in meaning; renamed blocks are told.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, fields, is_dataclass
from typing import Any

import numpy as np

from saoflow.authoring.matching import WIRING, Matching, is_wiring, key_of, kind, match
from saoflow.diagnosis import Position
from saoflow.diagrams.netlist import POISON, Body, Netlist, Node, Rate


@dataclass(frozen=True, slots=True)
class Change:
    """One difference. ``what``: ``added``, ``removed``, ``changed`` or ``renamed``."""

    part: str
    """``parameter``, ``input``, ``output``, ``block``, ``wire``, ``type``, ``setting``, ``rate`` or ``budget``."""
    what: str
    path: str
    before: str
    after: str
    place: Position | None = None
    """Where it stands in the new sheet; of what is removed, in the old one."""

    def to_dict(self) -> dict[str, object]:
        """The machine-readable form."""
        place = str(self.place) if self.place else None
        return {
            "part": self.part, "what": self.what, "path": self.path,
            "before": self.before, "after": self.after, "place": place,
        }  # fmt: skip


@dataclass(slots=True)
class Difference:
    """All differences, in the order of the sheets; ``renamed`` ones are no difference in meaning."""

    before: Netlist
    after: Netlist
    changes: list[Change] = field(default_factory=list)
    _seen: set[tuple[int, int]] = field(default_factory=set)
    _drivers: dict[Body, dict[int, Node]] = field(default_factory=dict)

    def driver(self, body: Body, wire: int) -> Node | None:
        """The node that a wire comes from; None for an input."""
        if body not in self._drivers:
            self._drivers[body] = {output: node for node in body.nodes for output in node.outputs}
        return self._drivers[body].get(wire)

    def source(self, body: Body, wire: int) -> str:
        """The name of the block or input that a wire comes from."""
        node = self.driver(body, wire)
        if node is not None:
            return node.path.partition(WIRING)[0]
        return next((port.name for port in body.structure.inputs if port.wire == wire), "?")

    @property
    def same(self) -> bool:
        """Whether both sheets mean the same."""
        return all(change.what == "renamed" for change in self.changes)


def difference(before: Netlist, after: Netlist) -> Difference:
    """Compare two elaborated sheets. A sheet that is used often is compared once, at its first place."""
    found = Difference(before, after)
    old, new = dict(before.parameters), dict(after.parameters)
    for name in dict.fromkeys((*new, *old)):
        if old.get(name) != new.get(name):
            what = "added" if name not in old else "removed" if name not in new else "changed"
            found.changes.append(Change("parameter", what, name, _plain(old.get(name, "")), _plain(new.get(name, ""))))
    found.changes += _budget(before, after)
    stack = [(before.root, after.root, "")]
    while stack:
        a, b, prefix = stack.pop()
        if (id(a), id(b)) in found._seen:
            continue
        found._seen.add((id(a), id(b)))
        matching = match(a, b)
        found.changes += dict.fromkeys(_body(found, matching, prefix))
        below = []
        for i, j in matching.nodes.items():
            first, second = a.children[i], b.children[j]
            if first is not None and second is not None:
                below.append((first, second, f"{prefix}{b.nodes[j].path}."))
        stack += reversed(below)
    return found


def _budget(before: Netlist, after: Netlist) -> Iterator[Change]:
    declared = (before.root.structure.budget, after.root.structure.budget)
    old, new = ({} if b is None else {**dict(b.limits), "period": b.period} for b in declared)
    for name in dict.fromkeys((*new, *old)):
        if old.get(name) != new.get(name):
            place = declared[1].position if declared[1] is not None else None
            yield Change("budget", _what(old.get(name), new.get(name)), name, _number(old.get(name)), _number(new.get(name)), place)


def _plain(text: str) -> str:
    return " ".join(text.split())


def _what(old: object, new: object) -> str:
    return "added" if old is None else "removed" if new is None else "changed"


def _number(value: float | None) -> str:
    return "" if value is None else f"{value:.12g}"


# -- bodies


def _body(found: Difference, matching: Matching, prefix: str) -> Iterator[Change]:
    a, b = matching.before, matching.after
    yield from _inputs(a, b, prefix)
    partners = {new: old for old, new in matching.nodes.items()}
    for i, node in enumerate(a.nodes):
        j = matching.nodes.get(i)
        if j is not None:
            yield from _pair(found, matching, i, j, prefix)
            continue
        if is_wiring(node):
            continue
        j = matching.replaced.get(i)
        if j is not None:
            place = b.nodes[j].position
            yield Change("block", "changed", prefix + node.path, kind(node), kind(b.nodes[j]), place)
            partners[j] = i
        else:
            yield Change("block", "removed", prefix + node.path, kind(node), "", node.position)
    for j, node in enumerate(b.nodes):
        if j not in partners and not is_wiring(node):
            yield Change("block", "added", prefix + node.path, "", kind(node), node.position)
    yield from _outputs(found, matching, prefix)


def _inputs(a: Body, b: Body, prefix: str) -> Iterator[Change]:
    old = {port.name: port for port in a.structure.inputs}
    new = {port.name: port for port in b.structure.inputs}
    for name in dict.fromkeys((*new, *old)):
        first = str(a.types[old[name].wire]) if name in old else ""
        second = str(b.types[new[name].wire]) if name in new else ""
        if first != second:
            what = "added" if name not in old else "removed" if name not in new else "changed"
            yield Change("input", what, prefix + name, first, second, (new.get(name) or old[name]).position)


def _outputs(found: Difference, matching: Matching, prefix: str) -> Iterator[Change]:
    a, b = matching.before, matching.after
    old = {port.name: port for port in a.structure.outputs}
    new = {port.name: port for port in b.structure.outputs}
    for name in dict.fromkeys((*new, *old)):
        if name not in old:
            yield Change("output", "added", prefix + name, "", str(b.types[new[name].wire]), new[name].position)
        elif name not in new:
            yield Change("output", "removed", prefix + name, str(a.types[old[name].wire]), "", old[name].position)
        elif matching.wires.get(old[name].wire) != matching.first(new[name].wire):
            sources = found.source(a, old[name].wire), found.source(b, new[name].wire)
            yield Change("output", "changed", prefix + name, *sources, new[name].position)


def _pair(found: Difference, matching: Matching, i: int, j: int, prefix: str) -> Iterator[Change]:
    """What differs between two nodes that are partners."""
    a, b = matching.before, matching.after
    old, new = a.nodes[i], b.nodes[j]
    if is_wiring(new):  # what it does is the same, or it would have no partner
        return
    path = prefix + new.path
    if old.path != new.path:
        yield Change("block", "renamed", path, *_renamed(old.path, new.path), new.position)
    if key_of(old.configuration) != key_of(new.configuration):
        for name, first, second in _settings(old.configuration, new.configuration):
            yield Change("setting", "changed", f"{path}: {name}", first, second, new.position)
    if key_of(old.rate) != key_of(new.rate):
        yield Change("rate", _what(old.rate, new.rate), path, _rate(old.rate), _rate(new.rate), new.position)
    for number in range(max(len(old.inputs), len(new.inputs))):
        first_wire = old.inputs[number] if number < len(old.inputs) else None
        second_wire = new.inputs[number] if number < len(new.inputs) else None
        partner = None if first_wire is None else matching.wires.get(first_wire, -2)
        if partner != (None if second_wire is None else matching.first(second_wire)):
            first = _operand(found, found.before, a, old, number)
            second = _operand(found, found.after, b, new, number)
            place = new.operand_positions[number] if number < len(new.operand_positions) else None
            yield Change("wire", _what(first_wire, second_wire), f"{path}: operand {number + 1}", first, second, place or new.position)
    for x, y in zip(old.outputs, new.outputs, strict=False):
        if a.types[x] != b.types[y]:
            yield Change("type", "changed", path, str(a.types[x]), str(b.types[y]), new.position)


def _renamed(old: str, new: str) -> tuple[str, str]:
    """The part of two paths that differs: a sheet that is laid out in place takes all its blocks along."""
    first, second = old.split("."), new.split(".")
    while len(first) > 1 and len(second) > 1 and first[-1] == second[-1]:
        first.pop()
        second.pop()
    return ".".join(first), ".".join(second)


def _settings(old: Any, new: Any) -> Iterator[tuple[str, str, str]]:
    """The fields of two configurations that differ."""
    if not (is_dataclass(old) and type(old) is type(new)):
        if not (isinstance(old, tuple) and isinstance(new, tuple) and len(old) != len(new)):  # operands are told as wires
            yield "signs" if isinstance(old, tuple) else "value", _short(old), _short(new)
        return
    for f in fields(old):
        first, second = getattr(old, f.name), getattr(new, f.name)
        if key_of(first) != key_of(second):
            yield f.name, _short(first), _short(second)


def _short(value: Any) -> str:
    if isinstance(value, np.ndarray):
        if value.size > 12:
            return f"{list(value.shape)}, from {value.flat[0]:.12g} to {value.flat[-1]:.12g}"
        return " ".join(np.array2string(value, separator=", ", formatter={"float_kind": lambda x: f"{x:.12g}"}).split())
    return f"{value:.12g}" if isinstance(value, float) else str(value)


def _rate(rate: Rate | None) -> str:
    if rate is None:
        return "every frame"
    return f"every {rate.every}, offset {'auto' if rate.offset is None else rate.offset}, held {rate.held:.12g}"


def _operand(found: Difference, netlist: Netlist, body: Body, node: Node, number: int) -> str:
    """An operand as its sheet writes it; a number with its value."""
    if number >= len(node.inputs) or node.inputs[number] is None:
        return ""
    place = node.operand_positions[number] if number < len(node.operand_positions) else None
    text = netlist.sources.word(place) if place is not None else ""
    wire = node.inputs[number]
    driver = None if wire is None or wire == POISON else found.driver(body, wire)
    if driver is not None and kind(driver) == "constant":
        value = getattr(driver.configuration, "array", None)
        shown = _short(value if value is not None else driver.configuration)
        return shown if not text or text == shown else f"{text} = {shown}"
    return text or (found.source(body, wire) if wire is not None else "")
