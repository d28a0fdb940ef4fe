"""Targets: the processors whose cycles are estimated, from the data file ``targets.toml``."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

from saoflow.diagnosis import Diagnosis, DiagnosisError, did_you_mean
from saoflow.targets.instructions import MEMORY_KINDS, REAL_KINDS, Machine

DATA = Path(__file__).with_name("targets.toml")
"""Every number of the cost model, each with its source beside it."""


@dataclass(frozen=True, slots=True)
class Timing:
    """One kind of instruction on one target, in cycles."""

    latency: int
    """From issue until the result can be read."""
    interval: int
    """Until the unit takes the next instruction."""
    unit: str
    source: str
    alone: bool = False
    """Whether nothing else issues in the same cycle."""
    folded: bool = False
    """Whether it takes no issue slot (a branch that goes to its own unit)."""


@dataclass(frozen=True, slots=True)
class Shares:
    """Machine instructions that stand for one operation where compilers branch: measured means (see the data file)."""

    minimum: float
    compare: float
    or_equal: float
    """Of a comparison ``<=`` beyond that of ``<``: the flag of two conditions."""
    value: float
    """Of a comparison whose result becomes a value, beyond that of a flag."""
    test: float
    """Of a selection by a value, beyond that by a flag."""
    logic: float
    select: float
    lookup: float
    """Of a look-up without its search, one dimension."""
    lookup_2d: float
    lookup_step: float
    """Of each step of the search."""
    moved: float
    """Moves between registers for each value that goes to memory."""
    tied: float
    """Moves for each product and sum in one whose register is another's too."""
    call: float
    """Of a call beside its arguments and results: link, stack, addresses."""
    far: float
    """For each step by which a value on the stack is out of reach."""
    pointer: float
    """To reach a pointer on the stack, where the frame is beyond an offset's negative reach."""


@dataclass(frozen=True, slots=True)
class InstructionSet:
    """What a compiler has to work with, and what it was seen to make of it."""

    name: str
    registers: int
    """Floating-point registers that values can be in."""
    preserved: int
    """Of these, how many survive a call."""
    arguments: int
    """How many reals a call passes in registers."""
    held_back: int
    """Registers that hold no value for long: the compiler reloads through them."""
    near: int
    """How many operations on a reloaded value is kept for a next read."""
    save_many: bool
    """Whether one instruction saves, and one restores, all registers that a body has to."""
    integer_scratch: int
    """Integer registers that a body may use without saving them."""
    integer_preserved: int
    """Integer registers that it may use and saves."""
    literal: int
    """Integer instructions that form the address of a constant, before its load."""
    small_constants: bool
    """Whether constants of few digits are part of a move (Arm: VFPExpandImm)."""
    reach: tuple[int, ...]
    """Bytes of stack that a load reaches without, with one, ... instructions that form its address, memory form."""
    stack_reach: tuple[int, ...]
    """The same for the register form: from the stack pointer up."""
    multiply_add: bool
    """Whether a product and a sum, each rounded, are one instruction."""
    conditional_moves: bool
    """Whether a limit or a selection is a move that a flag decides, without a branch."""
    model_schedule: bool
    """Which of GCC's two ways to schedule under register pressure (``pressure_orders.py``)."""
    carried_by_integers: bool
    """Whether what is only carried from memory to memory goes through integer registers."""
    shares: Mapping[str, Shares]
    """By form: ``memory`` and ``registers``."""
    source: str
    calibrated: str


@dataclass(frozen=True, slots=True)
class Target:
    """A processor: instruction timings by width of reals, and the clock assumed where none is given."""

    name: str
    title: str
    clock_mhz: float
    clock_source: str
    issue_width: int
    issue_source: str
    units: Mapping[str, int]
    instruction_set: InstructionSet
    timings: Mapping[tuple[Machine, int], Timing]
    notes: tuple[str, ...]

    def timing(self, kind: Machine, real: int) -> Timing:
        """Latency and interval of a kind of instruction that the target has, for reals of ``real`` bits."""
        return self.timings[kind, real]

    def kinds(self) -> tuple[Machine, ...]:
        """The kinds of instruction that the target has."""
        return tuple(kind for kind in Machine if (kind, 64) in self.timings)


@lru_cache(maxsize=1)
def targets() -> Mapping[str, Target]:
    """All targets by name, in the order of the data file."""
    with DATA.open("rb") as file:
        data = tomllib.load(file)
    sets = {name: _instruction_set(name, entry) for name, entry in data["instruction_sets"].items()}
    return {name: _target(name, entry, sets) for name, entry in data["targets"].items()}


def find_target(name: str) -> Target:
    """The target of a name. Raises DiagnosisError E608."""
    known = targets()
    if name in known:
        return known[name]
    raise DiagnosisError(
        [
            Diagnosis(
                "E608",
                f"there is no target `{name}`",
                cause=f"the targets are: {', '.join(known)}",
                remedy=did_you_mean(name, list(known)) or f"write --target {next(iter(known))}",
            )
        ]
    )


def _instruction_set(name: str, entry: Mapping[str, Any]) -> InstructionSet:
    shares = {form: Shares(**entry["shares"][form]) for form in ("memory", "registers")}
    return InstructionSet(
        name,
        entry["registers"],
        entry["preserved"],
        entry["arguments"],
        entry["held_back"],
        entry["near"],
        bool(entry["save_many"]),
        entry["integer_scratch"],
        entry["integer_preserved"],
        entry["literal"],
        bool(entry["small_constants"]),
        tuple(entry["reach"]),
        tuple(entry["stack_reach"]),
        bool(entry["multiply_add"]),
        bool(entry["conditional_moves"]),
        bool(entry["model_schedule"]),
        bool(entry["carried_by_integers"]),
        shares,
        entry["source"],
        entry["calibrated"],
    )


def _target(name: str, entry: Mapping[str, Any], sets: Mapping[str, InstructionSet]) -> Target:
    units = {"real": 1, "memory": 1, "integer": 1, "branch": 1, **entry.get("units", {})}
    timings = {
        (kind, real): _timing(entry["timings"][kind.value], kind, "double" if real == 64 else "single")
        for kind in Machine
        for real in (64, 32)
        if kind.value in entry["timings"]
    }
    return Target(
        name,
        entry["title"],
        float(entry["clock_mhz"]),
        entry["clock_source"],
        entry["issue_width"],
        entry["issue_source"],
        units,
        sets[entry["instruction_set"]],
        timings,
        tuple(entry.get("notes", ())),
    )


def _timing(entry: Mapping[str, Any], kind: Machine, width: str) -> Timing:
    numbers = entry.get(width, entry)
    unit = "real" if kind in REAL_KINDS else "memory" if kind in MEMORY_KINDS else "integer"
    return Timing(
        numbers["latency"],
        numbers["interval"],
        "branch" if kind is Machine.BRANCH else unit,
        numbers.get("source", entry.get("source", "")),
        bool(numbers.get("alone", entry.get("alone", False))),
        bool(entry.get("folded", False)),
    )
