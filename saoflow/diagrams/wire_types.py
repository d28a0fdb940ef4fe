"""From a structure and the types of its inputs to a body: the shape and unit of every wire, checked.

Nodes are typed when all their operands are. A delay whose shape is not declared waits for its input; where a loop makes
it wait for itself, its initial value decides. What still waits then hangs on an algebraic loop, unless a call of a
sub-sheet only seems to close the loop: then the sub-sheet is laid out in place.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Sequence

from saoflow.blocks.delay import Delay, merge_units
from saoflow.blocks.symbol import SymbolProblem, need_room, need_units
from saoflow.diagnosis import Diagnoses, Diagnosis, Note, Position
from saoflow.diagrams.loops import is_loop, strong_components
from saoflow.diagrams.netlist import POISON, Body, InputPort, Node, OutputPort, SourceLines, Structure
from saoflow.diagrams.splice import laid_out
from saoflow.units import conversion_hint, conversion_remedy, first_mismatch
from saoflow.wires import WireType, shape_text

InputTypes = tuple[WireType, ...]


class Typer:
    """Types structures; the same structure with the same input types is typed once."""

    def __init__(self, found: Diagnoses, sources: SourceLines) -> None:
        self.found = found
        self.sources = sources
        self._bodies: dict[tuple[int, InputTypes], Body] = {}
        self._uses: list[Note] = []
        self._kept: list[Structure] = []

    def body(self, structure: Structure, inputs: InputTypes) -> Body:
        """The body of a structure; wires that cannot be typed stay None (all reasons but loops are diagnosed)."""
        key = (id(structure), inputs)
        if key not in self._bodies:
            self._kept.append(structure)
            self._bodies[key] = _StructureTyper(self, structure, inputs).run()
        return self._bodies[key]

    def call(self, node: Node, inputs: InputTypes) -> Body:
        """The body that a node calls, typed in the context of its use."""
        assert node.child is not None
        self._uses.append(Note(f"in `{node.path}`, used here", node.position))
        body = self.body(node.child, inputs)
        self._uses.pop()
        return body

    def report(self, problem: SymbolProblem, position: Position | None, notes: Iterable[Note], label: str = "") -> None:
        """A symbol's refusal as a diagnosis."""
        self.found.add(
            Diagnosis(
                problem.code,
                problem.message,
                position,
                problem.cause,
                problem.remedy,
                label,
                (*notes, *self._uses[-1:]),
                self.sources.line(position),
            )
        )


class _Wave:
    """Which nodes wait for how many unknown wires, and which are ready."""

    def __init__(self, nodes: Sequence[Node], types: Sequence[WireType | None]) -> None:
        self.waiting = [0] * len(nodes)
        self.done = [False] * len(nodes)
        self._users: dict[int, list[int]] = {}
        for i, node in enumerate(nodes):
            for wire in {w for w in node.inputs if w is not None}:
                if wire == POISON or types[wire] is None:
                    self.waiting[i] += 1
                    self._users.setdefault(wire, []).append(i)
        self.ready = deque(i for i, count in enumerate(self.waiting) if not count)

    def know(self, wires: Iterable[int]) -> None:
        """The types of these wires are known: the nodes that waited for nothing else are ready."""
        for wire in wires:
            for user in self._users.get(wire, ()):
                self.waiting[user] -= 1
                if not self.waiting[user]:
                    self.ready.append(user)


