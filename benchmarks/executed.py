"""Executed PowerPC instructions as the cost model's pipeline takes them: kind, registers read, register written."""

from __future__ import annotations

import re
from collections.abc import Iterable

from saoflow.targets.instructions import Instruction, Machine

KINDS = {
    Machine.ADD: ("fadd", "fsub", "fadds", "fsubs"),
    Machine.MULTIPLY: ("fmul", "fmuls"),
    Machine.DIVIDE: ("fdiv", "fdivs"),
    Machine.COMPARE: ("fcmpu", "fcmpo"),
    Machine.MOVE: ("fmr", "fneg", "fabs", "frsp"),
    Machine.LOAD: ("lfd", "lfs", "lfdx", "lfsx", "lfdu", "lfsu"),
    Machine.STORE: ("stfd", "stfs", "stfdx", "stfsx", "stfdu", "stfsu"),
    Machine.INTEGER_LOAD: ("lwz", "lbz", "lwzx", "lbzx", "lwzu", "lbzu", "lmw"),
    Machine.INTEGER_STORE: ("stw", "stb", "stwx", "stbx", "stwu", "stbu", "stmw"),
}
BY_MNEMONIC = {mnemonic: kind for kind, mnemonics in KINDS.items() for mnemonic in mnemonics}
REGISTER = re.compile(r"\b(?:[rf]\d+|cr\d)\b")
STORES = (Machine.STORE, Machine.INTEGER_STORE, Machine.BRANCH)


def kind_of(mnemonic: str) -> Machine:
    """What the cost model calls an instruction."""
    if mnemonic in BY_MNEMONIC:
        return BY_MNEMONIC[mnemonic]
    return Machine.BRANCH if mnemonic.startswith("b") else Machine.INTEGER


def executed(lines: Iterable[tuple[str, str]]) -> list[Instruction]:
    """Instructions from mnemonics and operands in the order of execution; each write of a register is a new value."""
    last: dict[str, int] = {}
    found: list[Instruction] = []
    for number, (mnemonic, operands) in enumerate(lines):
        kind = kind_of(mnemonic)
        registers = REGISTER.findall(operands)
        if mnemonic.startswith("b") and not registers and mnemonic not in ("b", "bl", "blr"):
            registers = ["cr0"]
        written = [] if kind in STORES else registers[:1]
        if mnemonic.startswith(("cr", "cmp", "fcmp")) and not (registers and registers[0].startswith("cr")):
            written = ["cr0"]
        reads = registers if kind in STORES else registers[1:]
        found.append(Instruction(kind, tuple(last[r] for r in reads if r in last), number))
        for register in written:
            last[register] = number
    return found
