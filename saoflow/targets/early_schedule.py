"""Operations in the order in which a compiler has them when it gives out registers: scheduled once already.

Compilers for in-order processors schedule before they allocate, to have long ways started early, and hold back what
would make more values alive than there are registers. The order before that is not the sheet's: see
``expression_order.py``; how GCC schedules it under register pressure: see ``pressure_orders.py``.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace

from saoflow.operations import Atom, Kind
from saoflow.scheduler.program import Operation, ProgramBody
from saoflow.targets.expression_order import expression_order
from saoflow.targets.instructions import Machine
from saoflow.targets.operation_form import machine_of
from saoflow.targets.peephole import branches, chained_products, folded_negations
from saoflow.targets.pressure_orders import model_order, written_order
from saoflow.targets.stack_frame import INPUT, RETURNED
from saoflow.targets.straight_line import StraightLine, Unit
from saoflow.targets.target import InstructionSet, Target

LONGEST = 2000
"""Units of a straight line that are scheduled together."""


def scheduled_early(body: ProgramBody, target: Target, real: int, procedure: bool) -> ProgramBody:
    """The body with its operations, the loads of the frame's inputs and the stores of results, list-scheduled.

    Operations stay between the branches that they are between. A body that returns one real keeps it as its result; the
    results of all others are written by operations of their own.
    """
    single = procedure and len(body.results) == 1
    stores = [] if single else [Operation(Kind.WRITE, (), (r,), -1, 0) for r in body.results]
    operations = [*([] if procedure else _input_loads(body)), *_results_loaded(body), *stores]
    operations = expression_order(operations, body.results if single else (), target.instruction_set.conditional_moves)
    state = _Pressure(body, operations, body.results if single else (), target.instruction_set)
    if procedure:
        state.arrive(body.parameters, target.instruction_set.arguments)
    order: list[Operation] = []
    block: list[Operation] = []
    branch = branches(operations, target.instruction_set.conditional_moves)
    for o, branching in zip(operations, branch, strict=True):
        if branching or o.kind is Kind.CALL:
            order += [*_reordered(block, target, real, state), o]
            for unit in state.units([o]):
                state.pass_by(unit)
            block = []
        else:
            block.append(o)
    order += _reordered(block, target, real, state)
    return replace(body, operations=tuple(order), results=body.results if single else ())


def _input_loads(body: ProgramBody) -> list[Operation]:
    read = {a for o in body.operations for a in o.operands} | set(body.results)
    return [Operation(Kind.READ, (v,), (), INPUT, 0) for v in body.parameters if v in read and not body.booleans[v]]


def _results_loaded(body: ProgramBody) -> list[Operation]:
    """The operations, a call's several results loaded after it: a later call might overwrite them where they lie."""
    read = {a for o in body.operations for a in o.operands} | set(body.results)
    found: list[Operation] = []
    for o in body.operations:
        if o.kind is not Kind.CALL or len(o.results) == 1:
            found.append(o)
            continue
        found.append(replace(o, results=()))
        found += [Operation(Kind.READ, (r,), (), RETURNED, o.origin) for r in o.results if r in read]
    return found


class _Pressure:
    """Which reals are alive, how often each will be read, and which operations become one instruction with another."""

    def __init__(
        self, body: ProgramBody, operations: Sequence[Operation], kept: Sequence[Atom], isa: InstructionSet
    ) -> None:
        self.booleans = body.booleans
        self.registers = isa.registers - isa.preserved
        """GCC counts registers that a body has to save as no gain where it runs once (sched_pressure_start_bb)."""
        written = replace(body, operations=tuple(operations), results=tuple(kept))
        self.folded = folded_negations(written)
        self.negated = {r: a for o in operations for r in o.results if r in self.folded for a in _values(o.operands)}
        self.chained = chained_products(written) if isa.multiply_add else {}
        self.taken_up = {o.results[0] for o in self.chained.values()}
        self.left: dict[int, int] = {}
        """By real: how many instructions will read it."""
        self.alive: set[int] = set()
        for unit in self.units(operations):
            for a in self.reals(unit.reads):
                self.left[a] = self.left.get(a, 0) + 1
        for r in self.reals(_values(kept)):
            self.left[r] = self.left.get(r, 0) + 1

    def units(self, operations: Sequence[Operation]) -> list[Unit]:
        """What operations become: a sum takes up a product, a negation is no instruction."""
        found: list[Unit] = []
        for o in operations:
            if self.gone(o) or (o.results and o.results[0] in self.taken_up):
                continue
            product = self.chained.get(o.results[0]) if o.results else None
            whole = (o,) if product is None else (product, o)
            kind = _kind(o) if product is None else Machine.MULTIPLY_ADD
            found.append(Unit(whole, kind, self._read(whole), o.results))
        return found

    def gone(self, o: Operation) -> bool:
        """Whether an operation is no instruction: a negation that its readers take up."""
        return bool(o.results) and o.results[0] in self.folded

    def _read(self, operations: Sequence[Operation]) -> frozenset[int]:
        """What one instruction that does all of the operations reads."""
        made = {r for o in operations for r in o.results}
        found = {self.negated.get(a, a) for o in operations for a in _values(o.reads)}
        return frozenset(found - made)

    def reals(self, values: Iterable[int]) -> set[int]:
        """Those of some values that are real."""
        return {a for a in values if not self.booleans[a]}

    def arrive(self, parameters: Sequence[int], most: int) -> None:
        """The first parameters are in registers when the body is called."""
        reals = [v for v in parameters if not self.booleans[v]][:most]
        self.alive |= {v for v in reals if self.left.get(v, 0)}

    def pass_by(self, unit: Unit) -> None:
        """A unit comes next."""
        for a in self.reals(unit.reads):
            self.left[a] -= 1
            if not self.left[a]:
                self.alive.discard(a)
        self.alive.update(r for r in self.reals(unit.results) if self.left.get(r, 0))


def _reordered(block: list[Operation], target: Target, real: int, state: _Pressure) -> list[Operation]:
    timings = {kind: target.timing(kind, real) for kind in target.kinds()}
    order = model_order if target.instruction_set.model_schedule else written_order
    found = [o for o in block if state.gone(o)]
    units = state.units(block)
    for start in range(0, len(units), LONGEST):
        part = units[start : start + LONGEST]
        line = StraightLine(
            part, timings, target.issue_width, state.registers, len(state.alive), state.reals, state.left
        )
        found += [o for k in (order(line) if len(part) > 1 else range(len(part))) for o in part[k].operations]
        for unit in part:
            state.pass_by(unit)
    return found


def _values(atoms: Iterable[Atom]) -> list[int]:
    return [a for a in atoms if isinstance(a, int)]


def _kind(o: Operation) -> Machine:
    return machine_of(o) or {Kind.READ: Machine.LOAD, Kind.WRITE: Machine.STORE}.get(o.kind, Machine.COMPARE)
