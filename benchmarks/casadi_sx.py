"""The flagship's frame in C against the same frame in CasADi SX, operation for operation: ``python benchmarks/casadi_sx.py``.

CasADi's function is made from the very frame program (``casadi_program.py``): every scalar operation is mapped onto SX.
Compared, all on the same recording from the same start, one flight, one core, frame after frame:

saoflow C         the frame as backend ``c`` runs it, through ``simulator.run``
CasADi C          the C that CasADi generates from SX, with saoflow's table functions: the same operations and the same bits
CasADi C, cse     the same after CasADi's own elimination of common subexpressions
CasADi C, as is   the first without what favours CasADi: least and greatest stay calls of the library's fmin and fmax
CasADi C, libm    C from SX with the functions in place of the tables, as one would write it for CasADi
CasADi VM         CasADi's virtual machine, functions in place of the tables

Each side is compiled by gcc and by clang at each of the levels, with backend ``c``'s flags; the fastest of each side is
taken. The sides take turns, ratios of processor time are taken turn by turn, medians printed. Exits with 1 if a
bar is missed or a result differs.
"""

from __future__ import annotations

import argparse
import ctypes
import shutil
import statistics
import subprocess
import sys
import time
from collections.abc import Callable, Sequence
from importlib.metadata import version
from typing import Any

import numpy as np
from casadi_program import function, generated, placed, plain

import saoflow
from saoflow.cache import cache_folder
from saoflow.codegen.compiler import Compiler, compiled
from saoflow.codegen.native import NativeSimulator
from saoflow.codegen.objects import Objects
from saoflow.scheduler.program import FrameProgram
from verification.flights import load_recording, sensors

BAR_C, BAR_VM = 1.3, 20.0
"""How many times faster saoflow is to be than CasADi's C and its virtual machine."""
Side = Callable[[], float]
"""Runs all frames once from the start; processor seconds a frame."""


def compilers(levels: Sequence[str]) -> dict[str, Compiler]:
    """By name: gcc and clang, at each level; -O1 as backend ``c`` has it, another as ``SAOFLOW_CC="clang -O2"`` asks."""
    found: dict[str, Compiler] = {}
    for name in ("gcc", "clang"):
        path = shutil.which(name)
        if path is None:
            print(f"{name} is missing: apt-get install {name}")
            continue
        said = subprocess.run([path, "--version"], capture_output=True, text=True, check=True).stdout.strip()
        found |= {f"{name} {level}": Compiler((path, *([] if level == "-O1" else [level])), said) for level in levels}
    if not found:
        raise SystemExit("there is no C compiler to compare with")
    return found


class Frames:
    """A recording as every side wants it, and every side on it."""

    def __init__(self, program: FrameProgram, frames: int) -> None:
        recording = sensors(load_recording("a320_wind_350kt_5000ft"), seed=1).inputs()
        self.program = program
        self.inputs = {p.name: np.resize(recording[p.name], (frames, *p.type.shape)) for p in program.inputs}
        self.frames = frames
        self.rows = np.ascontiguousarray(rows_of([self.inputs[port.name] for port in program.inputs]))
        self.initial = np.array([float(slot.initial) for slot in program.states])
        self.width = sum(port.type.size for port in program.outputs)

    def saoflow(self, compiler: Compiler) -> tuple[Side, np.ndarray]:
        """Backend ``c`` with a compiler, and its outputs (frames, elements)."""
        simulator = NativeSimulator(self.program, Objects(self.program, compiler, cache_folder(), ""))

        def run() -> float:
            simulator.reset()
            start = time.process_time()
            simulator.run(self.inputs)
            return (time.process_time() - start) / self.frames

        outputs = simulator.run(self.inputs)
        return run, rows_of([outputs[port.name] for port in self.program.outputs])

    def casadi(self, text: str, compiler: Compiler) -> tuple[Side, np.ndarray]:
        """C that CasADi generated, with a compiler, and its outputs."""
        library = ctypes.CDLL(str(compiled([text], compiler, cache_folder())))
        loop = library.casadi_run
        loop.argtypes = [ctypes.c_void_p] * 4 + [ctypes.c_long]
        out = np.empty((self.frames, self.width))
        state, other = self.initial.copy(), self.initial.copy()

        def run() -> float:
            state[:] = self.initial
            start = time.process_time()
            loop(self.rows.ctypes.data, out.ctypes.data, state.ctypes.data, other.ctypes.data, self.frames)
            return (time.process_time() - start) / self.frames

        run()
        return run, out

    def machine(self, frame: Any, frames: int) -> tuple[Side, np.ndarray]:
        """CasADi's virtual machine on the first frames, called on buffers: some tenths of a microsecond a call."""
        out = np.empty((frames, self.width))
        states = [self.initial.copy(), self.initial.copy()]
        sides: list[tuple[Any, Any]] = []
        for k in range(2):
            buffer, call = frame.buffer()
            buffer.set_arg(0, memoryview(states[k].data))
            buffer.set_res(0, memoryview(states[1 - k].data))
            sides.append((buffer, call))
        rows, results = [[memoryview(row.data) for row in array] for array in (self.rows[:frames], out)]

        def run() -> float:
            states[0][:] = self.initial
            start = time.process_time()
            for t in range(frames):
                buffer, call = sides[t % 2]
                buffer.set_arg(1, rows[t])
                buffer.set_res(1, results[t])
                call()
            return (time.process_time() - start) / frames

        run()
        return run, out


