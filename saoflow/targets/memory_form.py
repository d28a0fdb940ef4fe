"""A body with every operand from memory and back: what a compiler without optimisation makes of it, symbol by symbol."""

from __future__ import annotations

from collections.abc import Sequence

from saoflow.operations import Atom, Kind, Literal, Table
from saoflow.scheduler.program import Operation, ProgramBody
from saoflow.targets.instructions import Instruction, Machine, Stream
from saoflow.targets.operation_form import emit_operation
from saoflow.targets.peephole import is_doubling, is_negation
from saoflow.targets.target import InstructionSet

POINTER_REACH = 256
"""Bytes below the frame's head that a load of a pointer reaches (Thumb-2: an 8-bit negative offset)."""


def memory_form(body: ProgramBody, tables: Sequence[Table], isa: InstructionSet, procedure: bool) -> list[Instruction]:
    """The instructions of a body; ``procedure``: it is called, with parameters in registers and on the stack."""
    return _Memory(body, tables, isa, procedure).instructions()


class _Memory:
    def __init__(self, body: ProgramBody, tables: Sequence[Table], isa: InstructionSet, procedure: bool) -> None:
        self.body, self.tables, self.isa, self.procedure = body, tables, isa, procedure
        self.shares = isa.shares["memory"]
        self.stream = Stream()
        frame = 8.0 * max(1, body.value_count)
        self.far = self.shares.far * sum(max(0.0, 1.0 - reach / frame) for reach in isa.reach)
        """Instructions that form the address of a value on the stack, on average."""
        self.pointer = self.shares.pointer if frame > POINTER_REACH else 0.0
        """The same for a pointer: parameters lie at the far end of the frame."""
        self.stored: dict[Atom, int] = {}
        """What was stored: the number of the instruction's result, so that a load of it waits for the store."""

    def instructions(self) -> list[Instruction]:
        self._enter()
        for o in self.body.operations:
            if o.kind is Kind.CALL:
                self._call(o)
            elif o.kind is Kind.READ:
                self._store(o.results[0], self._load_at(o.results[0]))
            elif o.kind is Kind.WRITE:
                self._store_at(o.operands[0])
            else:
                self._compute(o)
        for k, a in enumerate(self.body.results):
            if self.procedure and len(self.body.results) == 1:
                self._load(a)
            else:
                self._store_at(a, self.procedure and k > 0)
        self.stream.emit_share(Machine.INTEGER, self.shares.call)
        self.stream.emit(Machine.BRANCH)
        return self.stream.instructions

    def _enter(self) -> None:
        reals = 0
        read = {a for o in self.body.operations for a in o.operands} | set(self.body.results)
        for v in self.body.parameters:
            if not self.procedure:
                if v in read:
                    self._store(v, self._load_at(v))
            elif self._boolean(v):
                self.stream.emit(Machine.INTEGER_STORE)
            elif reals < self.isa.arguments:
                reals += 1
                self.stream.emit(Machine.STORE)

    def _compute(self, o: Operation) -> None:
        factor = is_negation(o) or is_doubling(o)
        atoms = tuple(a for a in o.operands if not (factor and isinstance(a, Literal)))
        if o.kind is Kind.RECIPROCAL:
            atoms = (Literal(1.0), *atoms)
        operands = [self._load(a) for a in (atoms[:1] if o.kind is Kind.SELECT else atoms)]
        if o.kind is Kind.SELECT:
            operands.append(self._load(atoms[1]))
        number = emit_operation(self.stream, o, operands, self.shares, self.tables, Machine.LOAD)
        self._store(o.results[0], number)

    def _call(self, o: Operation) -> None:
        reals = 0
        for a in o.operands:
            number = self._load(a)
            if not self._boolean(a):
                reals += 1
                if reals > self.isa.arguments:
                    self.stream.emit(Machine.STORE, number)
        self.stream.emit(Machine.BRANCH)
        for r in o.results:
            self._store(r, -1 if len(o.results) == 1 else self._load(r))

    def _boolean(self, a: Atom) -> bool:
        return isinstance(a.value, bool) if isinstance(a, Literal) else self.body.booleans[a]

    def _load(self, a: Atom) -> int:
        if isinstance(a, Literal) and not self._boolean(a):
            address = -1
            for _ in range(self.isa.literal):
                address = self.stream.emit(Machine.INTEGER)
            return self.stream.emit(Machine.LOAD, address)
        if self._boolean(a):
            return self.stream.emit(Machine.INTEGER_LOAD, self.stored.get(a, -1))
        self.stream.emit_share(Machine.INTEGER, self.far)
        return self.stream.emit(Machine.LOAD, self.stored.get(a, -1))

    def _store(self, a: Atom, number: int) -> None:
        if self._boolean(a):
            self.stored[a] = self.stream.emit(Machine.INTEGER_STORE, number)
            return
        self.stream.emit_share(Machine.INTEGER, self.far)
        self.stored[a] = self.stream.emit(Machine.STORE, number)

    def _load_at(self, a: Atom) -> int:
        """A load through a pointer that lies in memory too."""
        self.stream.emit_share(Machine.INTEGER, self.pointer)
        pointer = self.stream.emit(Machine.INTEGER_LOAD)
        return self.stream.emit(Machine.INTEGER_LOAD if self._boolean(a) else Machine.LOAD, pointer)

    def _store_at(self, a: Atom, offset: bool = False) -> None:
        """A store through a pointer that lies in memory too, ``offset``: to be added to first."""
        self.stream.emit_share(Machine.INTEGER, self.pointer)
        pointer = self.stream.emit(Machine.INTEGER_LOAD)
        if offset:
            pointer = self.stream.emit(Machine.INTEGER, pointer)
        number = self._load(a)
        self.stream.emit(Machine.INTEGER_STORE if self._boolean(a) else Machine.STORE, number, pointer)
