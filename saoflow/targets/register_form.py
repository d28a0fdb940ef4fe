"""A body with its values kept in registers: what an optimising compiler makes of it.

The operations come scheduled once (``early_schedule.py``); registers are given for whole lives of values
(``live_ranges.py``), and places on the stack for the rest (``stack_frame.py``). Constants are loaded anew after each branch.
Inputs, state and results of calls are loaded once: what finds no register after that gets a place on the stack of its own, as
a later store might overwrite where it came from; parameters beyond the registers of the calling convention stay where they
are. A comparison that selections alone read stays a flag; any other becomes a value. What is only carried from one place in
memory to another and finds no register for reals goes through a pair of integer ones, on PowerPC.
"""

from __future__ import annotations

import math
from collections.abc import Sequence, Set

from saoflow.operations import Atom, Kind, Literal, Table
from saoflow.scheduler.program import Operation, ProgramBody
from saoflow.targets.instructions import Instruction, Machine, Stream
from saoflow.targets.live_ranges import Allocation, Life, Registers, allocate
from saoflow.targets.operation_form import emit_operation
from saoflow.targets.peephole import blocks, chained_products, flags, folded_negations, is_doubling, is_negation
from saoflow.targets.stack_frame import INPUT, RETURNED, StackFrame
from saoflow.targets.target import InstructionSet

Value = int | tuple[Literal, int]
"""A value, or a constant and the straight line that it is loaded for."""

PAIR = 2
"""Integer registers that carry one real."""


def register_form(
    body: ProgramBody, tables: Sequence[Table], isa: InstructionSet, procedure: bool, called: Set[int] = frozenset()
) -> list[Instruction]:
    """The instructions of a body.

    ``procedure``: it is called, and gets its parameters in registers and on the stack. ``called``: tables whose look-up is a
    function of its own, which leaves only the preserved registers as they were.
    """
    return _Form(body, tables, isa, procedure, called).instructions()


