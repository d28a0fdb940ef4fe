"""Instructions that a frame executes on another processor: cross-compiled C under qemu's user emulation, counted.

The generated functions are put into a section of their own; qemu logs each instruction executed there. Code for
Cortex-M7 and Cortex-R5 runs under qemu's A-profile emulation: what it uses is in both (the attributes that would keep
the linker from mixing profiles are taken out).
"""

from __future__ import annotations

import re
import shutil
import subprocess
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from saoflow.codegen.generate import About, Code, generate
from saoflow.codegen.printer import print_file, real
from saoflow.scheduler.program import FrameProgram


@dataclass(frozen=True, slots=True)
class Toolchain:
    """A cross compiler and the emulator of what it makes."""

    name: str
    compiler: str
    flags: tuple[str, ...]
    link: tuple[str, ...]
    emulator: tuple[str, ...]
    package: str

    @property
    def missing(self) -> str:
        """What is not installed, with the way to it; empty if all is there."""
        gone = [t for t in (self.compiler, self.compiler.replace("gcc", "objcopy"), self.emulator[0]) if not shutil.which(t)]
        return f"{', '.join(gone)} not found: apt-get install {self.package}" if gone else ""


CROSS = ("-std=c99", "-ffp-contract=off", "-fno-pic")
TOOLCHAINS = {
    "powerpc": Toolchain(
        "powerpc", "powerpc-linux-gnu-gcc", (*CROSS, "-mcpu=750"), ("-mcpu=750",), ("qemu-ppc", "-cpu", "750"),
        "gcc-powerpc-linux-gnu qemu-user",
    ),
    "arm_m7": Toolchain(
        "arm_m7", "arm-linux-gnueabihf-gcc", (*CROSS, "-mcpu=cortex-m7", "-mthumb", "-mfpu=fpv5-d16", "-mfloat-abi=hard"),
        (), ("qemu-arm", "-cpu", "max"), "gcc-arm-linux-gnueabihf qemu-user",
    ),
    "arm_r5": Toolchain(
        "arm_r5", "arm-linux-gnueabihf-gcc", (*CROSS, "-mcpu=cortex-r5", "-mthumb", "-mfpu=vfpv3-d16", "-mfloat-abi=hard"),
        (), ("qemu-arm", "-cpu", "max"), "gcc-arm-linux-gnueabihf qemu-user",
    ),
}  # fmt: skip
"""By instruction set of ``saoflow/targets/targets.toml``."""

TRACE = re.compile(r"\[[0-9a-f]+/([0-9a-f]+)/")
SECTION = "sheettext"


@dataclass(frozen=True, slots=True)
class Counted:
    """Instructions of one frame, on average over the frames run, and by mnemonic."""

    instructions: float
    mnemonics: Counter[str]
    last: tuple[tuple[str, str], ...]
    """Mnemonic and operands of what the last frame executed, in order."""


def count_instructions(
    program: FrameProgram, rows: np.ndarray, tools: Toolchain, level: str, folder: Path
) -> Counted:
    """Compile at ``level`` (-O0, -O1, -O2), run ``rows`` (frames, elements of all inputs), count."""
    code = generate(program, About("Instructions are counted in this.", "0" * 64, ()))
    for file in (code.header, code.source):
        (folder / file.name).write_text(print_file(file).text, encoding="utf-8")
    (folder / "main.c").write_text(_driver(code, program, rows), encoding="utf-8")
    made, whole = folder / "sheet.o", folder / "whole"
    binutil = tools.compiler.replace("gcc", "{}")
    _run(tools.compiler, *tools.flags, level, "-c", str(folder / code.source.name), "-o", str(made))
    _run(binutil.format("objcopy"), "--remove-section", ".ARM.attributes", "--rename-section", f".text={SECTION}", str(made))
    _run(tools.compiler, *tools.link, "-static", "-no-pie", str(folder / "main.c"), str(made), "-o", str(whole))
    names = _instructions(_run(binutil.format("objdump"), "-d", "-j", SECTION, str(whole)))
    span = f"0x{min(names):x}..0x{max(names) + 3:x}"
    log = folder / "trace"
    _run(*tools.emulator, "-singlestep", "-d", "nochain,exec", "-dfilter", span, "-D", str(log), str(whole))
    found: Counter[str] = Counter()
    frame: list[tuple[str, str]] = []
    entry = min(a for a, (function, *_) in names.items() if function == code.interface.step)
    with log.open(encoding="ascii") as lines:
        for line in lines:
            at = TRACE.search(line)
            if at is None:
                continue
            address = int(at[1], 16)
            function, mnemonic, operands = names.get(address, ("?", "?", ""))
            if function != code.interface.init:
                found[mnemonic] += 1
                if address == entry:
                    frame.clear()
                frame.append((mnemonic, operands))
    log.unlink()
    return Counted(found.total() / len(rows), found, tuple(frame))


def _run(*command: str) -> str:
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout


def _instructions(listing: str) -> dict[int, tuple[str, str, str]]:
    """Function, mnemonic and operands by address."""
    found: dict[int, tuple[str, str, str]] = {}
    function = ""
    for line in listing.splitlines():
        head = re.match(r"[0-9a-f]+ <(.+)>:", line)
        if head is not None:
            function = head[1]
        body = re.match(r"\s*([0-9a-f]+):\t[^\t]*\t(\S+)\s*([^<]*)", line)
        if body is not None:
            found[int(body[1], 16)] = function, body[2], body[3]
    return found


def _driver(code: Code, program: FrameProgram, rows: Sequence[Sequence[float]] | np.ndarray) -> str:
    face = code.interface
    kind = face.real_type
    values = ",\n".join("{" + ", ".join(real(float(v), program.real) for v in row) + "}" for row in rows)
    assignments, column = [], 0
    for port, name in zip(program.inputs, face.inputs, strict=True):
        for k in range(port.type.size):
            element = f"[{k}]" if port.type.shape else ""
            assignments.append(f"input.{name}{element} = data[k][{column}];")
            column += 1
    return (
        f'#include "{code.header.name}"\n'
        f"static const {kind} data[{len(rows)}][{column}] = {{{values}}};\n"
        f"int main(void) {{ {face.state_struct} state; {face.input_struct} input; {face.output_struct} output;\n"
        f"{face.init}(&state);\nfor (int k = 0; k < {len(rows)}; ++k) {{ {' '.join(assignments)}\n"
        f"{face.step}(&state, &input, &output); }}\nreturn 0; }}\n"
    )