class _StructureTyper:
    def __init__(self, typer: Typer, structure: Structure, inputs: InputTypes) -> None:
        self.typer = typer
        self.inputs = inputs
        self._restart(structure)

    def _restart(self, structure: Structure) -> None:
        self.structure = structure
        self.types: list[WireType | None] = [None] * structure.wire_count
        self.children: list[Body | None] = [None] * len(structure.nodes)
        self.produced_by: dict[int, int] = {w: i for i, node in enumerate(structure.nodes) for w in node.outputs}
        self.assumed: set[int] = set()

    def run(self) -> Body:
        while True:
            self._input_types()
            stuck = self._spread()
            calls = [i for i in stuck if self.structure.nodes[i].child is not None and self.structure.nodes[i].rate is None]
            in_loop = self._in_loops(stuck) if calls else set()
            dissolve = {i for i in calls if i in in_loop}
            if not dissolve:
                break
            self._restart(laid_out(self.structure, dissolve))
        self._refine_delays()
        self._check_delays()
        self._output_types()
        return Body(self.structure, tuple(self.types), tuple(self.children))

    def _input_types(self) -> None:
        for port, wire in zip(self.structure.inputs, self.inputs, strict=True):
            self.types[port.wire] = wire

    def _spread(self) -> list[int]:
        """Type every node that can be typed; returns those that wait for ever."""
        nodes = self.structure.nodes
        wave = _Wave(nodes, self.types)
        hidden = [i for i, node in enumerate(nodes) if isinstance(node.symbol, Delay) and wave.waiting[i]]
        delays = deque(sorted(hidden, key=lambda i: nodes[i].configuration.shape is None))
        while True:
            self._type_ready(wave)
            while delays and wave.done[delays[0]]:
                delays.popleft()
            if not delays:
                break
            guess = delays.popleft()
            self.assumed.add(guess)
            wave.ready.append(guess)
        return [i for i in range(len(nodes)) if not wave.done[i]]

    def _type_ready(self, wave: _Wave) -> None:
        """Type the nodes whose operands are known, and those that become so."""
        while wave.ready:
            i = wave.ready.popleft()
            if not wave.done[i]:
                wave.done[i] = True
                wave.know(self._type_node(i, self.structure.nodes[i]))

    def _type_node(self, i: int, node: Node) -> Iterable[int]:
        """Type one node; returns the wires that are now known."""
        known = tuple(None if w is None or w == POISON else self.types[w] for w in node.inputs)
        if node.symbol is None:
            body = self.typer.call(node, self._port_types(node, known))
            self.children[i] = body
            found: list[WireType | None] = [
                None if p.wire == POISON else body.types[p.wire] for p in body.structure.outputs
            ]
        else:
            try:
                result = node.symbol.output_type(known, node.configuration)
                need_room(result.size, "the wire")
                need_units(result.units, result.shape)
                found = [self._as_declared(node, result)]
            except SymbolProblem as problem:
                self._refuse(node, problem, known)
                found = [None]
        spread = []
        for wire, wire_type in zip(node.outputs, found, strict=True):
            if wire_type is not None:
                self.types[wire] = wire_type
                spread.append(wire)
        return spread

    def _as_declared(self, node: Node, wire_type: WireType) -> WireType:
        """The type behind a port of a sheet that is laid out in place."""
        if isinstance(node.declared, InputPort):
            return self._check_port(node.declared, wire_type, node.operand_positions[0])
        if isinstance(node.declared, OutputPort):
            return self._check_output(node.declared, wire_type)
        return wire_type

    def _port_types(self, node: Node, known: tuple[WireType | None, ...]) -> InputTypes:
        assert node.child is not None
        result = []
        for port, wire, position in zip(node.child.inputs, known, node.operand_positions, strict=True):
            assert wire is not None
            result.append(self._check_port(port, wire, position))
        return tuple(result)

    def _check_port(self, port: InputPort, wire: WireType, position: Position | None) -> WireType:
        declared_here = Note(f"input `{port.name}` is declared here", port.position)
        if port.boolean != wire.boolean:
            kind = "boolean" if port.boolean else "real"
            problem = SymbolProblem(
                "E210", f"input `{port.name}` is {kind}", f"the wire is {wire}", f"connect a {kind} wire"
            )
            self.typer.report(problem, position, [declared_here])
        if port.shape is not None and port.shape != wire.shape:
            problem = SymbolProblem(
                "E204",
                f"input `{port.name}` has another shape",
                f"it is declared {shape_text(port.shape)}, the wire is {shape_text(wire.shape)}",
                "connect a wire of that shape, or correct the declaration",
            )
            self.typer.report(problem, position, [declared_here])
            return WireType(port.shape, port.boolean, port.units)
        try:
            need_units(port.units, wire.shape)
        except SymbolProblem as wrong:
            self.typer.report(wrong, position, [declared_here])
            return WireType(wire.shape, port.boolean, wire.units)
        clash = first_mismatch(port.units, wire.units)
        if clash is not None:
            _, wanted, given = clash
            problem = SymbolProblem(
                "E211",
                f"input `{port.name}` has another unit",
                f"it takes {wanted}, the wire is in {given}: {conversion_hint(given, wanted)}",
                conversion_remedy(given, wanted),
            )
            self.typer.report(problem, position, [declared_here])
        return WireType(wire.shape, port.boolean, merge_units(port.units, wire.units, wire.size))

    def _refuse(self, node: Node, problem: SymbolProblem, known: tuple[WireType | None, ...]) -> None:
        position = node.position
        if problem.operand is not None and problem.operand < len(node.operand_positions):
            position = node.operand_positions[problem.operand] or position
        notes: list[Note] = []
        label = ""
        for number, (wire, wire_type) in enumerate(zip(node.inputs, known, strict=True)):
            if wire_type is None or wire is None or len(notes) >= 4:
                continue
            place, origin = node.operand_positions[number], self._origin(wire)
            # Wiring of an operand (`v[3]`) takes the wire `v`; the text at its place is what it makes of it.
            word = "the wire" if "#" in node.path else self.typer.sources.word(place)
            if number == problem.operand and place == position:
                far = origin is not None and place is not None and origin.file == place.file
                line = f", from line {origin.line}" if origin is not None and far and origin.line != place.line else ""
                label = f"{word} is {wire_type}{line}"
            else:
                notes.append(
                    Note(f"operand {number + 1}{'' if '#' in node.path else f', `{word}`,'} is {wire_type}", origin)
                )
        guessed = [
            self.produced_by[w] for w in node.inputs if w is not None and self.produced_by.get(w) in self.assumed
        ]
        for i in guessed[:2]:
            delay = self.structure.nodes[i]
            taken = self.types[delay.outputs[0]]
            hint = (
                f"a loop hides the type of `{delay.path}`, so it is taken as {taken}; state shape, type or unit there"
            )
            notes.append(Note(hint, delay.position))
        self.typer.report(problem, position, notes, label)

    def _origin(self, wire: int) -> Position | None:
        """Where a wire comes from: the block behind anonymous wiring, or the input's declaration."""
        while wire in self.produced_by:
            node = self.structure.nodes[self.produced_by[wire]]
            first = node.inputs[0] if node.inputs else None
            if "#" not in node.path or first is None or first == POISON:
                return node.position
            wire = first
        return next((p.position for p in self.structure.inputs if p.wire == wire), None)

    def _in_loops(self, stuck: list[int]) -> set[int]:
        """The stuck nodes that lie on a loop (strongly connected)."""
        members = set(stuck)
        nodes = self.structure.nodes

        def before(i: int) -> list[int]:
            producers = (self.produced_by.get(w) for w in nodes[i].inputs if w is not None)
            return [p for p in producers if p is not None and p in members]

        found: set[int] = set()
        for component in strong_components(stuck, before):
            if is_loop(component, before):
                found.update(component)
        return found

    def _refine_delays(self) -> None:
        """A unit that a loop hid from a delay is known once the loop is typed: spread it once more."""
        learnt = False
        for i in self.assumed:
            node = self.structure.nodes[i]
            wire, output = node.inputs[0], node.outputs[0]
            if wire is None or wire == POISON:
                continue
            arriving, held = self.types[wire], self.types[output]
            if arriving is None or held is None or arriving.shape != held.shape or arriving.boolean:
                continue
            units = merge_units(held.units, arriving.units, held.size)
            if units != held.units:
                self.types[output] = WireType(held.shape, held.boolean, units)
                learnt = True
        if learnt:
            known = {
                self.structure.nodes[i].outputs[0]: self.types[self.structure.nodes[i].outputs[0]] for i in self.assumed
            }
            self.types = [None] * self.structure.wire_count
            self._input_types()
            for wire, wire_type in known.items():
                self.types[wire] = wire_type
            wave = _Wave(self.structure.nodes, self.types)
            for i in self.assumed:
                wave.done[i] = True
            self._type_ready(wave)

    def _check_delays(self) -> None:
        for node in self.structure.nodes:
            if not isinstance(node.symbol, Delay):
                continue
            wire = node.inputs[0]
            arriving = None if wire is None or wire == POISON else self.types[wire]
            held = self.types[node.outputs[0]]
            if arriving is None or held is None:
                continue
            try:
                node.symbol.check_input(arriving, held)
            except SymbolProblem as problem:
                self._refuse(node, problem, (arriving,))

    def _output_types(self) -> None:
        for port in self.structure.outputs:
            wire_type = None if port.wire == POISON else self.types[port.wire]
            if wire_type is not None:
                self.types[port.wire] = self._check_output(port, wire_type)

    def _check_output(self, port: OutputPort, wire_type: WireType) -> WireType:
        """The type of an output: the wire's, with the declared unit where the wire has none."""
        try:
            need_units(port.units, wire_type.shape)
        except SymbolProblem as wrong:
            self.typer.report(wrong, port.position, [])
            return wire_type
        clash = first_mismatch(port.units, wire_type.units)
        if clash is not None:
            _, declared, found = clash
            problem = SymbolProblem(
                "E211",
                f"output `{port.name}` has another unit",
                f"it is declared in {declared}, the wire is in {found}: {conversion_hint(found, declared)}",
                conversion_remedy(found, declared),
            )
            self.typer.report(problem, port.position, [])
        elif port.units is not None and (wire_type.units is None or isinstance(wire_type.units, tuple)):
            units = merge_units(wire_type.units, port.units, wire_type.size)
            return WireType(wire_type.shape, wire_type.boolean, units)
        return wire_type
