"""Cold starts in fresh processes: ``python benchmarks/start_up.py``.

Import of saoflow, and from nothing to the first frame of the flagship; medians, beside an import of numpy alone.
"""

from __future__ import annotations

import argparse
import statistics
import subprocess
import sys
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


def main() -> None:
    """Print medians in s and ratios to an import of numpy."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--repeat", type=int, default=7)
    options = parser.parse_args()
    times: dict[str, list[float]] = {name: [] for name in PROGRAMS}
    for _ in range(options.repeat):
        for name, text in PROGRAMS.items():
            start = time.perf_counter()
            subprocess.run([sys.executable, "-c", text], check=True)
            times[name].append(time.perf_counter() - start)
    numpy = statistics.median(times["import numpy"])
    for name, seconds in times.items():
        median = statistics.median(seconds)
        print(f"{name:<26} {median:.3f} s   {median / numpy:.2f} times an import of numpy")


if __name__ == "__main__":
    main()
