"""From a schedule to the frame program: symbols expand into scalar operations, stateless sheets into procedures.

A procedure is made once for each pattern of structure that arrives at a sheet's inputs (which elements are literals, which
are the same value), so that products inside it can leave out what is known. A sheet that is called from one place only,
or whose procedure is small, is laid out in place. A probed wire needs its instances laid out in place too; that changes no
bit of any result.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import dataclass

from saoflow.blocks.delay import Delay
from saoflow.diagnosis import Diagnosis, DiagnosisError, Position, did_you_mean
from saoflow.diagrams.netlist import Node
from saoflow.operations import Atom, Kind, Literal, Tensor
from saoflow.scheduler.emitter import Emitter, TableNumbers
from saoflow.scheduler.guarded_call import Cut, GuardedCalls
from saoflow.scheduler.program import FrameProgram, Origin, ProgramBody, ProgramPort, RateGroup, StateSlot, TracedScope
from saoflow.scheduler.schedule import Schedule

SMALL = 10
"""Procedures of at most so many operations are laid out in place."""

Pattern = tuple[tuple[int | Literal, ...], ...]


@dataclass(frozen=True, slots=True, eq=False)
class _Procedure:
    """A lowered sheet for one pattern of inputs: its number, and its outputs in terms of its own values."""

    number: int
    body: ProgramBody
    outputs: tuple[Tensor, ...]


def lower(
    schedule: Schedule,
    *,
    real: int = 64,
    probes: Collection[str] = (),
    simplify: bool = True,
    traced: bool = False,
) -> FrameProgram:
    """Lower a schedule. ``probes`` are paths of wires (``step3.ip[2].stages[1].K``).

    ``traced`` keeps with every body where each wire of each instance in it is.

    Raises DiagnosisError E303 for a probe that does not exist.
    """
    return _Lowering(schedule, real, tuple(probes), simplify, traced).program()


class _Lowering:
    def __init__(
        self, schedule: Schedule, real: int, probes: tuple[str, ...], simplify: bool, traced: bool
    ) -> None:
        self.root = schedule
        self.real = real
        self.probes = probes
        self.simplify = simplify
        self.traced = traced
        self.tables = TableNumbers()
        self.procedures: list[ProgramBody] = []
        self.states: list[StateSlot] = []
        self.probed: dict[str, ProgramPort] = {}
        self.guarded = GuardedCalls(self.states, self.procedures)
        self._cut: Cut | None = None
        """Where the state goes of what is being lowered, if that runs at a rate of its own."""
        self._made: dict[tuple[int, Pattern], _Procedure | None] = {}
        self._call_sites = _call_sites(schedule)

    def program(self) -> FrameProgram:
        body = self.root.body
        emit = Emitter(body.structure.sheet, self.tables, self.real, self.simplify)
        inputs = []
        for port in body.structure.inputs:
            wire_type = body.type_of(port.wire)
            tensor = Tensor(wire_type.shape, tuple(emit.parameter(wire_type.boolean) for _ in range(wire_type.size)))
            inputs.append(ProgramPort(port.name, wire_type, tensor, port.doc))
        tensors = self._lower(self.root, tuple(port.tensor for port in inputs), emit, "", "")
        rates = self.guarded.finish(emit)
        outputs = tuple(
            ProgramPort(port.name, body.type_of(port.wire), tensor, port.doc)
            for port, tensor in zip(body.structure.outputs, tensors, strict=True)
        )
        self._need_all_probes()
        probes = tuple(self.probed[path] for path in self.probes)
        results = tuple(atom for port in (*outputs, *probes) for atom in port.tensor.atoms)
        return FrameProgram(
            body.structure.sheet,
            self.real,
            (RateGroup(1, 0, emit.body(results)),),
            tuple(self.procedures),
            tuple(self.tables.tables),
            tuple(self.states),
            tuple(inputs),
            outputs,
            probes,
            rates,
        )

    def _lower(
        self, schedule: Schedule, inputs: tuple[Tensor, ...], emit: Emitter, prefix: str, full: str
    ) -> tuple[Tensor, ...]:
        """Emit a body. ``prefix`` is its path inside the body being emitted, ``full`` its path in the whole program."""
        body = schedule.body
        tensors: dict[int, Tensor] = {
            port.wire: tensor for port, tensor in zip(body.structure.inputs, inputs, strict=True)
        }
        writes: list[tuple[int, int]] = []
        for i, node in enumerate(body.nodes):
            if isinstance(node.symbol, Delay):
                first = self._read(schedule, i, emit, prefix, full, tensors)
                writes.append((i, first))
        for i in schedule.order:
            node = body.nodes[i]
            if isinstance(node.symbol, Delay):
                continue
            operands = tuple(None if w is None else tensors[w] for w in node.inputs)
            path, child = prefix + node.path, schedule.children[i]
            if child is None:
                assert node.symbol is not None
                emit.at(Origin(path, node.position))
                output = body.type_of(node.outputs[0])
                tensors[node.outputs[0]] = node.symbol.expand(operands, output, node.configuration, emit)
            else:
                given = tuple(t for t in operands if t is not None)
                if node.rate is None:
                    results = self._call(child, given, emit, path, full + node.path, node.position)
                else:
                    results = self._run(child, node, given, emit, path, full + node.path)
                tensors.update(zip(node.outputs, results, strict=True))
        for i, first in writes:
            self._write(schedule, i, first, emit, prefix, tensors)
        self._take_probes(schedule, tensors, full)
        if self.traced:
            emit.traced.append(TracedScope(prefix, tuple(tensors.get(w) for w in range(body.structure.wire_count))))
        return tuple(tensors[port.wire] for port in body.structure.outputs)

    # -- state

    def _read(
        self, schedule: Schedule, i: int, emit: Emitter, prefix: str, full: str, tensors: dict[int, Tensor]
    ) -> int:
        """The delay's output from its oldest slots; returns the number of its first slot."""
        node = schedule.body.nodes[i]
        output = schedule.body.type_of(node.outputs[0])
        memory = node.configuration
        assert isinstance(node.symbol, Delay)
        states = self.states if self._cut is None else self._cut.slots
        first = len(states)
        initial = node.symbol.initial_elements(memory, output)
        emit.at(Origin(prefix + node.path, node.position))
        for age in range(memory.frames):
            for element, value in enumerate(initial):
                start = bool(value) if output.boolean else emit.literal(value).value
                states.append(StateSlot(full + node.path, element, age, start, node.position))
        if self._cut is not None:
            given = self._cut.given(first, emit, output.boolean)
            tensors[node.outputs[0]] = Tensor(output.shape, given[: output.size])
            return first
        atoms = []
        for element in range(output.size):
            number = emit.value(output.boolean)
            emit.raw(Kind.READ, (), (number,), first + element)
            atoms.append(number)
        tensors[node.outputs[0]] = Tensor(output.shape, tuple(atoms))
        return first

    def _write(
        self, schedule: Schedule, i: int, first: int, emit: Emitter, prefix: str, tensors: dict[int, Tensor]
    ) -> None:
        """Shift the slots by one frame; the input goes into the youngest."""
        node = schedule.body.nodes[i]
        output = schedule.body.type_of(node.outputs[0])
        wire = node.inputs[0]
        assert wire is not None
        emit.at(Origin(prefix + node.path, node.position))
        size = output.size
        if self._cut is not None:
            self._cut.take(first, size, tensors[wire].atoms)
            return
        moved: list[Atom] = []
        for age in range(1, node.configuration.frames):
            for element in range(size):
                number = emit.value(output.boolean)
                emit.raw(Kind.READ, (), (number,), first + age * size + element)
                moved.append(number)
        for k, atom in enumerate((*moved, *tensors[wire].atoms)):
            emit.raw(Kind.WRITE, (atom,), (), first + k)

    # -- procedures

    def _call(
        self,
        schedule: Schedule,
        inputs: tuple[Tensor, ...],
        emit: Emitter,
        path: str,
        full: str,
        position: Position,
    ) -> tuple[Tensor, ...]:
        if self._in_place(schedule, full):
            return self._lower(schedule, inputs, emit, f"{path}.", f"{full}.")
        pattern, actual = _pattern(inputs)
        procedure = self._procedure(schedule, pattern, inputs, emit, full)
        if len(procedure.body.operations) <= SMALL:
            return self._lower(schedule, inputs, emit, f"{path}.", f"{full}.")
        emit.at(Origin(path, position))
        renamed: dict[int, Atom] = dict(zip(procedure.body.parameters, actual, strict=True))
        fresh = [emit.value(procedure.body.booleans[r]) for r in procedure.body.results if isinstance(r, int)]
        renamed.update(zip((r for r in procedure.body.results if isinstance(r, int)), fresh, strict=True))
        emit.raw(Kind.CALL, tuple(actual), tuple(fresh), procedure.number)
        return tuple(
            Tensor(t.shape, tuple(a if isinstance(a, Literal) else renamed[a] for a in t.atoms))
            for t in procedure.outputs
        )

    def _in_place(self, schedule: Schedule, full: str) -> bool:
        if self._call_sites.get(id(schedule), 0) <= 1:
            return True
        return any(probe.startswith(f"{full}.") for probe in self.probes)

    def _procedure(
        self, schedule: Schedule, pattern: Pattern, inputs: tuple[Tensor, ...], emit: Emitter, full: str
    ) -> _Procedure:
        key = (id(schedule), pattern)
        found = self._made.get(key)
        if found is not None:
            return found
        inner = Emitter(schedule.body.structure.sheet, self.tables, self.real, self.simplify)
        outputs = self._lower(schedule, _formal(pattern, inputs, emit, inner), inner, "", f"{full}.")
        given = set(inner.parameters)
        computed = dict.fromkeys(a for t in outputs for a in t.atoms if isinstance(a, int) and a not in given)
        procedure = _Procedure(len(self.procedures), inner.body(tuple(computed)), outputs)
        if len(procedure.body.operations) > SMALL:
            self.procedures.append(procedure.body)
        self._made[key] = procedure
        return procedure

    # -- what runs at a rate of its own

    def _run(
        self, schedule: Schedule, node: Node, inputs: tuple[Tensor, ...], emit: Emitter, path: str, full: str
    ) -> tuple[Tensor, ...]:
        """A guarded call: a procedure of its own, its state and its held outputs in the frame's state."""
        assert node.rate is not None and self._cut is None
        pattern, actual = _pattern(inputs)
        inner = Emitter(schedule.body.structure.sheet, self.tables, self.real, self.simplify)
        before = set(self.probed)
        self._cut = cut = Cut()
        outputs = self._lower(schedule, _formal(pattern, inputs, emit, inner), inner, "", f"{full}.")
        self._cut = None
        probed = [self.probed[name] for name in self.probed if name not in before]
        named = [
            *((f"{full}.{port.name}", t) for port, t in zip(schedule.body.structure.outputs, outputs, strict=True)),
            *((port.name, port.tensor) for port in probed),
        ]
        emit.at(Origin(path, node.position))
        tensors = self.guarded.call(node, full, named, actual, inner, emit, cut)
        for port, tensor in zip(probed, tensors[len(outputs) :], strict=True):
            self.probed[port.name] = ProgramPort(port.name, port.type, tensor, port.doc)
        return tensors[: len(outputs)]

    # -- probes

    def _take_probes(self, schedule: Schedule, tensors: dict[int, Tensor], full: str) -> None:
        wanted = [p for p in self.probes if p.startswith(full) and p not in self.probed]
        if not wanted:
            return
        names = _wire_names(schedule)
        for probe in wanted:
            wire = names.get(probe[len(full) :])
            if wire is not None:
                wire_type = schedule.body.type_of(wire)
                self.probed[probe] = ProgramPort(probe, wire_type, tensors[wire], "probe")

    def _need_all_probes(self) -> None:
        missing = [probe for probe in self.probes if probe not in self.probed]
        if missing:
            known = list(_all_paths(self.root))
            raise DiagnosisError(
                [
                    Diagnosis(
                        "E303",
                        f"there is no wire `{probe}`",
                        cause="a probe is the path of a wire: block, or instance.block, or fold[0].block",
                        remedy=did_you_mean(probe, known) or f"for example: {', '.join(known[:5])}",
                    )
                    for probe in missing
                ]
            )


