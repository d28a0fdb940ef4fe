"""Lowering what runs at a rate of its own: a call under a guard, with its state and its held outputs in the frame's state.

The guard is the first of ``every`` booleans that move on by one each frame; one of them is true. So a frame knows what
runs in it from its own state, and a run can be stopped, saved and resumed anywhere.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

from saoflow.diagrams.netlist import Node, Rate
from saoflow.operations import Atom, Kind, Literal, Tensor
from saoflow.scheduler.balance import Task, balanced
from saoflow.scheduler.counts import count_procedures
from saoflow.scheduler.emitter import Emitter
from saoflow.scheduler.program import Origin, ProgramBody, RunRate, StateSlot


@dataclass(slots=True)
class Cut:
    """The delays inside a guarded procedure: what they hold comes in as parameters, what they store goes out as results."""

    slots: list[StateSlot] = field(default_factory=list)
    parameters: list[int] = field(default_factory=list)
    stored: dict[int, Atom] = field(default_factory=dict)

    def given(self, first: int, emit: Emitter, boolean: bool) -> tuple[int, ...]:
        """Parameters for the slots from ``first`` on; the oldest come first."""
        new = tuple(emit.parameter(boolean) for _ in self.slots[first:])
        self.parameters += new
        return new

    def take(self, first: int, size: int, arriving: Sequence[Atom]) -> None:
        """The slots of a delay move on by one run; what arrives goes into the youngest."""
        count = sum(1 for slot in self.slots[first:] if slot.path == self.slots[first].path)
        moved: list[Atom] = list(self.parameters[first + size : first + count])
        self.stored.update((first + k, atom) for k, atom in enumerate([*moved, *arriving]))


@dataclass(frozen=True, slots=True)
class _Placed:
    """A guarded call of the frame: its rate, its procedure, and the first slot of its guard."""

    path: str
    rate: Rate
    procedure: int
    guard: int


class GuardedCalls:
    """All guarded calls of a program. They stand in the frame body: a sheet that contains one has state."""

    def __init__(self, states: list[StateSlot], procedures: list[ProgramBody]) -> None:
        self.states = states
        self.procedures = procedures
        self.placed: list[_Placed] = []
        self._writes: list[tuple[Origin, int, Atom]] = []

    def call(
        self,
        node: Node,
        full: str,
        named: Sequence[tuple[str, Tensor]],
        actual: Sequence[int],
        inner: Emitter,
        emit: Emitter,
        cut: Cut,
    ) -> tuple[Tensor, ...]:
        """Emit the call; returns the named tensors (outputs and probes) in terms of the frame's values."""
        assert node.rate is not None
        origin = Origin(emit.origins[-1].path, node.position)
        first = len(self.states)
        guard = self._guard(node.rate.every, full, origin, emit)
        held = [(name, k, a) for name, tensor in named for k, a in enumerate(tensor.atoms) if isinstance(a, int)]
        results: list[Atom] = [a for _, _, a in held]
        results += [cut.stored[slot] for slot in range(len(cut.slots))]
        self.procedures.append(inner.body(tuple(results)))
        state = [self._slot(slot, emit) for slot in cut.slots]
        kept = []
        for name, element, atom in held:
            boolean = inner.is_boolean(atom)
            start = bool(node.rate.held) if boolean else emit.literal(node.rate.held).value
            kept.append(self._slot(StateSlot(f"{name}#held", element, 0, start, node.position), emit))
        fresh = [emit.value(inner.is_boolean(atom)) for atom in results]
        before = [*kept, *state]
        operands = (*actual, *(value for _, value in state))
        emit.raw(
            Kind.CALL, operands, tuple(fresh), len(self.procedures) - 1, guard, tuple(value for _, value in before)
        )
        self._writes += [(origin, slot, value) for (slot, _), value in zip(before, fresh, strict=True)]
        self.placed.append(_Placed(full, node.rate, len(self.procedures) - 1, first))
        numbers = iter(fresh)
        return tuple(
            Tensor(t.shape, tuple(a if isinstance(a, Literal) else next(numbers) for a in t.atoms)) for _, t in named
        )

    def _guard(self, every: int, full: str, origin: Origin, emit: Emitter) -> int:
        """The booleans that move on each frame; returns the value of the first."""
        slots = [StateSlot(f"{full}#phase", 0, age, False, origin.position) for age in range(every)]
        read = [self._slot(slot, emit) for slot in slots]
        for k, (slot, _) in enumerate(read):
            self._writes.append((origin, slot, read[(k + 1) % every][1]))
        return read[0][1]

    def _slot(self, slot: StateSlot, emit: Emitter) -> tuple[int, int]:
        """A further slot of the frame's state: its number, and its value in this frame."""
        self.states.append(slot)
        value = emit.value(isinstance(slot.initial, bool))
        emit.raw(Kind.READ, (), (value,), len(self.states) - 1)
        return len(self.states) - 1, value

    def finish(self, emit: Emitter) -> tuple[RunRate, ...]:
        """Store what was computed, and settle in which frames everything runs."""
        for origin, slot, atom in self._writes:
            emit.at(origin)
            emit.raw(Kind.WRITE, (atom,), (), slot)
        costs = count_procedures(self.procedures)
        tasks = [Task(p.rate.every, p.rate.offset, costs[p.procedure]) for p in self.placed]
        rates = []
        for placed, offset in zip(self.placed, balanced(tasks), strict=True):
            slot = placed.guard + offset
            self.states[slot] = replace(self.states[slot], initial=True)
            rates.append(RunRate(placed.path, placed.rate.every, offset, placed.rate.offset is None))
        return tuple(rates)
