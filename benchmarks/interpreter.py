"""The flagship's frame in the interpreter against its numpy reference, in one run: ``python benchmarks/interpreter.py``.

One flight in the float interpreter, and a batch of flights with a leading axis; the two sides take turns, the ratio is
taken pair by pair, and its median printed.
"""

from __future__ import annotations

import argparse
import statistics
import time

import numpy as np

import saoflow
from verification.flights import load_recording, sensors
from verification.reference import cmhe_fte as reference


def main() -> None:
    """Print us per frame and the ratios."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--frames", type=int, default=400)
    parser.add_argument("--flights", type=int, default=4000)
    parser.add_argument("--batch-frames", type=int, default=12)
    parser.add_argument("--repeat", type=int, default=5)
    options = parser.parse_args()
    recording = sensors(load_recording("a320_wind_350kt_5000ft"), seed=1)
    inputs = {name: array[: options.frames] for name, array in recording.inputs().items()}
    simulator = saoflow.load("cmhe_fte").simulator()
    batch = saoflow.load("cmhe_fte").simulator()
    flights = {
        name: np.repeat(array[None, : options.batch_frames], options.flights, axis=0) for name, array in inputs.items()
    }
    simulator.run({name: array[:2] for name, array in inputs.items()})
    batch.run({name: array[:1, :1] for name, array in flights.items()})
    rows = []
    for _ in range(options.repeat):
        simulator.reset()
        batch.reset()
        one = _seconds(lambda: simulator.run(inputs)) / options.frames
        plain = _seconds(lambda: reference.run(inputs)) / options.frames
        many = _seconds(lambda: batch.run(flights)) / (options.batch_frames * options.flights)
        rows.append((one, plain, many))
    one, plain, many = (1e6 * statistics.median(column) for column in zip(*rows, strict=True))
    print(f"numpy reference, one flight       {plain:9.1f} us a frame")
    print(f"interpreter, one flight           {one:9.1f} us a frame")
    print(f"interpreter, {options.flights} flights        {many:9.2f} us a frame and flight")
    print(f"reference / interpreter, one flight: {statistics.median(p / o for o, p, _ in rows):.2f}")
    print(f"reference / batch, per flight:       {statistics.median(p / m for _, p, m in rows):.1f}")


def _seconds(work: object) -> float:
    assert callable(work)
    start = time.perf_counter()
    work()
    return time.perf_counter() - start


if __name__ == "__main__":
    main()
