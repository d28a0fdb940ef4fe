"""From a netlist to its drawings: one for each sheet instance that differs, and one for each stack of a fold or map."""

from __future__ import annotations

import re
from collections.abc import Sequence

from saoflow.blocks.lookup import TableUse
from saoflow.diagnosis import Position
from saoflow.diagrams.netlist import Body, InputPort, Netlist, Node, OutputPort
from saoflow.diagrams.store import SheetStore
from saoflow.drawing.drawing import (
    Block,
    Drawing,
    Drawings,
    InputOfBlock,
    OutputOfBlock,
    Source,
    Terminal,
    WireShown,
)
from saoflow.drawing.scopes import Scope, Scopes
from saoflow.scheduler.schedule import Schedule

MOST_SHOWN = 40
"""Instances of a stack that its own drawing shows; the last one is always among them."""

MINUS = "-"
"""In front of an operand of a sum: the sign at its port says the same."""

INSTANCE = re.compile(r"(.*)\[(\d+)\]")


def draw(schedule: Schedule, netlist: Netlist, store: SheetStore) -> Drawings:
    """The drawings of an ordered netlist; the first is the root sheet."""
    return _Drawer(netlist, store).drawings(schedule)


class _Drawer:
    def __init__(self, netlist: Netlist, store: SheetStore) -> None:
        self.netlist = netlist
        self.store = store
        self.done: list[Drawing | None] = []
        self.numbers: dict[tuple[int, str], int] = {}
        self.bodies: dict[int, int] = {}
        self.shown: list[tuple[WireShown | None, ...]] = []
        self.scopes: dict[int, Scopes] = {}
        self.waiting: list[tuple[int, Schedule, str, str]] = []

    def drawings(self, schedule: Schedule) -> Drawings:
        """All drawings, found from the root inwards."""
        self._number(schedule, "", "")
        while self.waiting:
            number, here, path, stack = self.waiting.pop()
            drawer = _BodyDrawer(self, here)
            self.done[number] = drawer.stack(path, stack) if stack else drawer.sheet(path)
        finished = [drawing for drawing in self.done if drawing is not None]
        assert len(finished) == len(self.done)
        return Drawings(tuple(finished), tuple(self.shown))

    def _number(self, schedule: Schedule, path: str, stack: str) -> int:
        """The number of the drawing of a scope of a body, or of a stack in it."""
        key = (id(schedule.body), f"{path}|{stack}")
        if key not in self.numbers:
            self.numbers[key] = len(self.done)
            self.done.append(None)
            self.waiting.append((len(self.done) - 1, schedule, path, stack))
        return self.numbers[key]

    def body(self, schedule: Schedule) -> tuple[int, Scopes]:
        """The number of a body and its scopes."""
        body = schedule.body
        if id(body) not in self.bodies:
            self.bodies[id(body)] = len(self.shown)
            self.shown.append(tuple(_shown(body, wire) for wire in range(len(body.types))))
            self.scopes[id(body)] = Scopes(body, schedule.order)
        return self.bodies[id(body)], self.scopes[id(body)]

    def sheet_text(self, position: Position) -> tuple[str, str, str]:
        """Name, doc and equations of the sheet that a place is in."""
        sheet = self.store.sheet_of(position.file)
        return (sheet.name.text, sheet.doc, sheet.equations) if sheet is not None else ("", "", "")


