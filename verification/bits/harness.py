"""Running generated C outside this process, and comparing its bits with the interpreter's.

The harness writes raw reals in the byte order of the target, so that it serves emulated machines alike.
"""

from __future__ import annotations

import shutil
import subprocess
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from saoflow.codegen.generate import About, Code, generate
from saoflow.codegen.printer import print_file
from saoflow.pipeline import LoadedSheet
from saoflow.scheduler.program import FrameProgram


@dataclass(frozen=True, slots=True)
class Target:
    """A compiler with its flags, how its programs are run, and the byte order of its reals."""

    name: str
    compiler: tuple[str, ...]
    runner: tuple[str, ...] = ()
    byte_order: str = "<"

    @property
    def available(self) -> bool:
        """Whether its tools are on this machine."""
        return all(shutil.which(tool[0]) for tool in (self.compiler, self.runner) if tool)


STRICT = ("-std=c99", "-ffp-contract=off")
TARGETS: tuple[Target, ...] = (
    *(Target(f"gcc -O{n}", ("gcc", f"-O{n}")) for n in range(4)),
    *(Target(f"clang -O{n}", ("clang", f"-O{n}")) for n in (0, 2)),
    Target("PowerPC 750", ("powerpc-linux-gnu-gcc", "-O2", "-mcpu=750", "-static"), ("qemu-ppc", "-cpu", "750"), ">"),
    Target("ARM", ("arm-linux-gnueabihf-gcc", "-O2", "-static"), ("qemu-arm",), "<"),
    Target("AArch64", ("aarch64-linux-gnu-gcc", "-O2", "-static"), ("qemu-aarch64",), "<"),
)
"""Every compiler and machine that is tried; those that are missing are named."""


class HarnessError(RuntimeError):
    """A compiler or a program failed; the text is what it said."""


MAIN = """
#include <stdio.h>
#include <stdlib.h>
#include "{header}"
int main(int argc, char **argv)
{{
    static {state} state;
    static {input} input;
    static {output} output;
    static {real} in[{inputs} + 1], out[{outputs} + 1];
    FILE *from = fopen(argv[1], "rb"), *to = fopen(argv[2], "wb");
    unsigned long k = 0, flight = argc == 4 ? strtoul(argv[3], 0, 10) : 0;
    if (argc != 4 || !from || !to || !flight) return 2;
    while ({inputs} ? fread(in, sizeof in[0], {inputs}, from) == {inputs} : fgetc(from) != EOF) {{
        if (k++ % flight == 0) {init}(&state);
        {load}
        {step}(&state, &input, &output);
        {store}
        fwrite(out, sizeof out[0], {outputs}, to);
    }}
    return fclose(to) != 0;
}}
"""


def write_program(program: FrameProgram, folder: Path) -> Code:
    """The C of a program, with a main that reads frames from a file and writes results to another."""
    code = generate(program, About("bit comparison", "", ()))
    face = code.interface
    for file in (code.header, code.source):
        (folder / file.name).write_text(print_file(file).text, encoding="ascii")

    def fields(ports: tuple[object, ...], names: tuple[str, ...]) -> list[str]:
        found: list[str] = []
        for port, name in zip(ports, names, strict=True):
            wire_type = port.type  # type: ignore[attr-defined]
            found += [f"{name}[{k}]" for k in range(wire_type.size)] if wire_type.shape else [name]
        return found

    inputs = fields(program.inputs, face.inputs)
    outputs = fields((*program.outputs, *program.probes), face.outputs)
    booleans = [port.type.boolean for port in program.inputs for _ in range(port.type.size)]
    load = [
        f"input.{f} = in[{k}]{' != 0' if b else ''};" for k, (f, b) in enumerate(zip(inputs, booleans, strict=True))
    ]
    store = [f"out[{k}] = output.{f};" for k, f in enumerate(outputs)]
    text = MAIN.format(
        header=code.header.name,
        state=face.state_struct,
        input=face.input_struct,
        output=face.output_struct,
        real=face.real_type,
        inputs=len(inputs),
        outputs=len(outputs),
        init=face.init,
        step=face.step,
        load=" ".join(load),
        store=" ".join(store),
    )
    (folder / "main.c").write_text(text, encoding="ascii")
    return code


def run_c(
    program: FrameProgram, target: Target, folder: Path, rows: np.ndarray, flight: int | None = None
) -> np.ndarray:
    """Frames (frames, inputs) through the C of a program: (frames, outputs) as binary64. Raises HarnessError.

    The state starts anew every ``flight`` frames.
    """
    folder.mkdir(parents=True, exist_ok=True)
    code = write_program(program, folder)
    real = f"{target.byte_order}f{program.real // 8}"
    source, binary = folder / "in.bin", folder / "main"
    with np.errstate(all="ignore"):
        source.write_bytes(rows.astype(real).tobytes())
    _run((*target.compiler, *STRICT, "-o", str(binary), str(folder / code.source.name), str(folder / "main.c")))
    length = str(flight or max(len(rows), 1))
    _run((*target.runner, str(binary), str(source), str(folder / "out.bin"), length))
    width = sum(port.type.size for port in (*program.outputs, *program.probes))
    return np.fromfile(folder / "out.bin", dtype=real).astype(np.float64).reshape(len(rows), width)


def _run(command: tuple[str, ...]) -> None:
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode:
        raise HarnessError(f"{' '.join(command)}\nexit code {done.returncode}\n{done.stderr[:4000]}")


def run_interpreter(sheet: LoadedSheet, real: int, rows: np.ndarray, flight: int | None = None) -> np.ndarray:
    """The same frames in the interpreter; with ``flight``, as a batch of flights of so many frames."""
    simulator = sheet.simulator(real=real)
    lead = (len(rows),) if flight is None else (len(rows) // flight, flight)
    inputs: dict[str, np.ndarray] = {}
    start = 0
    for port in simulator.program.inputs:
        part = rows[:, start : start + port.type.size]
        inputs[port.name] = part.reshape(*lead, *port.type.shape)
        start += port.type.size
    out: Mapping[str, np.ndarray] = simulator.run(inputs)
    flat = [np.asarray(out[p.name], dtype=np.float64).reshape(len(rows), -1) for p in simulator.program.outputs]
    return np.concatenate(flat, axis=1)


@dataclass(frozen=True, slots=True)
class Difference:
    """The first result whose bits differ."""

    frame: int
    output: str
    element: int
    interpreter: float
    c: float


def first_difference(program: FrameProgram, expected: np.ndarray, found: np.ndarray) -> Difference | None:
    """Compare in every bit, signed zeros included; any NaN equals any NaN."""
    equal = (np.isnan(expected) & np.isnan(found)) | ((expected == found) & (np.signbit(expected) == np.signbit(found)))
    if equal.all():
        return None
    frame, column = (int(i) for i in np.argwhere(~equal)[0])
    left = column
    for port in program.outputs:
        if left < port.type.size:
            return Difference(frame, port.name, left, float(expected[frame, column]), float(found[frame, column]))
        left -= port.type.size
    raise AssertionError("more columns than outputs")
