"""Machine instructions as the cost model sees them: a kind, what is read, what is written."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum


class Machine(Enum):
    """The kinds of machine instruction; the value is their key in ``targets.toml``."""

    ADD = "add"
    MULTIPLY = "multiply"
    DIVIDE = "divide"
    MULTIPLY_ADD = "multiply_add"
    """Product and sum in one instruction, each rounded: not fused, so the bits stay (VMLA of Arm's VFP)."""
    COMPARE = "compare"
    MOVE = "move"
    LOAD = "load"
    STORE = "store"
    INTEGER = "integer"
    INTEGER_LOAD = "integer_load"
    INTEGER_STORE = "integer_store"
    BRANCH = "branch"

    __hash__ = object.__hash__  # by identity: what is looked up for every instruction


REAL_KINDS = frozenset(
    {Machine.ADD, Machine.MULTIPLY, Machine.MULTIPLY_ADD, Machine.DIVIDE, Machine.COMPARE, Machine.MOVE}
)
"""What the floating-point unit executes."""

MEMORY_KINDS = frozenset({Machine.LOAD, Machine.STORE, Machine.INTEGER_LOAD, Machine.INTEGER_STORE})
"""What the load/store unit executes."""


@dataclass(frozen=True, slots=True)
class Instruction:
    """One machine instruction. ``reads`` and ``write`` number values (not registers); a write of -1 is no value."""

    kind: Machine
    reads: tuple[int, ...] = ()
    write: int = -1


class Stream:
    """Instructions in their order, with fresh numbers for what they write and fractions that add up to whole ones."""

    def __init__(self) -> None:
        self.instructions: list[Instruction] = []
        self._values = 0
        self._owed: dict[Machine, float] = {}

    def emit(self, kind: Machine, *reads: int) -> int:
        """Append an instruction; the number of its result."""
        self._values += 1
        self.instructions.append(Instruction(kind, reads, self._values))
        return self._values

    def emit_share(self, kind: Machine, share: float, *reads: int) -> int:
        """Append ``share`` instructions on average over the stream, each reading the one before; the last result.

        The result is ``reads[0]`` (or -1) where the share comes to none.
        """
        owed = self._owed.get(kind, 0.0) + share
        last = reads[0] if reads else -1
        operands = reads
        while owed >= 0.5:
            last = self.emit(kind, *operands)
            operands = (last,)
            owed -= 1.0
        self._owed[kind] = owed
        return last
