"""The frame program: what one frame executes. The single truth behind interpreter, code, counts and budgets."""

from __future__ import annotations

from dataclasses import dataclass

from saoflow.diagnosis import Position
from saoflow.operations import Atom, Kind, Table, Tensor
from saoflow.wires import WireType


@dataclass(frozen=True, slots=True)
class Origin:
    """Where an operation comes from: the wire's path inside its body, and the line of the sheet."""

    path: str
    position: Position


@dataclass(frozen=True, slots=True)
class Operation:
    """One scalar operation. ``detail``: table number of a look-up, slot of a read or write, procedure of a call.

    A call of what runs at a rate of its own has a ``guard``: where it is false, the results are ``otherwise``. Which frames
    these are is fixed (:class:`RunRate`); no data decides it.
    """

    kind: Kind
    results: tuple[int, ...]
    operands: tuple[Atom, ...]
    detail: int
    origin: int
    guard: int | None = None
    otherwise: tuple[Atom, ...] = ()

    @property
    def reads(self) -> tuple[Atom, ...]:
        """Every atom that it reads: operands, guard and what stands in for its results."""
        return self.operands if self.guard is None else (*self.operands, self.guard, *self.otherwise)


@dataclass(frozen=True, slots=True, eq=False)
class TracedScope:
    """Where every wire of a netlist body is, in the program body that it was lowered into."""

    path: str
    """The path of the instance inside the program body, with a dot at its end; "" for the body's own sheet."""
    tensors: tuple[Tensor | None, ...]
    """By wire number."""


@dataclass(frozen=True, slots=True, eq=False)
class ProgramBody:
    """A list of operations in their order, with what goes in and what comes out.

    Values are numbered from 0; ``parameters`` are the values that are given. For the frame body these are the
    inputs' elements; state is read and written by operations.
    """

    name: str
    parameters: tuple[int, ...]
    operations: tuple[Operation, ...]
    results: tuple[Atom, ...]
    booleans: tuple[bool, ...]
    """By value number: boolean or real."""
    origins: tuple[Origin, ...]
    traced: tuple[TracedScope, ...] = ()
    """Every wire of every instance laid out in it, if it was lowered to be traced."""

    @property
    def value_count(self) -> int:
        """How many scalar values there are."""
        return len(self.booleans)


@dataclass(frozen=True, slots=True)
class ProgramPort:
    """An input, output or probe: its name, its type and its atoms in the frame body."""

    name: str
    type: WireType
    tensor: Tensor
    doc: str


@dataclass(frozen=True, slots=True)
class StateSlot:
    """One remembered scalar: the path of its delay, the element and the frame of it, and the initial value."""

    path: str
    element: int
    age: int
    """0: what the delay gives out in this frame; n-1: what was stored last."""
    initial: float | bool
    position: Position


@dataclass(frozen=True, slots=True, eq=False)
class RateGroup:
    """What runs every ``every`` frames from frame ``offset`` on: the frame body, which runs in every frame.

    What runs more seldom is called from it, under a guard: :class:`RunRate`.
    """

    every: int
    offset: int
    body: ProgramBody


@dataclass(frozen=True, slots=True)
class RunRate:
    """When a guarded call runs: in frames ``offset``, ``offset + every``, ..."""

    path: str
    every: int
    offset: int
    balanced: bool
    """Whether saoflow chose the offset."""


@dataclass(frozen=True, slots=True, eq=False)
class FrameProgram:
    """One frame: the bodies of the rate groups, and the procedures that they call (each calls earlier ones only)."""

    sheet: str
    real: int
    """64 or 32: the width of real arithmetic."""
    groups: tuple[RateGroup, ...]
    procedures: tuple[ProgramBody, ...]
    tables: tuple[Table, ...]
    states: tuple[StateSlot, ...]
    inputs: tuple[ProgramPort, ...]
    outputs: tuple[ProgramPort, ...]
    probes: tuple[ProgramPort, ...]
    rates: tuple[RunRate, ...] = ()
    """Of the guarded calls, by path."""

    @property
    def bodies(self) -> tuple[ProgramBody, ...]:
        """Every procedure, then the body of every rate group."""
        return (*self.procedures, *(group.body for group in self.groups))

    @property
    def hyperperiod(self) -> int:
        """After how many frames the pattern of rate groups repeats."""
        import math

        return math.lcm(*(group.every for group in self.groups), *(rate.every for rate in self.rates))
