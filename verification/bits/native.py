"""The code of backend ``c``: guided look-ups and procedures in place, one flight at a time or lanes of flights.

What flies is compiled by :mod:`verification.bits.harness`; this is the other C that saoflow writes, for the machine at hand.
"""

from __future__ import annotations

import shutil
import subprocess
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import numpy as np

from saoflow.cache import Folder
from saoflow.codegen.compiler import Compiler
from saoflow.codegen.native import NativeSimulator
from saoflow.codegen.objects import Objects
from saoflow.scheduler.program import FrameProgram


@dataclass(frozen=True, slots=True)
class NativeTarget:
    """A compiler, with a level of its own or backend ``c``'s, and bytes of flights side by side (0: one flight)."""

    compiler: tuple[str, ...]
    register: int

    @property
    def name(self) -> str:
        """As it is printed and chosen."""
        lanes = f"lanes of {self.register} bytes" if self.register else "one flight"
        return f"backend c, {' '.join(self.compiler)}, {lanes}"

    @property
    def available(self) -> bool:
        """Whether the compiler is on this machine."""
        return shutil.which(self.compiler[0]) is not None


NATIVE: tuple[NativeTarget, ...] = tuple(
    NativeTarget(compiler, register)
    for compiler in (("gcc",), ("gcc", "-O2"), ("clang",), ("clang", "-O2"))
    for register in (0, 16, 32, 64)
)
"""Every compiler and width of a register; a compiler makes pieces of registers that the machine does not have."""


def run_native(program: FrameProgram, target: NativeTarget, folder: Path, rows: np.ndarray, flight: int) -> np.ndarray:
    """Flights of ``flight`` frames one behind the other (frames, inputs) through backend ``c``: (frames, outputs).

    All flights are one batch, the last lanes of which are not full unless their number happens to fit.
    """
    folder.mkdir(parents=True, exist_ok=True)
    simulator = NativeSimulator(program, Objects(program, _compiler(target.compiler), Folder(folder), ""))
    count = len(rows) // flight
    if target.register:
        simulator.lanes = 8 * target.register // program.real
        return _flat(program, simulator.run(_ports(program, rows, (count, flight))), len(rows))
    parts = []
    for start in range(0, len(rows), flight):
        simulator.reset()
        part = rows[start : start + flight]
        parts.append(_flat(program, simulator.run(_ports(program, part, (flight,))), flight))
    return np.concatenate(parts)


def _ports(program: FrameProgram, rows: np.ndarray, lead: tuple[int, ...]) -> dict[str, np.ndarray]:
    ends = np.cumsum([port.type.size for port in program.inputs])[:-1]
    parts = np.split(rows, ends, axis=1)
    return {p.name: part.reshape(*lead, *p.type.shape) for p, part in zip(program.inputs, parts, strict=True)}


def _flat(program: FrameProgram, outputs: dict[str, np.ndarray], frames: int) -> np.ndarray:
    columns = [np.asarray(outputs[port.name], dtype=np.float64).reshape(frames, -1) for port in program.outputs]
    return np.concatenate(columns, axis=1)


@lru_cache(maxsize=8)
def _compiler(command: tuple[str, ...]) -> Compiler:
    path = shutil.which(command[0])
    assert path is not None
    said = subprocess.run([path, "--version"], capture_output=True, text=True, check=True).stdout.strip()
    return Compiler((path, *command[1:]), said)