def rows_of(arrays: list[np.ndarray]) -> np.ndarray:
    """(frames, elements) of ports beside each other."""
    return np.hstack([np.asarray(a, dtype=np.float64).reshape(len(a), -1) for a in arrays])


def fastest(candidates: dict[str, Side], repeat: int) -> tuple[str, Side]:
    """The candidate with the least median; they take turns."""
    times: dict[str, list[float]] = {name: [] for name in candidates}
    for _ in range(repeat):
        for name, run in candidates.items():
            times[name].append(run())
    medians = {name: statistics.median(values) for name, values in times.items()}
    for name, median in medians.items():
        print(f"  {name:<34}{1e6 * median:8.2f} us a frame", flush=True)
    best = min(medians, key=medians.__getitem__)
    return best, candidates[best]


def main() -> int:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--frames", type=int, default=2000)
    parser.add_argument("--machine-frames", type=int, default=200)
    parser.add_argument("--repeat", type=int, default=9)
    parser.add_argument("--levels", nargs="+", default=["-O1", "-O2"])
    options = parser.parse_args()
    sheet = saoflow.load("cmhe_fte")
    program, tools = sheet.frame_program, compilers(options.levels)
    data = Frames(program, options.frames)
    same, functions = function(program, placed), function(program, plain(program))
    texts = {"": generated(same, program, True), ", cse": generated(function(program, placed, True), program, True)}

    ours: dict[str, Side] = {}
    theirs: dict[str, Side] = {}
    differs = 0
    expected = data.saoflow(next(iter(tools.values())))[1]
    print("each side with each compiler:")
    for name, tool in tools.items():
        ours[f"saoflow C, {name}"], out = data.saoflow(tool)
        differs += not np.array_equal(out, expected)
        for row, text in texts.items():
            if row and not name.endswith("-O2"):
                continue
            theirs[f"CasADi C{row}, {name}"], out = data.casadi(text, tool)
            differs += not np.array_equal(out, expected)
    best_ours, run_ours = fastest(ours, options.repeat)
    best_theirs, run_theirs = fastest(theirs, options.repeat)
    tool = tools[best_theirs.split(", ")[-1]]
    as_is, out = data.casadi(generated(same, program, True, favoured=False), tool)
    differs += not np.array_equal(out, expected)
    libm, out_libm = data.casadi(generated(functions, program, False), tool)
    machine, out_machine = data.machine(functions, options.machine_frames)
    exact = sheet.simulator(exact=True).run({n: a[: options.machine_frames] for n, a in data.inputs.items()})
    reference = rows_of([exact[port.name] for port in program.outputs])
    away = max(float(np.abs(o[: len(reference)] - reference).max()) for o in (out_libm, out_machine))

    others = {best_theirs: run_theirs, "CasADi C, as is": as_is, "CasADi C, libm": libm, "CasADi VM": machine}
    turns = [(run_ours(), *(run() for run in others.values())) for _ in range(options.repeat)]
    print(f"\nin turns: {best_ours}: {1e6 * statistics.median(t[0] for t in turns):.2f} us a frame")
    ratios: list[float] = []
    for k, (name, bar) in enumerate(zip(others, (BAR_C, None, None, BAR_VM), strict=True), 1):
        ratios.append(statistics.median(t[k] / t[0] for t in turns))
        us = 1e6 * statistics.median(t[k] for t in turns)
        print(f"  {name:<34}{us:8.2f} us   {ratios[-1]:7.2f} times as long{f'   at least {bar}' if bar else ''}")
    print(f"results with tables: {'the same bits' if not differs else f'{differs} DIFFER'} in {options.frames} frames")
    print(
        f"results with functions: within {away:.1e} of exact mode in {len(reference)} frames (CasADi {version('casadi')})"
    )
    return 1 if differs or away > 1e-6 or ratios[0] < BAR_C or ratios[-1] < BAR_VM else 0


if __name__ == "__main__":
    sys.exit(main())
