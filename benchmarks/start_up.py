"""Cold starts in fresh processes: ``python benchmarks/start_up.py``.

Import of saoflow, from nothing to the first frame of the flagship, and commands: `saoflow check` of a sheet in which nothing
was found before and has not changed (the first call does that), and for the first time. Medians by the clock and of
processor time, beside an import of numpy alone.
"""

from __future__ import annotations

import argparse
import os
import resource
import statistics
import subprocess
import sys
import tempfile
import time

PROGRAMS = {
    "python -c pass": "pass",
    "import numpy": "import numpy",
    "import saoflow": "import saoflow",
    "first frame of cmhe_fte": (
        "import numpy as np, saoflow\n"
        "sheet = saoflow.load('cmhe_fte')\n"
        "sim = sheet.simulator()\n"
        "shapes = {p.name: p.type.shape for p in sheet.frame_program.inputs}\n"
        "sim.step({name: np.ones(shape) for name, shape in shapes.items()})"
    ),
}

COMMANDS = {
    "saoflow check limit": ("check", "limit"),
    "saoflow check cmhe_fte": ("check", "cmhe_fte"),
    "saoflow --help": ("--help",),
    "saoflow budget cmhe_fte": ("budget", "cmhe_fte"),
}
FIRST = "the same, first time"


def taken(command: list[str], environment: dict[str, str]) -> tuple[float, float]:
    """Seconds of a process: by the clock, and of processor."""
    before, start = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
    subprocess.run(command, check=True, env=environment, stdout=subprocess.DEVNULL)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return time.perf_counter() - start, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def main() -> None:
    """Print medians in s and ratios to an import of numpy."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--repeat", type=int, default=7)
    parser.add_argument("--only", choices=("programs", "commands"), help="imports and a first frame, or commands")
    options = parser.parse_args()
    programs = PROGRAMS if options.only != "commands" else {"import numpy": PROGRAMS["import numpy"]}
    commands = COMMANDS if options.only != "programs" else {}
    times: dict[str, list[tuple[float, float]]] = {}
    with tempfile.TemporaryDirectory() as cache:
        warm = {**os.environ, "XDG_CACHE_HOME": cache}
        for turn in range(options.repeat + 1):
            for name, text in programs.items():
                times.setdefault(name, []).append(taken([sys.executable, "-c", text], warm))
            for name, words in commands.items():
                command = [sys.executable, "-m", "saoflow", *words]
                times.setdefault(name, []).append(taken(command, warm))
                if words[0] == "check":
                    with tempfile.TemporaryDirectory() as empty:
                        first = taken(command, {**os.environ, "XDG_CACHE_HOME": empty})
                    times.setdefault(f"  {FIRST} {words[1]}", []).append(first)
            if turn == 0:
                times.clear()  # that one filled what is kept
    numpy = statistics.median(spent for _, spent in times["import numpy"])
    print(f"{'':<38} {'clock':>7} {'processor':>11}")
    for name, found in times.items():
        clock, spent = (statistics.median(column) for column in zip(*found, strict=True))
        print(f"{name:<38} {clock:>5.2f} s {spent:>9.2f} s   {spent / numpy:.2f} times an import of numpy")
    print(f"load average {os.getloadavg()[0]:.1f}")


if __name__ == "__main__":
    main()
