"""A chain of 98 blocks in compiled C against pathsim and bdsim, in one run: ``python benchmarks/filter_chain.py --python PYTHON``.

The diagram is ``filter_chain.yaml`` here and ``filter_chain_tools.py`` there: a gain, 24 lags of four blocks, a gain. PYTHON is
one that has the tools, which saoflow does not depend on:

    python -m venv chain-tools && chain-tools/bin/pip install pathsim bdsim
    python benchmarks/filter_chain.py --python chain-tools/bin/python

Counted: evaluations of those 98 blocks a second of processor time, from the call that runs the frames to its return; building
and compiling are not in it. The sides take turns, ratios are taken turn by turn, medians printed. All sides start from the
same state with the same input, and every output of the frames that the tools run is compared.
"""

from __future__ import annotations

import argparse
import json
import statistics
import subprocess
import sys
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from filter_chain_tools import source_at

import saoflow

HERE = Path(__file__).parent
BLOCKS = 98
BARS = {"pathsim": 10_000.0, "bdsim": 1_000.0}
"""How many times faster saoflow is to be, at least."""
TOLERANCE = 1e-12
"""Largest difference of an output, against values of about 1."""


@dataclass(frozen=True, slots=True)
class Run:
    """A run of a tool."""

    seconds: float
    outputs: np.ndarray
    """(frames,)"""
    version: str

    @property
    def rate(self) -> float:
        """Block evaluations a second."""
        return BLOCKS * len(self.outputs) / self.seconds


def other(tool: str, python: str, frames: int) -> Run:
    """Run a tool in the Python that has it. Raises SystemExit, with the way out, where it is missing or fails."""
    command = [python, str(HERE / "filter_chain_tools.py"), tool, str(frames)]
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=600)
    except OSError as error:
        raise SystemExit(f"{python} does not run: {error.strerror}. Give a Python with --python.") from None
    if done.returncode:
        said = (done.stderr.strip().splitlines() or ["it says nothing"])[-1]
        raise SystemExit(
            f"{tool} does not run in {python}: {said}\n"
            "python -m venv chain-tools && chain-tools/bin/pip install pathsim bdsim\n"
            "makes a Python that has it; give it with --python chain-tools/bin/python"
        )
    answer = json.loads(done.stdout)
    return Run(answer["seconds"], np.array(answer["outputs"]), answer["version"])


def main() -> int:
    """Print rates and ratios; exit 1 if a bar is missed or an output differs."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--python", default=sys.executable, help="a Python with pathsim and bdsim")
    parser.add_argument("--frames", type=int, default=1_000_000, help="of saoflow")
    parser.add_argument("--tool-frames", type=int, default=300, help="of pathsim and bdsim")
    parser.add_argument("--repeat", type=int, default=5)
    options = parser.parse_args()

    simulator = saoflow.load(str(HERE / "filter_chain.yaml")).simulator(backend="c")
    inputs = {"u": np.array([source_at(k) for k in range(options.frames)])}
    outputs = simulator.run(inputs)["y"]  # compiled here
    rates: dict[str, list[float]] = {name: [] for name in ("saoflow", *BARS)}
    versions: dict[str, str] = {}
    largest = dict.fromkeys(BARS, 0.0)
    for _ in range(options.repeat):
        simulator.reset()
        start = time.process_time()
        simulator.run(inputs)
        rates["saoflow"].append(BLOCKS * options.frames / (time.process_time() - start))
        for tool in BARS:
            run = other(tool, options.python, options.tool_frames)
            rates[tool].append(run.rate)
            versions[tool] = run.version
            largest[tool] = max(largest[tool], float(np.abs(run.outputs - outputs[: len(run.outputs)]).max()))

    print(f"{'':<16}{'blocks a second':>16}{'saoflow is':>20}{'at least':>10}{'largest difference':>21}")
    print(f"{'saoflow, C':<16}{statistics.median(rates['saoflow']):>16.3g}")
    missed = 0
    for tool, bar in BARS.items():
        ratio = statistics.median(o / t for o, t in zip(rates["saoflow"], rates[tool], strict=True))
        name = f"{tool} {versions[tool]}"
        print(
            f"{name:<16}{statistics.median(rates[tool]):>16.3g}{ratio:>13.0f} times{bar:>10.0f}{largest[tool]:>21.1e}"
        )
        missed += ratio < bar or not largest[tool] <= TOLERANCE
    return 1 if missed else 0


if __name__ == "__main__":
    sys.exit(main())
