"""The filter chain of ``filter_chain.yaml`` in another tool, for ``filter_chain.py``: ``PYTHON filter_chain_tools.py TOOL FRAMES``.

98 blocks: a gain, 24 lags of (difference, gain, sum, delay of one frame), a gain. Source and recorder come on top, and are
not counted. Prints JSON: processor seconds of the run (building the diagram is not in them), the output of every frame, and
the version of the tool. Runs in a Python that has pathsim or bdsim; needs nothing of saoflow.
"""

from __future__ import annotations

import contextlib
import io
import json
import math
import sys
import time
from importlib.metadata import version
from typing import Any

PERIOD = 0.125
"""Seconds a frame: a power of two, so that no tool misses a frame by rounding."""
LAGS = 24


def source_at(frame: int) -> float:
    """The input in a frame; 0 in the first."""
    return math.sin(0.05 * frame)


def source(t: float) -> float:
    """The input at a time."""
    return source_at(round(t / PERIOD))


def gain(lag: int) -> float:
    """As in the sheet."""
    return 0.1 + 0.03 * lag


def pathsim(frames: int) -> tuple[float, list[float]]:
    """Blocks and connections of pathsim, in fixed steps of one frame: the quickest of its ways that was found.

    Its sampled delay evaluates the whole diagram once more for each delay in each step; its delay in time does not, and
    with steps of its own length gives the same numbers (also in the first frame, as the input starts at 0).
    """
    from pathsim import Connection, Simulation  # type: ignore[import-not-found]
    from pathsim.blocks import Adder, Amplifier, Delay, Scope, Source  # type: ignore[import-not-found]
    from pathsim.solvers import EUF  # type: ignore[import-not-found]

    start, scaled = Source(source), Amplifier(0.5)
    blocks: list[Any] = [start, scaled]
    wires = [Connection(start, scaled)]
    before: Any = scaled
    for lag in range(LAGS):
        error, change, value = Adder("+-"), Amplifier(gain(lag)), Adder("++")
        last = Delay(tau=PERIOD)
        blocks += [error, change, value, last]
        wires += [
            Connection(before, error[0]),
            Connection(last, error[1], value[0]),
            Connection(error, change),
            Connection(change, value[1]),
            Connection(value, last),
        ]
        before = value
    raised, scope = Amplifier(2.0), Scope()
    blocks += [raised, scope]
    wires += [Connection(before, raised), Connection(raised, scope)]
    simulation = Simulation(blocks, wires, dt=PERIOD, Solver=EUF, log=False)
    began = time.process_time()
    simulation.run(frames * PERIOD, adaptive=False)
    seconds = time.process_time() - began
    return seconds, [float(v) for v in scope.read()[1][0]]


def bdsim(frames: int) -> tuple[float, list[float]]:
    """Blocks and connections of bdsim on one clock, without graphics; ZOH is its delay of one tick."""
    from bdsim import BDSim  # type: ignore[import-not-found]

    with contextlib.redirect_stdout(io.StringIO()):
        off = dict.fromkeys(("banner", "graphics", "animation", "progress", "toolboxes", "sysargs"), False)
        simulator = BDSim(quiet=True, **off)
        diagram = simulator.blockdiagram()
        clock = diagram.clock(PERIOD, unit="s")
        start, scaled = diagram.FUNCTION(source, nin=1), diagram.GAIN(0.5)
        diagram.connect(diagram.TIME(), start)
        diagram.connect(start, scaled)
        before = scaled
        for lag in range(LAGS):
            error, change, value = diagram.SUM("+-"), diagram.GAIN(gain(lag)), diagram.SUM("++")
            last = diagram.ZOH(clock, x0=0.0)
            diagram.connect(before, error[0])
            diagram.connect(last, error[1], value[0])
            diagram.connect(error, change)
            diagram.connect(change, value[1])
            diagram.connect(value, last)
            before = value
        raised = diagram.GAIN(2.0)
        end = diagram.NULL(1)
        diagram.connect(before, raised)
        diagram.connect(raised, end)
        diagram.compile(report=False)
        began = time.process_time()
        out = simulator.run(diagram, T=frames * PERIOD, watch=[raised])
        seconds = time.process_time() - began
    return seconds, [float(v) for v in out.y[:, 0]]


def main() -> None:
    """One run."""
    tool, frames = sys.argv[1], int(sys.argv[2])
    seconds, outputs = {"pathsim": pathsim, "bdsim": bdsim}[tool](frames)
    print(json.dumps({"seconds": seconds, "outputs": outputs, "version": version(tool)}))


if __name__ == "__main__":
    main()