def _pattern(inputs: tuple[Tensor, ...]) -> tuple[Pattern, list[int]]:
    """Which elements are literals, and which are the same value; and the distinct values in order."""
    numbers: dict[int, int] = {}
    pattern = tuple(
        tuple(a if isinstance(a, Literal) else numbers.setdefault(a, len(numbers)) for a in tensor.atoms)
        for tensor in inputs
    )
    return pattern, list(numbers)


def _formal(pattern: Pattern, inputs: tuple[Tensor, ...], emit: Emitter, inner: Emitter) -> tuple[Tensor, ...]:
    """The inputs of a procedure in terms of its own values: a parameter for each distinct one, literals as they are."""
    formal: dict[int, int] = {}
    tensors = []
    for tensor, code in zip(inputs, pattern, strict=True):
        atoms: list[Atom] = []
        for atom, mark in zip(tensor.atoms, code, strict=True):
            if isinstance(mark, Literal):
                atoms.append(mark)
                continue
            if mark not in formal:
                formal[mark] = inner.parameter(emit.is_boolean(atom))
            atoms.append(formal[mark])
        tensors.append(Tensor(tensor.shape, tuple(atoms)))
    return tuple(tensors)


def _call_sites(schedule: Schedule) -> dict[int, int]:
    """From how many nodes each schedule is called."""
    sites: dict[int, int] = {}
    seen: set[int] = set()
    stack = [schedule]
    while stack:
        here = stack.pop()
        if id(here) in seen:
            continue
        seen.add(id(here))
        for child in here.children:
            if child is not None:
                sites[id(child)] = sites.get(id(child), 0) + 1
                stack.append(child)
    return sites


def _wire_names(schedule: Schedule) -> dict[str, int]:
    """The wires of one body by path: inputs, blocks, ports of called sheets, outputs."""
    structure = schedule.body.structure
    names = {port.name: port.wire for port in structure.inputs}
    names.update({port.name: port.wire for port in structure.outputs})  # as in a sheet: `stages.P_hat` is the output
    for node in structure.nodes:
        if node.child is None:
            names[node.path] = node.outputs[0]
        else:
            names.update({f"{node.path}.{p.name}": w for p, w in zip(node.child.outputs, node.outputs, strict=True)})
            if len(node.outputs) == 1:
                names[node.path] = node.outputs[0]
    return names


def _all_paths(schedule: Schedule, full: str = "", limit: int = 100_000) -> Iterator[str]:
    """Every path that can be probed, up to a bound."""
    stack = [(schedule, full)]
    while stack and limit > 0:
        here, prefix = stack.pop()
        for name in _wire_names(here):
            if "#" not in name:
                limit -= 1
                yield prefix + name
        for node, child in zip(here.body.nodes, here.children, strict=True):
            if child is not None:
                stack.append((child, f"{prefix}{node.path}."))
