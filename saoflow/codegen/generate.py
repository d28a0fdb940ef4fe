"""From a frame program to the tree of C: one struct of state, ``init`` and ``step``, a function per procedure.

C99, freestanding, no mathematics library, no heap, no recursion, no global variable, no loop that depends on data. Every
operation becomes one statement on ``const`` locals, so that a compiler without contraction computes the interpreter's bits.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from saoflow.codegen.dialect import Dialect, Lanes, Scalar
from saoflow.codegen.guided_tables import native_table_items
from saoflow.codegen.inlining import placed_procedures
from saoflow.codegen.interface import Interface, StateField
from saoflow.codegen.macros import HEADERS
from saoflow.codegen.names import Names
from saoflow.codegen.quads import quad_items, quads_fit
from saoflow.codegen.runner import RESERVED, runner, strictness
from saoflow.codegen.tables_c import table_items
from saoflow.codegen.tree import (
    Assign,
    Call,
    Declare,
    DeclareArray,
    Define,
    Directive,
    Do,
    Element,
    Expression,
    Field,
    File,
    Function,
    Include,
    Integer,
    Item,
    Parameter,
    Return,
    Statement,
    Struct,
    StructField,
    Trace,
    Variable,
    When,
)
from saoflow.operations import Atom, Kind, Literal
from saoflow.scheduler.program import FrameProgram, Operation, ProgramBody, ProgramPort
from saoflow.wires import WireType, shape_text, unit_suffix


@dataclass(frozen=True, slots=True)
class Code:
    """The files of one sheet, not yet printed."""

    header: File
    source: File
    interface: Interface


@dataclass(frozen=True, slots=True)
class About:
    """What the comment at the head says."""

    doc: str
    sheet_hash: str
    lines: tuple[str, ...]


def generate(program: FrameProgram, about: About) -> Code:
    """The header and the source of a program."""
    return _Generator(program, about, Scalar(program.real)).code()


LARGE = 1000
"""Operations of procedures beyond which they are a file of their own."""
HIDDEN = '__attribute__((visibility("hidden")))'


def native_files(program: FrameProgram, lanes: int = 0, placed: bool = False) -> tuple[File, ...]:
    """C for this machine: a frame, and the loop over frames (:mod:`saoflow.codegen.runner`).

    ``lanes``: so many flights side by side in every value; 0: one flight, with the statements of the code that flies. Look-ups
    find their interval faster here (:mod:`saoflow.codegen.guided_tables`). ``placed``: procedures are laid out where they are
    called (:mod:`saoflow.codegen.inlining`); else many of them are a file of their own, so that two processors compile, while
    somebody waits for the first frame. Every bit is the same.
    """
    dialect = Lanes(program.real, lanes) if lanes else Scalar(program.real)
    inlined = placed_procedures(program) if placed else frozenset()
    apart = not placed and sum(len(body.operations) for body in program.procedures) > LARGE
    return _Generator(program, About("", "", ()), dialect, True, inlined).native(apart)


CONTRACTION = (
    Directive("if defined(__clang__)"),
    Directive("pragma STDC FP_CONTRACT OFF"),
    Directive("endif"),
)
"""gcc has no such pragma, and warns of it: there the flag does it."""


class _Generator:
    def __init__(
        self,
        program: FrameProgram,
        about: About,
        dialect: Dialect,
        guided: bool = False,
        placed: frozenset[int] = frozenset(),
    ) -> None:
        self.program = program
        self.placed = placed
        self.about = about
        self.dialect = dialect
        self.guided = guided
        self.real = dialect.real
        self.names = Names(RESERVED | HEADERS)
        prefix = self.names.make(program.sheet, "sheet", 20)
        fields = Names()
        outputs = Names()
        ports = (*program.outputs, *program.probes)
        names = (self.names.make(f"{prefix}_{what}", what) for what in ("input", "output", "state", "init", "step"))
        inputs, results, state, init, step = names
        self.tables = [self.names.make(f"{prefix}_t{i}", f"t{i}") for i in range(len(program.tables))]
        self.procedures = [
            self.names.make(f"{prefix[:8]}_p{i}_{body.name}", f"p{i}") for i, body in enumerate(program.procedures)
        ]
        self.interface = Interface(
            prefix,
            self.real,
            inputs,
            results,
            state,
            init,
            step,
            tuple(fields.make(p.name, f"in{i}") for i, p in enumerate(program.inputs)),
            tuple(outputs.make(p.name, f"out{i}") for i, p in enumerate(ports)),
            _state_fields(program),
            tuple(self.procedures),
            tuple(self.tables),
        )
        self.slots = {
            f.first + k: Element(Field("state", f.name), Integer(k, True))
            for f in self.interface.states
            for k in range(f.size)
        }

    def code(self) -> Code:
        face = self.interface
        comment = "\n".join([*filter(None, [self.about.doc]), *self.about.lines, f"Sheets: sha256 {self.about.sheet_hash}."])
        header = File(f"{face.prefix}.h", comment, self._header_items(), f"{face.prefix.upper()}_H")
        items: list[Item] = [Include(header.name), *CONTRACTION, *self._frame(), self._init(), self._step()]
        return Code(header, File(f"{face.prefix}.c", comment, tuple(items)), face)

    def native(self, apart: bool) -> tuple[File, ...]:
        """The frame and its runner, nothing of it visible but the runner; the procedures in the same file or one before it."""
        face, lanes = self.interface, self.dialect if isinstance(self.dialect, Lanes) else None
        head = [*strictness(), *self._lane_types(lanes)]
        structs = [item for item in self._header_items() if isinstance(item, Struct)]
        frame = [replace(self._step(), static=True), runner(self.program, face, lanes)]
        if not apart:
            return (File(f"{face.prefix}.c", "", (*head, *structs, *self._frame(), *frame)),)
        shared = [replace(p, static=False, type=f"{HIDDEN} {p.type}") for p in self._procedures()]
        declared = [replace(procedure, body=None, comment="") for procedure in shared]
        (group,) = self.program.groups
        return (
            File(f"{face.prefix}_procedures.c", "", (*head, *self._tables(self.program.procedures), *shared)),
            File(f"{face.prefix}.c", "", (*head, *structs, *self._tables([group.body]), *declared, *frame)),
        )

    def _lane_types(self, lanes: Lanes | None) -> tuple[Item, ...]:
        if lanes is None:
            return ()
        return (*lanes.items(), *(quad_items(lanes.bits) if quads_fit(lanes.count) else ()))

    def _frame(self) -> list[Item]:
        """The tables and the procedures."""
        return [*self._tables(self.program.bodies), *self._procedures()]

    def _tables(self, bodies: Sequence[ProgramBody]) -> list[Item]:
        """The tables that are read there."""
        read = {op.detail for body in bodies for op in body.operations if op.kind is Kind.LOOKUP}
        lanes = self.dialect.count if isinstance(self.dialect, Lanes) else 0
        items: list[Item] = []
        for number in sorted(read):
            name, table = self.tables[number], self.program.tables[number]
            if self.guided:
                items += native_table_items(name, table, self.program.real, lanes)
            else:
                items += table_items(name, table, self.program.real)
        return items

    def _procedures(self) -> list[Function]:
        return [self._procedure(i, body) for i, body in enumerate(self.program.procedures)]

    # -- the header

    def _header_items(self) -> tuple[Item, ...]:
        face, program = self.interface, self.program
        outputs = (*program.outputs, *program.probes)
        state = [StructField(self._type(f.boolean), f.name, f.size, f"delay {f.path}") for f in face.states]
        empty = StructField("unsigned char", "empty", 0, "C has no empty structs")
        upper = face.prefix.upper()
        return (
            Define(f"{upper}_INPUT_ELEMENTS", f"{sum(p.type.size for p in program.inputs)}u"),
            Define(f"{upper}_OUTPUT_ELEMENTS", f"{sum(p.type.size for p in outputs)}u"),
            Define(f"{upper}_STATE_SLOTS", f"{len(program.states)}u"),
            Struct(face.input_struct, self._ports(program.inputs, face.inputs) or (empty,), "Inputs of a frame."),
            Struct(face.output_struct, self._ports(outputs, face.outputs) or (empty,), "Outputs of a frame."),
            Struct(face.state_struct, tuple(state) or (empty,), "What is remembered between frames."),
            Function("void", face.init, (self._state_parameter(),), None, False, "The state before the first frame."),
            Function("void", face.step, self._step_parameters(), None, False, "One frame."),
        )

    def _ports(self, ports: tuple[ProgramPort, ...], names: tuple[str, ...]) -> tuple[StructField, ...]:
        return tuple(
            StructField(self._type(p.type.boolean), name, p.type.size if p.type.shape else 0, _port_text(p))
            for p, name in zip(ports, names, strict=True)
        )

    def _type(self, boolean: bool) -> str:
        return self.dialect.boolean if boolean else self.real

    def _state_parameter(self) -> Parameter:
        return Parameter(f"{self.interface.state_struct} *", "state")

    def _step_parameters(self) -> tuple[Parameter, ...]:
        face = self.interface
        return (
            self._state_parameter(),
            Parameter(f"const {face.input_struct} *", "input"),
            Parameter(f"{face.output_struct} *", "output"),
        )

    # -- the functions

    def _init(self) -> Function:
        body: list[Statement] = []
        for f in self.interface.states:
            for k in range(f.size):
                value = self.program.states[f.first + k].initial
                body.append(
                    Assign(Element(Field("state", f.name), Integer(k, True)), self.dialect.literal(Literal(value)))
                )
        if not body:
            body.append(Assign(Field("state", "empty"), Integer(0, True)))
        return Function("void", self.interface.init, (self._state_parameter(),), tuple(body), False)

    def _procedure(self, number: int, body: ProgramBody) -> Function:
        parameters = tuple(Parameter(f"const {self._type(body.booleans[v])}", f"v{v}") for v in body.parameters)
        statements = list(self._operations(body, f"{body.name}: "))
        single = len(body.results) == 1
        if single:
            (atom,) = body.results
            statements.append(Return(self._atom(atom)))
            result = self._type(self._is_boolean(body, atom))
        else:
            counts = [0, 0]
            for atom in body.results:
                boolean = self._is_boolean(body, atom)
                target = Element(Variable("q" if boolean else "r"), Integer(counts[boolean], True))
                counts[boolean] += 1
                statements.append(Assign(target, self._atom(atom)))
            if counts[0]:
                parameters += (Parameter(f"{self.real} *", "r"),)
            if counts[1]:
                parameters += (Parameter(f"{self.dialect.boolean} *", "q"),)
            result = "void"
        comment = f"Sheet {body.name}: {len(body.operations)} operations."
        result = f"inline __attribute__((always_inline)) {result}" if number in self.placed else result
        return Function(result, self.procedures[number], parameters, tuple(statements), True, comment)

    def _step(self) -> Function:
        (group,) = self.program.groups
        statements: list[Statement] = []
        read = _read(group.body)
        for port, name in zip(self.program.inputs, self.interface.inputs, strict=True):
            for k, atom in enumerate(port.tensor.atoms):
                if atom not in read:
                    continue
                source = _element(Field("input", name), port.type, k)
                trace = Trace(f"input {port.name}", self.program.sheet, 0)
                statements.append(Declare(f"const {self._type(port.type.boolean)}", f"v{atom}", source, trace))
        statements += self._operations(group.body, "")
        ports = (*self.program.outputs, *self.program.probes)
        atoms = iter(group.body.results)
        for port, name in zip(ports, self.interface.outputs, strict=True):
            for k in range(port.type.size):
                target = _element(Field("output", name), port.type, k)
                statements.append(Assign(target, self._atom(next(atoms))))
        unused = [] if read.intersection(group.body.parameters) else ["input"]
        unused += [] if self.program.states else ["state"]
        unused += [] if ports else ["output"]
        statements += [Do(Call("(void)", (Variable(name),))) for name in unused]
        return Function("void", self.interface.step, self._step_parameters(), tuple(statements), False)

    def _operations(self, body: ProgramBody, prefix: str) -> list[Statement]:
        statements: list[Statement] = []
        read = _read(body)
        for number, op in enumerate(body.operations):
            origin = body.origins[op.origin]
            trace = Trace(prefix + origin.path, origin.position.file, origin.position.line)
            if op.kind is Kind.CALL:
                statements += self._call(body, op, number, trace, read)
            elif op.kind is Kind.WRITE:
                statements.append(Assign(self.slots[op.detail], self._atom(op.operands[0]), trace))
            else:
                (result,) = op.results
                kind = f"const {self._type(body.booleans[result])}"
                statements.append(Declare(kind, f"v{result}", self._value(body, op), trace))
        return statements

    def _call(self, body: ProgramBody, op: Operation, number: int, trace: Trace, read: set[Atom]) -> list[Statement]:
        arguments = tuple(self._atom(a) for a in op.operands)
        name = self.procedures[op.detail]
        if len(op.results) == 1 and op.guard is None:
            (result,) = op.results
            kind = f"const {self._type(body.booleans[result])}"
            return [Declare(kind, f"v{result}", Call(name, arguments), trace)]
        statements: list[Statement] = []
        results: list[Statement] = []
        counts = [0, 0]
        held: list[Statement] = []
        for k, result in enumerate(op.results):
            boolean = body.booleans[result]
            array = Variable(f"{'q' if boolean else 'r'}{number}")
            source = Element(array, Integer(counts[boolean], True))
            counts[boolean] += 1
            if op.guard is not None:
                held.append(Assign(source, self._atom(op.otherwise[k]), trace))
            if result in read:
                results.append(Declare(f"const {self._type(boolean)}", f"v{result}", source, trace))
        for which, count in enumerate(counts):
            if count:
                array = Variable(f"{'q' if which else 'r'}{number}")
                statements.append(DeclareArray(self._type(bool(which)), array.name, count, trace))
                arguments += (array,)
        call: Statement = Do(Call(name, arguments), trace)
        if op.guard is None:
            return [*statements, call, *results]
        if len(op.results) == 1:  # its procedure returns the value
            target = Variable(f"{'q' if counts[1] else 'r'}{number}")
            call = Assign(Element(target, Integer(0, True)), Call(name, arguments[:-1]), trace)
        runs = When(self.dialect.whether(self._atom(op.guard)), (call,))
        return [*statements, *held, runs, *results]

    def _value(self, body: ProgramBody, op: Operation) -> Expression:
        operands = [self._atom(a) for a in op.operands]
        if op.kind is Kind.READ:
            return self.slots[op.detail]
        if op.kind is Kind.LOOKUP:
            name = self.tables[op.detail]
            return Call(f"{name}_lanes" if isinstance(self.dialect, Lanes) else name, tuple(operands))
        return self.dialect.operation(op.kind, operands, bool(op.results) and body.booleans[op.results[0]])

    def _atom(self, atom: Atom) -> Expression:
        return self.dialect.literal(atom) if isinstance(atom, Literal) else Variable(f"v{atom}")

    @staticmethod
    def _is_boolean(body: ProgramBody, atom: Atom) -> bool:
        return isinstance(atom.value, bool) if isinstance(atom, Literal) else body.booleans[atom]


def _read(body: ProgramBody) -> set[Atom]:
    """What the operations and results of a body read."""
    return {a for op in body.operations for a in op.reads} | set(body.results)


def _element(base: Expression, wire_type: WireType, k: int) -> Expression:
    return Element(base, Integer(k, True)) if wire_type.shape else base


def _port_text(port: ProgramPort) -> str:
    unit = unit_suffix(port.type.units)
    return (
        f"{port.name}: {shape_text(port.type.shape)}{',' + unit if unit else ''}{'; ' + port.doc if port.doc else ''}"
    )


def _state_fields(program: FrameProgram) -> tuple[StateField, ...]:
    names = Names()
    fields: list[StateField] = []
    start = 0
    for i in range(1, len(program.states) + 1):
        if i == len(program.states) or program.states[i].path != program.states[start].path:
            slot = program.states[start]
            name = names.make(slot.path, f"delay{len(fields)}")
            fields.append(StateField(name, slot.path, start, i - start, isinstance(slot.initial, bool)))
            start = i
    return tuple(fields)
