"""A body with its values kept in registers: what an optimising compiler makes of it.

Registers are given in the order of the operations (after a first scheduling: ``early_schedule.py``); where there are too few, the value whose next use is farthest goes
(Belady 1966), to memory if it is not there yet. Constants, inputs, results of calls and parameters beyond the registers
of the calling convention lie in memory until used. A compiler that schedules before it allocates moves a little more.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Sequence

from saoflow.operations import Atom, Kind, Literal, Table
from saoflow.scheduler.program import Operation, ProgramBody
from saoflow.targets.instructions import Instruction, Machine, Stream
from saoflow.targets.operation_form import emit_operation
from saoflow.targets.peephole import chained_products, folded_negations, is_doubling, is_negation
from saoflow.targets.target import InstructionSet

NEVER = 1 << 60


def register_form(
    body: ProgramBody, tables: Sequence[Table], isa: InstructionSet, procedure: bool
) -> list[Instruction]:
    """The instructions of a body; ``procedure``: it is called, and gets its parameters in registers and on the stack."""
    return _Allocation(body, tables, isa, procedure).instructions()


class _Allocation:
    def __init__(self, body: ProgramBody, tables: Sequence[Table], isa: InstructionSet, procedure: bool) -> None:
        self.body, self.tables, self.isa, self.procedure = body, tables, isa, procedure
        self.shares = isa.shares["registers"]
        self.stream = Stream()
        self.folded = folded_negations(body)
        self.chained = chained_products(body) if isa.multiply_add else {}
        self.taken_up = {o.results[0] for o in self.chained.values()}
        """Products that a sum computes on the way."""
        self.negated = {o.results[0]: _other(o) for o in body.operations if o.results and o.results[0] in self.folded}
        self.number: dict[Atom, int] = {}
        """What is in a register: the number that the stream knows it by."""
        self.memory: set[Atom] = set()
        self.uses: dict[Atom, list[int]] = {}
        self.calls = [k for k, o in enumerate(body.operations) if o.kind is Kind.CALL]
        self.low: set[Atom] = set()
        """What is in a register that a call does not preserve."""
        self.most_preserved = 0
        for k, o in enumerate(body.operations):
            for a in self._operands(o):
                self.uses.setdefault(a, []).append(k)
        for a in body.results:
            self.uses.setdefault(a, []).append(len(body.operations))

    def instructions(self) -> list[Instruction]:
        self._enter()
        for k, o in enumerate(self.body.operations):
            if o.kind is Kind.CALL:
                self._call(k, o)
            elif o.kind is Kind.WRITE:
                self._store(o.operands[0], k)
            elif o.kind is Kind.READ:
                self._define(o.results[0], self._load(o.results[0]), k)
                self.memory.add(o.results[0])
            elif o.results[0] not in self.folded and o.results[0] not in self.taken_up:
                self._compute(k, o)
        self._leave()
        return self.stream.instructions

    # -- the ends of a body

    def _enter(self) -> None:
        reals = 0
        for v in self.body.parameters:
            if self.body.booleans[v]:
                self.number[v] = -1
            elif self.procedure and reals < self.isa.arguments:
                reals += 1
                if v in self.uses:
                    self._place(v, 0, -1)
            else:
                self.memory.add(v)

    def _leave(self) -> None:
        end = len(self.body.operations)
        if self.procedure and len(self.body.results) == 1:
            self._in_register(self.body.results[0], end)
        else:
            for a in self.body.results:
                self._store(a, end)
        for _ in range(self.most_preserved):
            self.stream.emit(Machine.STORE)
            self.stream.emit(Machine.LOAD)
        self.stream.emit_share(Machine.INTEGER, self.shares.call)
        if self.procedure:
            self.stream.emit(Machine.BRANCH)

    # -- operations

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

    def _compute(self, k: int, o: Operation) -> None:
        atoms = self._operands(o)
        operands = [self._in_register(a, k, set(atoms)) for a in atoms]
        if o.results[0] in self.chained:
            if self._next(atoms[0], k) < NEVER:  # the addend is overwritten
                operands[0] = self.stream.emit(Machine.MOVE, operands[0])
            number = self.stream.emit(Machine.MULTIPLY_ADD, *operands)
        else:
            number = emit_operation(self.stream, o, operands, self.shares, self.tables)
        self._define(o.results[0], number, k)

    def _call(self, k: int, o: Operation) -> None:
        reals = 0
        for a in o.operands:
            if self._boolean(a):
                self.stream.emit(Machine.INTEGER)
            elif reals < self.isa.arguments:
                reals += 1
                self.stream.emit(Machine.LOAD if a not in self.number else Machine.MOVE)
            else:
                self._store(a, k)
        for a in list(self.low):
            if self._next(a, k) < NEVER:
                self._spill(a)
            self._drop(a)
        self.stream.emit(Machine.BRANCH)
        single = len(o.results) == 1
        for r in o.results:
            if single:
                self._define(r, -1, k)
            else:
                self.memory.add(r)

    # -- registers

    def _boolean(self, a: Atom) -> bool:
        return isinstance(a.value, bool) if isinstance(a, Literal) else self.body.booleans[a]

    def _next(self, a: Atom, k: int) -> int:
        uses = self.uses.get(a, ())
        i = bisect_right(uses, k)
        return uses[i] if i < len(uses) else NEVER

    def _in_register(self, a: Atom, k: int, kept: set[Atom] | None = None) -> int:
        if a in self.number:
            return self.number[a]
        number = self._load(a)
        if self._boolean(a):
            if not isinstance(a, Literal):
                self.number[a] = number
            return number
        self._place(a, k, number, kept)
        return number

    def _load(self, a: Atom) -> int:
        if isinstance(a, Literal):
            if isinstance(a.value, bool):
                return -1
            address = -1
            for _ in range(self.isa.literal):
                address = self.stream.emit(Machine.INTEGER)
            return self.stream.emit(Machine.LOAD, address)
        return self.stream.emit(Machine.INTEGER_LOAD if self._boolean(a) else Machine.LOAD)

    def _store(self, a: Atom, k: int) -> None:
        number = self._in_register(a, k)
        self.stream.emit(Machine.INTEGER_STORE if self._boolean(a) else Machine.STORE, number)

    def _define(self, a: Atom, number: int, k: int) -> None:
        if self._boolean(a):
            self.number[a] = number
        elif a in self.uses:
            self._place(a, k, number)

    def _place(self, a: Atom, k: int, number: int, kept: set[Atom] | None = None) -> None:
        """Give a value a register: a free one, or that of the value needed last."""
        kept = kept or set()
        for b in list(self.number):
            if b != a and b not in kept and not self._boolean(b) and self._next(b, k) >= NEVER:
                self._drop(b)
        real = [b for b in self.number if not self._boolean(b)]
        if len(real) >= self.isa.registers:
            victim = max((b for b in real if b not in kept), key=lambda b: self._next(b, k))
            self._spill(victim)
            self._drop(victim)
        self.number[a] = number
        high = len([b for b in self.number if not self._boolean(b) and b not in self.low]) - 1
        crosses = self._crosses(a, k)
        scratch = self.isa.registers - self.isa.preserved
        if (crosses or len(self.low) >= scratch) and high < self.isa.preserved:
            self.most_preserved = max(self.most_preserved, high + 1)
        else:
            self.low.add(a)

    def _crosses(self, a: Atom, k: int) -> bool:
        """Whether a call comes before the last use."""
        i = bisect_right(self.calls, k)
        return i < len(self.calls) and self.uses.get(a, [0])[-1] > self.calls[i]

    def _spill(self, a: Atom) -> None:
        if a not in self.memory and not isinstance(a, Literal):
            self.stream.emit(Machine.STORE, self.number[a])
            self.memory.add(a)

    def _drop(self, a: Atom) -> None:
        del self.number[a]
        self.low.discard(a)


def _other(o: Operation) -> Atom:
    """The operand of a negation or a doubling that is not the factor."""
    a, b = o.operands
    return b if isinstance(a, Literal) else a