class _BodyDrawer:
    """Draws scopes and stacks of one body."""

    def __init__(self, drawer: _Drawer, schedule: Schedule) -> None:
        self.drawer = drawer
        self.schedule = schedule
        self.body: Body = schedule.body
        self.number, self.scopes = drawer.body(schedule)

    # -- one sheet instance

    def sheet(self, path: str) -> Drawing:
        """The drawing of a scope."""
        scope = self.scopes[path]
        names: dict[str, list[str]] = {}
        for name in scope.members:
            match = INSTANCE.fullmatch(name)
            names.setdefault(match[1] if match else name, []).append(name)
        members = sorted(
            (self._sorted(group) for group in names.values()),
            key=lambda group: max(self.scopes.turn(scope, name) for name in group),
        )
        inputs = self._input_terminals(scope)
        blocks = self._blocks(scope, members, [terminal.wire for terminal in inputs])
        position, name, doc, equations = self._heading(path)
        return Drawing(
            name,
            "sheet",
            doc,
            equations,
            position,
            self.number,
            tuple(block for block, _ in blocks),
            inputs,
            self._output_terminals(scope, _wires_made(blocks, inputs)),
        )

    def stack(self, path: str, stack: str) -> Drawing:
        """The drawing of the instances of a fold or map, what comes from outside as its inputs."""
        scope = self.scopes[path]
        mine = self._sorted([n for n in scope.members if (m := INSTANCE.fullmatch(n)) and m[1] == stack])
        shown = mine if len(mine) <= MOST_SHOWN else [*mine[: MOST_SHOWN - 1], mine[-1]]
        members = [[name] for name in shown]
        made = {w for name in shown for w in self._output_wires(scope, name)}
        outside = dict.fromkeys(
            end
            for name in shown
            for _, wire, _ in self._input_wires(scope, name)
            for end in self.scopes.wires_of_ends(wire)
            if end not in made and not self._is_number(end)
        )
        inputs = tuple(Terminal(self._name_of(end, path), end, "") for end in outside)
        blocks = self._blocks(scope, members, list(outside))
        position, name, doc, equations = self._heading(f"{path}.{shown[0]}" if path else shown[0])
        return Drawing(
            name,
            "stack",
            doc,
            equations,
            position,
            self.number,
            tuple(block for block, _ in blocks),
            inputs,
            (),
            len(mine) - len(shown),
        )

    def _heading(self, path: str) -> tuple[Position, str, str, str]:
        """Place, name, doc and equations of the sheet of a scope, or of a called instance."""
        structure = self.body.structure
        if not path:
            name, doc, equations = self.drawer.sheet_text(structure.position)
            return structure.position, name or structure.sheet, doc or structure.doc, equations
        outer, _, last = path.rpartition(".")
        node = self.scopes[outer].members.get(last)
        if node is not None:
            child = self.body.nodes[node].child
            assert child is not None
            name, doc, equations = self.drawer.sheet_text(child.position)
            return child.position, name, doc or child.doc, equations
        scope = self.scopes[path]
        inside = [*scope.inputs, *scope.outputs, *(i for i in scope.members.values() if i is not None)]
        position = self.body.nodes[inside[0]].position
        name, doc, equations = self.drawer.sheet_text(position)
        sheet = self.drawer.store.sheet_of(position.file)
        return (sheet.name.position if sheet else position), name, doc, equations

    # -- terminals

    def _input_terminals(self, scope: Scope) -> tuple[Terminal, ...]:
        if not scope.path:
            return tuple(Terminal(p.name, p.wire, p.doc) for p in self.body.structure.inputs)
        ports = [(self.body.nodes[i], self.body.nodes[i].declared) for i in self._declared(scope.inputs)]
        return tuple(Terminal(p.name, node.outputs[0], p.doc) for node, p in ports if isinstance(p, InputPort))

    def _output_terminals(self, scope: Scope, made: dict[int, Source]) -> tuple[Terminal, ...]:
        found = []
        if not scope.path:
            triples = [(p.name, p.wire, p.doc, p.position) for p in self.body.structure.outputs]
        else:
            triples = []
            for i in self._declared(scope.outputs):
                node = self.body.nodes[i]
                port, wire = node.declared, node.inputs[0]
                assert isinstance(port, OutputPort) and wire is not None
                triples.append((port.name, wire, port.doc, port.position))
        for name, wire, doc, position in triples:
            sources = self._sources(wire, made)
            found.append(Terminal(name, wire, doc, self._text(position, wire, scope.path), sources))
        return tuple(found)

    # -- blocks

    def _blocks(
        self, scope: Scope, members: Sequence[list[str]], inputs: Sequence[int]
    ) -> list[tuple[Block, tuple[tuple[int, ...], ...]]]:
        """The blocks of a drawing, each with the wires of its output ports."""
        made = {wire: Source(-1, i) for i, wire in enumerate(inputs)}
        outputs = []
        for number, group in enumerate(members):
            ports: dict[str, list[int]] = {}
            for name in group:
                for port, wire in self._output_ports(scope, name):
                    ports.setdefault(port, []).append(wire)
            for k, wires in enumerate(ports.values()):
                made.update((wire, Source(number, k)) for wire in wires)
            outputs.append(
                tuple(OutputOfBlock(p, ws[-1], tuple(ws) if len(group) > 1 else ()) for p, ws in ports.items())
            )
        labels = [_label(group) for group in members]
        return [
            (
                self._block(scope, number, group, outputs[number], made, labels),
                tuple((o.wire, *o.wires) for o in outputs[number]),
            )
            for number, group in enumerate(members)
        ]

    def _block(
        self,
        scope: Scope,
        number: int,
        group: list[str],
        outputs: tuple[OutputOfBlock, ...],
        made: dict[int, Source],
        labels: Sequence[str],
    ) -> Block:
        first = group[0]
        inputs: dict[int, InputOfBlock] = {}
        for name in group:
            for k, (port, wire, position) in enumerate(self._input_wires(scope, name)):
                sources = self._sources(wire, made)
                carried = len(group) > 1 and any(s.block == number for s in sources)
                kept = tuple(s for s in sources if not (carried and s.block == number))
                if k in inputs:
                    old = inputs[k]
                    joined = tuple(dict.fromkeys((*old.sources, *kept)))
                    inputs[k] = InputOfBlock(port, old.text, old.wire, joined, old.carried or carried)
                else:
                    text = self._text(position, wire, scope.path)
                    text = text.removeprefix(MINUS) if port == "−" else text
                    if len({s.block for s in kept}) == 1 and kept[0].block >= 0 and text == labels[kept[0].block]:
                        text = ""  # the whole stack by its name
                    if any(s.block >= 0 and s.block != number and _stack_of(labels[s.block]) == _stack_of(first) for s in kept):
                        text = ""  # carried: what is written is where the first instance begins
                    inputs[k] = InputOfBlock(port, text, wire, kept, carried)
        node_number = scope.members[first]
        node = None if node_number is None else self.body.nodes[node_number]
        label = labels[number]
        if node is not None and node.symbol is not None:
            return Block(
                label,
                "symbol",
                node.symbol.name,
                node.symbol.glyph_of(node.configuration),
                tuple(inputs.values()),
                outputs,
                node.position,
                None,
                "",
                feeds_through=node.symbol.feeds_through,
                table=_ends(node),
            )
        path = scope.child(first)
        sheet_position, sheet, _, _ = self._heading(path)
        if len(group) > 1:
            inside = self.drawer._number(self.schedule, scope.path, label)
        else:
            inside = self._inside(path, node_number)
        return Block(
            label,
            "sheet" if len(group) == 1 else "stack",
            sheet,
            "",
            tuple(inputs.values()),
            outputs,
            node.position if node is not None else sheet_position,
            inside,
            node.path if node is not None and len(group) == 1 else "",
            len(group),
            rate=_rate(node),
        )

    def _inside(self, path: str, node_number: int | None) -> int:
        if node_number is None:
            return self.drawer._number(self.schedule, path, "")
        child = self.schedule.children[node_number]
        assert child is not None
        return self.drawer._number(child, "", "")

    # -- ports and wires

    def _input_wires(self, scope: Scope, name: str) -> list[tuple[str, int, Position | None]]:
        """Port, wire and place of the operand, for every connected input of a member."""
        i = scope.members[name]
        if i is None:
            ports = [self.body.nodes[k] for k in self._declared(self.scopes[scope.child(name)].inputs)]
            return [
                (node.declared.name, node.inputs[0], node.operand_positions[0])
                for node in ports
                if isinstance(node.declared, InputPort) and node.inputs[0] is not None
            ]
        node = self.body.nodes[i]
        if node.child is not None:
            names = [port.name for port in node.child.inputs]
        else:
            assert node.symbol is not None
            names = _symbol_ports(node)
        return [
            (port, wire, position)
            for port, wire, position in zip(names, node.inputs, node.operand_positions, strict=True)
            if wire is not None
        ]

    def _output_ports(self, scope: Scope, name: str) -> list[tuple[str, int]]:
        i = scope.members[name]
        if i is None:
            nodes = [self.body.nodes[k] for k in self._declared(self.scopes[scope.child(name)].outputs)]
            return [(n.declared.name, n.outputs[0]) for n in nodes if isinstance(n.declared, OutputPort)]
        node = self.body.nodes[i]
        if node.child is None:
            return [("", node.outputs[0])]
        return [(port.name, wire) for port, wire in zip(node.child.outputs, node.outputs, strict=True)]

    def _declared(self, ports: list[int]) -> list[int]:
        """Nodes that stand for ports, in the order of the sheet's text."""
        place = [(self.body.nodes[i].declared, i) for i in ports]
        return [i for port, i in sorted(place, key=lambda p: _place(p[0]))]

    def _output_wires(self, scope: Scope, name: str) -> list[int]:
        return [wire for _, wire in self._output_ports(scope, name)]

    def _sources(self, wire: int, made: dict[int, Source]) -> tuple[Source, ...]:
        return tuple(dict.fromkeys(made[end] for end in self.scopes.wires_of_ends(wire) if end in made))

    def _is_number(self, wire: int) -> bool:
        i = self.scopes.producer.get(wire)
        return i is not None and not self.body.nodes[i].inputs and "#" in self.body.nodes[i].path

    def _text(self, position: Position | None, wire: int, path: str) -> str:
        """An operand as written, if it says more than the name of the wire that it is."""
        text = self.drawer.netlist.sources.word(position) if position is not None else ""
        name = self._name_of(wire, path)
        if list(self.scopes.wires_of_ends(wire)) == [wire] and text.removeprefix(MINUS) in (name, name.rpartition(".")[0]):
            return ""
        return text

    def _name_of(self, wire: int, path: str) -> str:
        """A wire's name as the sheet of a scope calls it: ``K``, ``stages.P``, or an input's name."""
        i = self.scopes.producer.get(wire)
        if i is None:
            return next((p.name for p in self.body.structure.inputs if p.wire == wire), "")
        node = self.body.nodes[i]
        name = node.path[len(path) + 1 :] if path else node.path
        if isinstance(node.declared, InputPort):
            return node.declared.name
        if isinstance(node.declared, OutputPort):
            return name.partition("#")[0]
        if node.child is not None and len(node.outputs) > 1:
            port = node.child.outputs[node.outputs.index(wire)]
            return f"{name}.{port.name}"
        return name

    @staticmethod
    def _sorted(names: list[str]) -> list[str]:
        """The instances of a stack by number, whichever way they run."""
        return sorted(names, key=lambda name: int(m[2]) if (m := INSTANCE.fullmatch(name)) else 0)


