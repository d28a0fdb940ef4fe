"""The flagship's frame in C against the same frame in CasADi SX, operation for operation: ``python benchmarks/casadi_sx.py``.

CasADi's function is made from the very frame program (``casadi_program.py``): every scalar operation is mapped onto SX.
Compared, all on the same recording from the same start, one flight, one core, frame after frame:

saoflow C         the frame as backend ``c`` runs it, through ``simulator.run``
CasADi C          the C that CasADi generates from the same algorithm in SX, as it is: SX has no table, so functions stand in
                  their place, and no least and greatest but calls of the library's fmin and fmax
CasADi C, inline  the same with least and greatest written as comparisons, which CasADi does for compilers older than C99
CasADi C, tables  edited by hand into what CasADi cannot generate: saoflow's table functions, least and greatest inline. The
                  same operations and the same bits as saoflow's frame: what remains is how straight code is laid out
CasADi C, cse     the last after CasADi's own elimination of common subexpressions
CasADi VM         CasADi's virtual machine, functions in place of the tables

Each is compiled by gcc and by clang at each of the levels, with backend ``c``'s flags; the fastest of each is
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

BARS = {"CasADi C": 1.3, "CasADi VM": 20.0}
"""How many times faster saoflow is to be."""
SAME = ("CasADi C, tables", "CasADi C, cse")
"""What has the operations of saoflow's frame, and so its bits."""
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


def fastest(row: str, candidates: dict[str, Side], repeat: int) -> Side:
    """The compiler and level with the least median; they take turns."""
    times: dict[str, list[float]] = {name: [] for name in candidates}
    for _ in range(repeat):
        for name, run in candidates.items():
            times[name].append(run())
    medians = {name: statistics.median(values) for name, values in times.items()}
    for name, median in medians.items():
        print(f"  {f'{row}, {name}':<34}{1e6 * median:8.2f} us a frame", flush=True)
    return candidates[min(medians, key=medians.__getitem__)]


def main() -> int:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--frames", type=int, default=10000, help="enough that what a run costs once does not count")
    parser.add_argument("--machine-frames", type=int, default=200)
    parser.add_argument("--repeat", type=int, default=9)
    parser.add_argument("--levels", nargs="+", default=["-O1", "-O2"])
    options = parser.parse_args()
    sheet = saoflow.load("cmhe_fte")
    program, tools = sheet.frame_program, compilers(options.levels)
    data = Frames(program, options.frames)
    same, functions = function(program, placed), function(program, plain(program))
    texts = {
        "CasADi C": generated(functions, program, False, favoured=False),
        "CasADi C, inline": generated(functions, program, False),
        "CasADi C, tables": generated(same, program, True),
        "CasADi C, cse": generated(function(program, placed, True), program, True),
    }
    sides: dict[str, dict[str, Side]] = {"saoflow C": {}, **{row: {} for row in texts}}
    expected = data.saoflow(next(iter(tools.values())))[1]
    exact = sheet.simulator(exact=True).run({n: a[: options.machine_frames] for n, a in data.inputs.items()})
    reference = rows_of([exact[port.name] for port in program.outputs])
    differs, away = 0, 0.0
    print("each with each compiler:")
    for name, tool in tools.items():
        sides["saoflow C"][name], out = data.saoflow(tool)
        differs += not np.array_equal(out, expected)
        for row, text in texts.items():
            sides[row][name], out = data.casadi(text, tool)
            if row in SAME:
                differs += not np.array_equal(out, expected)
            else:
                away = max(away, float(np.abs(out[: len(reference)] - reference).max()))
    best = {row: fastest(row, candidates, options.repeat) for row, candidates in sides.items()}
    best["CasADi VM"], out = data.machine(functions, options.machine_frames)
    away = max(away, float(np.abs(out - reference).max()))

    turns = [[run() for run in best.values()] for _ in range(options.repeat)]
    print(f"\nin turns: saoflow C: {1e6 * statistics.median(turn[0] for turn in turns):.2f} us a frame")
    missed = False
    for k, name in enumerate(list(best)[1:], 1):
        ratio, us = statistics.median(t[k] / t[0] for t in turns), 1e6 * statistics.median(t[k] for t in turns)
        bar = BARS.get(name)
        missed |= bar is not None and ratio < bar
        print(f"  {name:<20}{us:8.2f} us   {ratio:7.2f} times as long{f'   at least {bar}' if bar else ''}")
    print(f"results with tables: {'the same bits' if not differs else f'{differs} DIFFER'} in {options.frames} frames")
    print(f"results with functions: within {away:.1e} of exact mode in {len(reference)} frames (CasADi {version('casadi')})")
    return 1 if differs or away > 1e-6 or missed else 0


if __name__ == "__main__":
    sys.exit(main())
