"""From a sheet and the numbers of its parameters to its structure: nodes and wires, sub-sheets, folds and maps."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from saoflow.blocks.library import PROFILES, SYMBOLS, AnySymbol
from saoflow.blocks.symbol import SymbolProblem
from saoflow.diagnosis import Diagnoses, DiagnosisError, Note, Position, did_you_mean
from saoflow.diagrams.connections import match, split_arguments, symbol_operands, unconnected
from saoflow.diagrams.declarations import Declarations
from saoflow.diagrams.expression_value import Quantity
from saoflow.diagrams.given import given_parameters
from saoflow.diagrams.iteration import Iteration
from saoflow.diagrams.netlist import POISON, Node, OutputPort, Structure
from saoflow.diagrams.operands import Operands
from saoflow.diagrams.parameters import ParameterValues, key_of, settle
from saoflow.diagrams.rates import place_at_rate, rate_of
from saoflow.diagrams.scope import POISONED, Ports, Scope
from saoflow.diagrams.sheet import Argument, BlockDeclaration, Connection, IterationDeclaration, Named, Sheet
from saoflow.diagrams.splice import splice
from saoflow.diagrams.store import SheetStore

MOST_NODES = 4_000_000
MOST_INSTANCES = 100_000


class StructureBuilder:
    """Builds the structure of sheets; the same sheet with the same numbers is built once."""

    def __init__(self, store: SheetStore, found: Diagnoses) -> None:
        self.store = store
        self.found = found
        self._built: dict[tuple[int, object], Structure | None] = {}
        self._path: list[Sheet] = []
        self._uses: list[Position] = []
        """Where each sheet of the path is used."""
        self._count = 0
        self._full = False

    def build(self, sheet: Sheet, values: ParameterValues, used: Position) -> Structure | None:
        """The structure of a sheet that is ``used`` there, or None if it uses itself (diagnosed)."""
        key = (id(sheet), key_of(values))
        if key not in self._built:
            self._path.append(sheet)
            self._uses.append(used)
            self._built[key] = SheetBuilder(self, sheet, values).build()
            self._path.pop()
            self._uses.pop()
        return self._built[key]

    def circle(self, sheet: Sheet, used: Position) -> list[Note]:
        """Who uses whom, from an enclosing use of ``sheet`` to this one; empty if there is none."""
        if sheet not in self._path:
            return []
        start = self._path.index(sheet)
        sheets = [*self._path[start:], sheet]
        places = [*self._uses[start + 1 :], used]
        return [
            Note(f"`{a.name.text}` uses `{b.name.text}`", place)
            for a, b, place in zip(sheets, sheets[1:], places, strict=False)
        ]

    def room_for(self, nodes: int) -> bool:
        """Whether that many further nodes are within the bound."""
        self._count += nodes
        return self._count <= MOST_NODES

    def is_first_to_lack_room(self) -> bool:
        """True once: a sheet that is too large is told in one place, not again by every sheet around it."""
        first, self._full = not self._full, True
        return first


class SheetBuilder:
    def __init__(self, builder: StructureBuilder, sheet: Sheet, values: ParameterValues) -> None:
        self.builder = builder
        self.sheet = sheet
        self.scope = Scope(sheet.file, builder.store.sources, builder.found)
        self.scope.parameters = dict(values.values)
        self.scope.broken_parameters = set(values.broken)
        self.declared = Declarations(sheet, self.scope)
        self.targets: dict[str, AnySymbol | Sheet] = {}
        self.stateful = False
        self.symbols_used: set[str] = set()

    def build(self) -> Structure:
        inputs = self.declared.inputs()
        blocks = self.declared.distinct_blocks()
        for block in blocks:
            self._announce(block)
        for block in blocks:
            if block.name.text not in self.targets:
                continue
            if isinstance(block, IterationDeclaration):
                self._iterate(block)
            else:
                self._place(block)
        outputs = self._outputs()
        return Structure(
            self.sheet.name.text,
            self.sheet.file,
            self.sheet.doc,
            self.sheet.name.position,
            inputs,
            outputs,
            tuple(self.scope.nodes),
            self.scope.wire_count,
            self.stateful,
            frozenset(self.symbols_used),
            self.declared.budget(),
        )

    # -- first pass: what the blocks are and which wires they give

    def _announce(self, block: BlockDeclaration | IterationDeclaration) -> None:
        named = block.sheet if isinstance(block, IterationDeclaration) else block.symbol
        target = self._target(named, isinstance(block, IterationDeclaration))
        self.scope.blocks[block.name.text] = POISONED
        if target is None:
            return
        if isinstance(block, IterationDeclaration):
            count = Operands(self.scope, block.name.text).whole_number(block.count, "the count")
            if count is None:
                return
            if not 1 <= count <= MOST_INSTANCES:
                self.scope.report(
                    "E216",
                    "the count is out of range",
                    block.count.position,
                    f"it is {count}, and must lie in 1 to {MOST_INSTANCES}",
                    "give the number of instances",
                )
                return
            assert isinstance(target, Sheet)
            instances = tuple(self._wires(target) for _ in range(count))
            self.scope.blocks[block.name.text] = Ports(instances, True)
        elif isinstance(target, Sheet):
            self.scope.blocks[block.name.text] = Ports((self._wires(target),), False)
        else:
            self.scope.blocks[block.name.text] = Ports(({"y": self.scope.new_wire()},), False)
        self.targets[block.name.text] = target

    def _wires(self, sheet: Sheet) -> dict[str, int]:
        return {output.name.text: self.scope.new_wire() for output in sheet.outputs}

    def _target(self, named: Named, sheet_only: bool) -> AnySymbol | Sheet | None:
        if named.text in SYMBOLS and not sheet_only:
            return SYMBOLS[named.text]
        try:
            sheet = self.builder.store.find(named.text, self.sheet)
        except DiagnosisError as error:
            self.builder.found.extend(error.diagnoses)
            return None
        if sheet is None:
            names = self.builder.store.names_beside(self.sheet)
            near = did_you_mean(named.text, names if sheet_only else [*SYMBOLS, *names])
            what = "sheet" if sheet_only else "symbol or sheet"
            cause = f"there is no {what} of that name in the library or beside {self.sheet.file}"
            if named.text in SYMBOLS:
                cause, near = "it is a symbol; fold and map repeat sheets", "make a sheet of it"
            self.scope.report(
                "E201",
                f"unknown {what} `{named.text}`",
                named.position,
                cause,
                near or "`saoflow symbols` lists the symbols",
            )
            return None
        notes = self.builder.circle(sheet, named.position)
        if notes:
            self.scope.report(
                "E213",
                f"sheet `{sheet.name.text}` uses itself",
                named.position,
                "a sheet cannot contain itself, directly or through others",
                "repeat with fold or map, or break the circle",
                notes=notes,
            )
            return None
        return sheet

    # -- second pass: operands and nodes

    def _place(self, block: BlockDeclaration) -> None:
        target = self.targets[block.name.text]
        path = block.name.text
        operands = Operands(self.scope, path)
        wires = self.scope.blocks[path].instances[0]
        if isinstance(target, Sheet):
            self._place_sheet(block, target, operands, wires)
            return
        if block.rate is not None:
            self.scope.report(
                "E224",
                f"the symbol `{target.name}` cannot have a rate of its own",
                block.rate.position,
                "`every` is for a block of a sheet",
                "put what runs more seldom into a sheet, and give the block of that sheet the rate",
            )
        if not self._profile_allows(target.name, block.symbol):
            return
        connections, arguments = split_arguments(block, {p.name for p in target.ports})
        if target.name == "constant":
            arguments, connections = self._constant_value(connections, arguments), []
        given = given_parameters(self.scope, target, arguments)
        resolved = symbol_operands(self.scope, target, block.symbol, connections, operands)
        if given is None or resolved is None:
            return
        signs, inputs, positions = resolved
        try:
            configuration = target.configure(given, signs)
        except SymbolProblem as problem:
            place = next((a.position for a in arguments if a.name.text == problem.parameter), block.symbol.position)
            self.scope.report(problem.code, problem.message, place, problem.cause, problem.remedy)
            return
        self.stateful |= not target.feeds_through
        self.symbols_used.add(target.name)
        if POISON not in inputs:
            self._add(Node(path, block.name.position, target, configuration, None, inputs, positions, (wires["y"],)))

    def _add(self, node: Node) -> None:
        self.scope.nodes.append(node)

    def _constant_value(self, connections: Sequence[Connection], arguments: list[Argument]) -> list[Argument]:
        for connection in connections[:1]:
            position = connection.wire.position
            arguments = [Argument(Named("value", position), connection.wire, "", position), *arguments]
        return arguments

    def _profile_allows(self, symbol: str, used: Named, through: str = "") -> bool:
        profile = self.sheet.profile
        if profile is None or profile.text not in PROFILES or symbol in PROFILES[profile.text]:
            return True
        by = f"sheet `{through}` uses it; " if through else ""
        self.scope.report(
            "E212",
            f"profile `{profile.text}` does not allow `{symbol}`",
            used.position,
            f"{by}the profile allows: {', '.join(s for s in SYMBOLS if s in PROFILES[profile.text])}",
            "do it with these symbols, or move it to a sheet of profile sao",
            notes=[Note("the profile is set here", profile.position)],
        )
        return False

    # -- sheets used in this sheet

    def _place_sheet(self, block: BlockDeclaration, sheet: Sheet, operands: Operands, wires: dict[str, int]) -> None:
        ports = [i.name.text for i in sheet.inputs]
        connections, arguments = split_arguments(block, ports)
        byport = match(self.scope, block.symbol, ports, connections)
        structure = self.child(sheet, arguments, block.symbol, {})
        resolved = None if byport is None else {p: operands.wire(e) for p, e in byport.items()}
        missing = [] if resolved is None else [p for p in ports if p not in resolved]
        if missing:
            unconnected(self.scope, block.symbol, missing)
        if structure is None or resolved is None or missing or byport is None:
            return
        positions = {p: e.position for p, e in byport.items()}
        if block.rate is not None:
            self._place_at_rate(block, structure, resolved, positions, wires)
            return
        self.instantiate(block.name.text, block.name.position, structure, resolved, positions, wires)

    def _place_at_rate(
        self,
        block: BlockDeclaration,
        structure: Structure,
        wires_by_port: dict[str, int],
        positions: dict[str, Position],
        outputs: dict[str, int],
    ) -> None:
        rate = rate_of(self.scope, block)
        if rate is None or POISON in wires_by_port.values():
            return
        node = self._called(block.name.text, block.name.position, structure, wires_by_port, positions, outputs)
        if place_at_rate(self.scope, block, rate, structure, node):
            self.stateful = True

    def child(
        self, sheet: Sheet, arguments: Sequence[Argument], used: Named, extra: Mapping[str, Quantity]
    ) -> Structure | None:
        values = settle(self.scope, sheet, arguments, extra, used.position)
        if values is None:
            return None
        structure = self.builder.build(sheet, values, used.position)
        if structure is None or not self.builder.room_for(len(structure.nodes)):
            if structure is not None and self.builder.is_first_to_lack_room():
                self.scope.report(
                    "E219",
                    "the elaborated sheet is too large",
                    used.position,
                    f"it has more than {MOST_NODES} blocks with all its sub-sheets laid out",
                    "lower the counts of folds and maps",
                )
            return None
        for symbol in sorted(structure.symbols_used):
            if not self._profile_allows(symbol, used, sheet.name.text):
                return None
        self.symbols_used |= structure.symbols_used
        return structure

    def instantiate(
        self,
        path: str,
        position: Position,
        structure: Structure,
        wires_by_port: dict[str, int],
        positions: dict[str, Position],
        outputs: dict[str, int],
    ) -> None:
        if POISON in wires_by_port.values():
            return
        if structure.stateful:
            self.stateful = True
            self.scope.nodes += splice(path, structure, self.scope.wire_count, wires_by_port, positions, outputs)
            self.scope.wire_count += structure.wire_count
            return
        self._add(self._called(path, position, structure, wires_by_port, positions, outputs))

    @staticmethod
    def _called(
        path: str,
        position: Position,
        structure: Structure,
        wires_by_port: dict[str, int],
        positions: dict[str, Position],
        outputs: dict[str, int],
    ) -> Node:
        order = [port.name for port in structure.inputs]
        return Node(
            path,
            position,
            None,
            None,
            structure,
            tuple(wires_by_port[name] for name in order),
            tuple(positions.get(name) for name in order),
            tuple(outputs[port.name] for port in structure.outputs),
        )

    def _iterate(self, block: IterationDeclaration) -> None:
        """Lay out the instances of a fold or map."""
        sheet = self.targets[block.name.text]
        assert isinstance(sheet, Sheet)
        Iteration(self, block, sheet).lay_out()

    # -- outputs

    def _outputs(self) -> tuple[OutputPort, ...]:
        ports: list[OutputPort] = []
        for output in self.sheet.outputs:
            wire = Operands(self.scope, f"{output.name.text}#out").wire(output.wire)
            units = None
            if output.unit is not None:
                units = self.declared.units(output.unit)
            ports.append(OutputPort(output.name.text, wire, units, output.doc, output.wire.position))
        return tuple(ports)
