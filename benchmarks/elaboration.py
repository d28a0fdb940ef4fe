"""How elaboration grows with the sheet: ``python benchmarks/elaboration.py``.

Sheets of 1e3 to 1e5 blocks (a chain with side wires, a limiter and a delayed feedback) are read, elaborated, ordered and
lowered; each size several times, the median of the processor time taken, and an exponent fitted to it against blocks.
"""

from __future__ import annotations

import argparse
import itertools
import statistics
import tempfile
import time
from pathlib import Path

import numpy as np

import saoflow

STAGES = ("read", "elaborate", "order", "lower")


def sheet_text(blocks: int) -> str:
    """A valid sheet with ``blocks`` blocks."""
    lines = ["sheet: chain", "profile: six", "inputs: {u: {unit: kt}}", "blocks:"]
    lines += ["  b0: {add: [u, d]}", "  d: {delay: b0, initial: 0}"]
    kinds = ("{{mul: [b{0}, 0.999]}}", "{{add: [b{0}, -b{1}]}}", "{{saturation: b{0}, low: -100, high: 100}}")
    lines += [f"  b{i}: " + kinds[i % 3].format(i - 1, max(i - 7, 0)) for i in range(1, blocks - 1)]
    return "\n".join([*lines, f"outputs: [b{blocks - 2}]", ""])


def measure(path: Path) -> list[float]:
    """Seconds of each stage."""
    marks = [time.process_time()]
    sheet = saoflow.load(str(path))
    marks.append(time.process_time())
    for stage in ("netlist", "schedule", "frame_program"):
        getattr(sheet, stage)
        marks.append(time.process_time())
    return [b - a for a, b in itertools.pairwise(marks)]


def main() -> None:
    """Print a table and the fitted exponents."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--repeat", type=int, default=3)
    parser.add_argument("--sizes", type=int, nargs="+", default=[1_000, 3_000, 10_000, 30_000, 100_000])
    options = parser.parse_args()
    medians: list[list[float]] = []
    print(f"{'blocks':>8} " + " ".join(f"{stage:>10}" for stage in STAGES) + f" {'total':>8} {'us/block':>9}")
    with tempfile.TemporaryDirectory() as folder:
        for size in options.sizes:
            path = Path(folder) / f"chain_{size}.yaml"
            path.write_text(sheet_text(size), encoding="utf-8")
            if not medians:
                measure(path)  # the first run imports what is imported lazily
            runs = [measure(path) for _ in range(options.repeat)]
            median = [statistics.median(column) for column in zip(*runs, strict=True)]
            medians.append(median)
            total = sum(median)
            stages = " ".join(f"{seconds:>9.3f}s" for seconds in median)
            print(f"{size:>8} {stages} {total:>7.2f}s {1e6 * total / size:>9.1f}")
    logs = np.log(np.array(options.sizes, dtype=float))
    for name, column in zip((*STAGES, "total"), zip(*[[*m, sum(m)] for m in medians], strict=True), strict=True):
        exponent = np.polyfit(logs, np.log(np.array(column)), 1)[0]
        print(f"fitted exponent of {name:<10} {exponent:.3f}")


if __name__ == "__main__":
    main()