def _stack_of(name: str) -> str:
    """The stack that an instance belongs to; another name is its own, and of no stack."""
    match = INSTANCE.fullmatch(name)
    return match[1] if match else f"{name} alone"


def _label(group: list[str]) -> str:
    """The name of a block, or that of a stack without the numbers of its instances."""
    match = INSTANCE.fullmatch(group[0])
    return match[1] if match and len(group) > 1 else group[0]


def _place(port: InputPort | OutputPort | None) -> tuple[int, int]:
    return (port.position.line, port.position.column) if port is not None else (0, 0)


def _symbol_ports(node: Node) -> list[str]:
    """Port names of a symbol's inputs; a sum's operands carry their signs instead."""
    symbol = node.symbol
    assert symbol is not None
    if symbol.takes_signs:
        return ["−" if sign < 0 else "+" for sign in node.configuration]
    named = [port.name for port in symbol.ports]
    if symbol.variadic:
        return [""] * len(node.inputs)
    return [name if len(node.inputs) > 1 else "" for name in named][: len(node.inputs)]


def _wires_made(
    blocks: Sequence[tuple[Block, tuple[tuple[int, ...], ...]]], inputs: Sequence[Terminal]
) -> dict[int, Source]:
    made = {terminal.wire: Source(-1, i) for i, terminal in enumerate(inputs)}
    for number, (_, ports) in enumerate(blocks):
        for k, wires in enumerate(ports):
            made.update((wire, Source(number, k)) for wire in wires)
    return made


def _rate(node: Node | None) -> str:
    """In which frames a block runs, if not in all."""
    if node is None or node.rate is None:
        return ""
    return f"every {node.rate.every}" + (f" from {node.rate.offset}" if node.rate.offset else "")


def _ends(node: Node) -> tuple[tuple[float, float], ...]:
    if isinstance(node.configuration, TableUse):
        return tuple((float(axis[0]), float(axis[-1])) for axis in node.configuration.table.breakpoints)
    return ()


def _shown(body: Body, wire: int) -> WireShown | None:
    found = body.types[wire]
    if found is None:
        return None
    units = found.units
    if isinstance(units, tuple):
        distinct = ["?" if u is None else str(u) for u in units]
        text = ", ".join(distinct[:8]) + (", ..." if len(distinct) > 8 else "")
    else:
        text = "" if units is None else str(units)
    return WireShown(found.shape, text, found.boolean)
