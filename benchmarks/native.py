"""Compiled frames, in ratios: ``python benchmarks/native.py``.

The flagship's frame in C against its numpy reference, a batch on one core against single frames on the same core, and from
sheet to first C frame cold and cached. The sides take turns; the ratio is taken pair by pair in processor time, and its median
printed.
"""

from __future__ import annotations

import argparse
import os
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

import saoflow
from saoflow.codegen.compiler import find_compiler
from saoflow.pipeline import LoadedSheet
from verification.flights import load_recording, sensors
from verification.reference import cmhe_fte as reference

NEEDED = {
    "numpy": 200.0,
    "batch 64": 3.0,
    "batch 32": 5.0,
    "cold": 2.0,
    "cached": 0.3,
}
FIRST_FRAME = """
import resource, time, numpy
began, used = time.perf_counter(), [resource.getrusage(w) for w in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
import saoflow
simulator = saoflow.load("cmhe_fte").simulator(backend="c")
simulator.step({"alpha": [0.05] * 3, "vc": [250] * 3, "vg": 300, "vz": 0, "theta": 0.05, "q": 0, "ax": 0, "az": -19, "z": 3000})
wall = time.perf_counter() - began
spent = [resource.getrusage(w) for w in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
print(wall, sum(b.ru_utime + b.ru_stime - a.ru_utime - a.ru_stime for a, b in zip(used, spent)))
"""


def main() -> None:
    """Print medians and ratios."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--frames", type=int, default=300, help="of the numpy reference; C runs ten times as many")
    parser.add_argument("--flights", type=int, default=64)
    parser.add_argument("--repeat", type=int, default=7)
    options = parser.parse_args()
    compiler = find_compiler()
    if compiler is None:
        sys.exit("there is no C compiler on this machine")
    print(f"{compiler.version.splitlines()[0]}: {' '.join(compiler.flags)}")
    sheet = saoflow.load("cmhe_fte")
    recorded = sensors(load_recording("a320_wind_350kt_5000ft"), seed=1).inputs()
    against_numpy(sheet, recorded, options.frames, options.repeat)
    for real in (64, 32):
        batch_against_single(sheet, recorded, real, options.flights, options.repeat)
    first_frame(options.repeat)


def against_numpy(sheet: LoadedSheet, recorded: dict[str, Any], frames: int, repeat: int) -> None:
    """One flight in C against the numpy reference."""
    simulator = sheet.simulator(backend="c")
    few = {name: np.asarray(array)[:frames] for name, array in recorded.items()}
    many = {name: np.concatenate([array] * 10) for name, array in few.items()}
    pairs = []
    for _ in range(repeat):
        simulator.reset()
        fast = seconds(lambda: simulator.run(many)) / (10 * frames)
        pairs.append((seconds(lambda: reference.run(few)) / frames, fast))
    told("numpy", "numpy reference / C, one flight", pairs)


def batch_against_single(sheet: LoadedSheet, recorded: dict[str, Any], real: int, flights: int, repeat: int) -> None:
    """A batch in lanes against single frames, per frame and flight, on one core."""
    single, batch = (sheet.simulator(backend="c", real=real) for _ in range(2))
    frames = 400
    one = {name: np.tile(np.asarray(a)[:frames], (8, *[1] * (np.ndim(a) - 1))) for name, a in recorded.items()}
    rng = np.random.default_rng(1)
    starts = rng.integers(0, 300, flights)
    all_ = {name: np.stack([np.roll(a, -s, axis=0)[:frames] for s in starts]) for name, a in one.items()}
    batch.run({name: array[:, :2] for name, array in all_.items()})  # compiled before time is taken
    pairs = []
    for _ in range(repeat):
        single.reset()
        batch.reset()
        alone = seconds(lambda: single.run(one)) / (8 * frames)
        pairs.append((alone, seconds(lambda: batch.run(all_)) / (flights * frames)))
    told(f"batch {real}", f"single / batch of {flights}, binary{real}", pairs)


def first_frame(repeat: int) -> None:
    """From sheet to first C frame, in a new process: everything after ``import numpy``."""
    for what in ("cold", "cached"):
        found = []
        with tempfile.TemporaryDirectory() as folder:
            for k in range(min(repeat, 5) + (what == "cached")):
                cache = folder if what == "cached" else f"{folder}/{k}"
                Path(cache).mkdir(exist_ok=True)
                done = subprocess.run(
                    [sys.executable, "-c", FIRST_FRAME],
                    env={**os.environ, "XDG_CACHE_HOME": cache},
                    capture_output=True,
                    text=True,
                    check=True,
                )
                found.append(tuple(map(float, done.stdout.split())))
        if what == "cached":
            found = found[1:]
        wall, used = (statistics.median(column) for column in zip(*found, strict=True))
        print(
            f"sheet to first C frame, {what:<6}  {wall:6.2f} s, {used:.2f} s of processor; needed: under {NEEDED[what]} s"
        )


def told(what: str, text: str, pairs: list[tuple[float, float]]) -> None:
    """A line: both medians in us, and the median ratio against what is needed."""
    slow, fast = (1e6 * statistics.median(column) for column in zip(*pairs, strict=True))
    ratio = statistics.median(a / b for a, b in pairs)
    print(f"{text:<40} {slow:9.2f} us / {fast:7.3f} us = {ratio:7.1f}; needed: {NEEDED[what]:g}")


def seconds(work: Callable[[], object]) -> float:
    """Processor time: other processes do not count."""
    start = time.process_time()
    work()
    return time.process_time() - start


if __name__ == "__main__":
    sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
    main()