class _Form:
    def __init__(
        self, body: ProgramBody, tables: Sequence[Table], isa: InstructionSet, procedure: bool, called: Set[int]
    ) -> None:
        self.body, self.tables, self.isa, self.procedure = body, tables, isa, procedure
        self.shares = isa.shares["registers"]
        self.stream = Stream()
        self.folded = folded_negations(body)
        self.chained = chained_products(body) if isa.multiply_add else {}
        self.taken_up = {o.results[0] for o in self.chained.values()}
        """Products that a sum computes on the way."""
        self.negated = {o.results[0]: _other(o) for o in body.operations if o.results and o.results[0] in self.folded}
        self.flags = flags(body)
        self.atoms = [self._operands(o) for o in body.operations]
        self.line = [*blocks(body, isa.conditional_moves), -1]
        self.lives = self._lives()
        leaves = [o.kind is Kind.CALL or (o.kind is Kind.LOOKUP and o.detail in called) for o in body.operations]
        calls = [k for k, left in enumerate(leaves) if left]
        most = Registers(isa.registers - isa.held_back, isa.preserved, isa.near)
        self.held: Allocation = allocate(list(self.lives.values()), len(body.operations), calls, most)
        self.carried = self._carried()
        spilled = [life for life in self.lives.values() if life.value in self.held.in_memory and not life.stored]
        self.frame = StackFrame(body, spilled, self.held.saved, isa, procedure)
        self.number: dict[Value, int] = {}
        """What the stream knows a value by that is in a register now."""

    def instructions(self) -> list[Instruction]:
        pairs = PAIR * len(self.carried)
        kept = max(0, min(pairs - self.isa.integer_scratch, self.isa.integer_preserved))
        reals = min(1, self.held.saved) if self.isa.save_many else self.held.saved
        kept = min(1, kept) if self.isa.save_many else kept
        for _ in range(reals):
            self.stream.emit(Machine.STORE)
        for _ in range(kept):
            self.stream.emit(Machine.INTEGER_STORE)
        for v in self.body.parameters:
            if v in self.lives and self.lives[v].made:
                self._define(v, -1)
        for k, o in enumerate(self.body.operations):
            self._operation(k, o)
        single = self.procedure and len(self.body.results) == 1
        for a in self.body.results:  # none, if the scheduler made operations of their stores
            number = self._get(a, len(self.body.operations))
            if not single:
                self.stream.emit(Machine.INTEGER_STORE if self._boolean(a) else Machine.STORE, number)
        for _ in range(reals):
            self.stream.emit(Machine.LOAD)
        for _ in range(kept):
            self.stream.emit(Machine.INTEGER_LOAD)
        self.stream.emit_share(Machine.INTEGER, self.shares.call)
        if self.procedure:
            self.stream.emit(Machine.BRANCH)
        return self.stream.instructions

    # -- what lives where

    def _value(self, a: Atom, k: int) -> Value:
        return (a, self.line[k]) if isinstance(a, Literal) else a

    def _lives(self) -> dict[Value, Life]:
        body = self.body
        reads: dict[Value, list[int]] = {}
        for k, atoms in enumerate((*self.atoms, body.results)):
            for a in dict.fromkeys(atoms):
                if not self._boolean(a):
                    reads.setdefault(self._value(a, k), []).append(k)
        born: dict[Value, int] = {}
        arrived = [v for v in body.parameters if not body.booleans[v]][: self.isa.arguments] if self.procedure else []
        born.update(dict.fromkeys(arrived, -1))
        for k, o in enumerate(body.operations):
            if o.kind is not Kind.CALL or len(o.results) == 1:
                born.update(dict.fromkeys(o.results, k))
        return {
            a: Life(a, born.get(a, places[0]), tuple(places), a not in born, a in born) for a, places in reads.items()
        }

    def _carried(self) -> frozenset[Value]:
        """Read from memory, written to memory, not computed with, and without a register."""
        if not self.isa.carried_by_integers:
            return frozenset()
        read = {o.results[0] for o in self.body.operations if o.kind is Kind.READ}
        return frozenset(
            a
            for a in self.held.in_memory
            if a in read and all(k < len(self.atoms) and self._writes(k) for k in self.lives[a].reads)
        )

    def _writes(self, k: int) -> bool:
        return self.body.operations[k].kind is Kind.WRITE

    def _operands(self, o: Operation) -> tuple[Atom, ...]:
        if o.results and (o.results[0] in self.folded or o.results[0] in self.taken_up):
            return ()
        if o.results and o.results[0] in self.chained:
            product = self.chained[o.results[0]]
            rest = [self._plain(a) for a in o.operands if a != product.results[0]]
            return (*rest, *(self._plain(a) for a in product.operands))
        if is_negation(o) or is_doubling(o):
            return (_other(o),)
        found = tuple(self._plain(a) for a in o.operands)
        return (Literal(1.0), *found) if o.kind is Kind.RECIPROCAL else found

    def _plain(self, a: Atom) -> Atom:
        return self.negated.get(a, a) if isinstance(a, int) else a

    def _boolean(self, a: Atom) -> bool:
        return isinstance(a.value, bool) if isinstance(a, Literal) else self.body.booleans[a]

    # -- operations

    def _operation(self, k: int, o: Operation) -> None:
        if o.kind is Kind.CALL:
            self._call(k, o)
        elif o.kind is Kind.WRITE:
            self._write(k)
        elif o.kind is Kind.READ:
            self._read(o)
        elif o.results[0] not in self.folded and o.results[0] not in self.taken_up:
            self._compute(k, o)

    def _compute(self, k: int, o: Operation) -> None:
        atoms = self.atoms[k]
        operands = [self._get(a, k) for a in atoms]
        if o.results[0] in self.chained:
            addend = self.lives.get(self._value(atoms[0], k))
            if addend is not None and addend.end > k:  # the addend is overwritten
                operands[0] = self.stream.emit(Machine.MOVE, operands[0])
            number = self.stream.emit(Machine.MULTIPLY_ADD, *operands)
            if self._tied(atoms[0], o.results[0], k):
                number = self.stream.emit_share(Machine.MOVE, self.shares.tied, number)
        else:
            if o.kind is Kind.SELECT and atoms[0] not in self.flags:
                operands[0] = self.stream.emit_share(Machine.INTEGER, self.shares.test, operands[0])
            number = emit_operation(self.stream, o, operands, self.shares, self.tables)
            if o.kind in (Kind.LESS, Kind.LESS_EQUAL) and o.results[0] not in self.flags:
                number = self.stream.emit_share(Machine.INTEGER, self.shares.value, number)
        self._define(o.results[0], number)

    def _tied(self, addend: Atom, result: int, k: int) -> bool:
        """Whether a sum's register may have to change: it is its addend's too, and both are kept."""
        before, after = self.lives.get(self._value(addend, k)), self.lives.get(result)
        if before is None or before.end > k:
            return False
        if before.value in self.held.in_memory:
            return True
        if after is None or after.value in self.held.in_memory or len(after.reads) > 1:
            return False
        last = after.reads[0]
        if last == len(self.atoms):
            return False
        results = self.body.operations[last].results
        return bool(results) and results[0] in self.chained and self.atoms[last][0] == result

    def _call(self, k: int, o: Operation) -> None:
        reals = 0
        for a in o.operands:
            if self._boolean(a):
                self.stream.emit(Machine.INTEGER)
            elif reals < self.isa.arguments:
                reals += 1
                value = self._value(a, k)
                if value in self.number and not self.held.needs_load(value, k):
                    self.stream.emit(Machine.MOVE, self.number[value])
                else:
                    self._load(a)
            else:
                self.stream.emit(Machine.STORE, self._get(a, k))
        if not o.results:
            self.stream.emit(Machine.INTEGER)  # where its results go
        self.stream.emit(Machine.BRANCH)
        if len(o.results) == 1:
            self._define(o.results[0], -1)

    def _write(self, k: int) -> None:
        (a,) = self.atoms[k]
        self._form_address(self.frame.state(self.body.operations[k].detail))
        if a in self.carried:
            for _ in range(PAIR):
                self.stream.emit(Machine.INTEGER_STORE, self.stream.emit(Machine.INTEGER_LOAD))
        else:
            self.stream.emit(Machine.INTEGER_STORE if self._boolean(a) else Machine.STORE, self._get(a, k))

    def _read(self, o: Operation) -> None:
        (r,) = o.results
        if self._boolean(r):
            self.number[r] = self.stream.emit(Machine.INTEGER_LOAD)
        elif r in self.lives and r not in self.carried:
            far = self.frame.source(r) if o.detail in (INPUT, RETURNED) else self.frame.state(o.detail)
            self._define(r, self.stream.emit(Machine.LOAD, self._form_address(far)))

    # -- registers and memory

    def _get(self, a: Atom, k: int) -> int:
        """The number of a value where operation ``k`` reads it, loaded if it is not in a register."""
        value = self._value(a, k)
        if self._boolean(a):
            return self.number.get(value, -1)
        if value not in self.number or self.held.needs_load(value, k):
            self.number[value] = self._load(a)
        return self.number[value]

    def _load(self, a: Atom) -> int:
        if not isinstance(a, Literal):
            return self.stream.emit(Machine.LOAD, self._form_address(self.frame.slot(a)))
        if self.isa.small_constants and small_constant(a):
            return self.stream.emit(Machine.MOVE)
        address = -1
        for _ in range(self.isa.literal):
            address = self.stream.emit(Machine.INTEGER)
        return self.stream.emit(Machine.LOAD, address)

    def _form_address(self, count: int) -> int:
        """Instructions that form an address; the number of the last."""
        number = -1
        for _ in range(count):
            number = self.stream.emit(Machine.INTEGER, number)
        return number

    def _define(self, a: int, number: int) -> None:
        if self._boolean(a):
            self.number[a] = number
        elif a in self.lives:
            self.number[a] = number
            life = self.lives[a]
            if not life.stored and any(self.held.needs_load(a, k) for k in life.reads):
                self._form_address(self.frame.slot(a))
                self.stream.emit(Machine.STORE, number)
                self.stream.emit_share(Machine.MOVE, self.shares.moved, number)


def small_constant(a: Literal) -> bool:
    """Whether a constant is part of a move: +-n/16 * 2^r, n from 16 to 31, r from -3 to 4 (VFPExpandImm)."""
    fraction, exponent = math.frexp(abs(float(a.value)))
    return fraction > 0.0 and -2 <= exponent <= 5 and (fraction * 32).is_integer()


def _other(o: Operation) -> Atom:
    """The operand of a negation or a doubling that is not the factor."""
    a, b = o.operands
    return b if isinstance(a, Literal) else a
