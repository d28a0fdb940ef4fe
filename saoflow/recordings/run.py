"""A recording of any length through a sheet, to a recording: read, run and written in parts."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from saoflow.recordings import FrameReader, Output, open_table, output_columns

if TYPE_CHECKING:
    from saoflow.recordings import Frames
    from saoflow.scheduler.simulator import Arrays, Simulator

Progress = Callable[[float], None]
"""Told the share that is done, 0 to 1."""


@dataclass(frozen=True, slots=True)
class Done:
    """What came of a run."""

    frames: int
    seconds: float
    """In the frames, without reading and writing."""
    missing: dict[str, int]
    """Missing samples, by column of the input."""
    columns: tuple[str, ...]
    """Of the output."""


@dataclass(slots=True)
class Kept:
    """The first ``most`` frames of a run, for a report."""

    most: int
    count: int = 0
    _inputs: list[Arrays] = field(default_factory=list)
    _outputs: list[Arrays] = field(default_factory=list)
    _t: list[np.ndarray] = field(default_factory=list)

    def add(self, frames: Frames, outputs: Arrays) -> None:
        """Keep frames and what came of them, as far as there is room."""
        room = min(self.most - self.count, frames.count)
        if room > 0:
            self._inputs.append({name: array[:room] for name, array in frames.inputs.items()})
            self._outputs.append({name: array[:room] for name, array in outputs.items()})
            if frames.t is not None:
                self._t.append(frames.t[:room])
            self.count += room

    def inputs(self) -> Arrays:
        """(frames, *shape) by name."""
        return _joined(self._inputs)

    def outputs(self) -> Arrays:
        """(frames, *shape) by name."""
        return _joined(self._outputs)

    def t(self) -> np.ndarray | None:
        """(frames,), the time column; None if there is none, or it does not go forward."""
        if not self._t:
            return None
        t = np.concatenate(self._t)
        return t if np.isfinite(t).all() and (np.diff(t) > 0.0).all() else None


def run_recording(
    simulator: Simulator,
    reader: FrameReader,
    output: Output | str,
    progress: Progress | None = None,
    kept: Kept | None = None,
) -> Done:
    """Run all frames of ``reader`` from the simulator's present state, and write outputs and probes to ``output``.

    The file is as one run of all frames gives it; memory does not grow with the recording. ``kept`` gets the first
    frames. Raises DiagnosisError as the reader does, E506, E601, E605; then, and when interrupted, no file is left.
    """
    program = simulator.program
    types = {port.name: port.type for port in (*program.outputs, *program.probes)}
    seconds = 0.0
    columns: tuple[str, ...] = ()
    tell = progress or (lambda share: None)
    with open_table(output) as writer:
        before = 0.0
        for frames in reader:
            share = _share_within(tell, before, reader.share, frames.count)
            start = time.perf_counter()
            # A sheet without inputs takes the number of frames from any array.
            arrays = simulator.run(frames.inputs or {"frames": np.zeros(frames.count)}, progress=share)
            seconds += time.perf_counter() - start
            table = output_columns(arrays, types, frames.t)
            writer.write(table)
            columns = tuple(table)
            if kept is not None:
                kept.add(frames, arrays)
            before = reader.share
            tell(before)
    return Done(reader.count, seconds, reader.missing, columns)


def _share_within(tell: Progress, low: float, high: float, count: int) -> Callable[[int], None]:
    return lambda done: tell(low + (high - low) * done / max(1, count))


def _joined(parts: list[Arrays]) -> Arrays:
    return {name: np.concatenate([part[name] for part in parts]) for name in (parts[0] if parts else ())}
