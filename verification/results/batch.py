"""Many flights through a sheet at once, and what came out of each."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

import saoflow
from verification.flights import Recording

Array = NDArray[np.float64]
Progress = Callable[[float], None]
"""Called with the share of the work that is done, 0 to 1."""

FEW = 16
"""Fewer flights than this are quicker one by one."""

DEGREES = 180.0 / math.pi


@dataclass(frozen=True, eq=False)
class Outcome:
    """One flight through a sheet: decisions and errors of the estimates, one row a frame."""

    alpha_faulty: NDArray[np.bool_]  # (frames, 3)
    vc_faulty: NDArray[np.bool_]  # (frames, 3)
    alpha_rms: Array  # (frames, 3), deg
    vc_rms: Array  # (frames, 3), kt
    alpha_error: Array  # (frames,), deg: estimate minus truth
    vc_error: Array  # (frames,), kt
    wx_hat: Array  # (frames,), kt
    configuration: Array  # (frames,)

    def faulty(self, sensor: str) -> NDArray[np.bool_]:
        """Confirmed sensors of one kind, "alpha" or "vc", (frames, 3)."""
        return self.alpha_faulty if sensor == "alpha" else self.vc_faulty


def run_batch(sheet: str, flights: Sequence[Recording], progress: Progress | None = None) -> list[Outcome]:
    """Run flights with sensor readings through a shipped sheet, many side by side, few one after the other.

    The results have the same bits either way. Flights may differ in length: a shorter one is repeated at its last frame, and what that gives is left out.

    Raises :class:`saoflow.DiagnosisError` as the parts do.
    """
    simulator = saoflow.load(sheet).simulator()
    frames = max(len(flight) for flight in flights)
    if len(flights) < FEW:
        outcomes = []
        for i, flight in enumerate(flights):
            simulator.reset()
            outcomes.append(_outcome(flight, simulator.run(flight.inputs())))
            if progress is not None:
                progress((i + 1) / len(flights))
        return outcomes
    columns = [flight.inputs() for flight in flights]
    inputs = {name: np.stack([_extended(c[name], frames) for c in columns]) for name in columns[0]}

    def tell(done: int) -> None:
        if progress is not None:
            progress(done / frames)

    out = simulator.run(inputs, progress=tell)
    return [_outcome(flight, {name: rows[i] for name, rows in out.items()}) for i, flight in enumerate(flights)]


def _extended(column: Array, frames: int) -> Array:
    return np.concatenate([column, np.repeat(column[-1:], frames - len(column), axis=0)])


def _outcome(flight: Recording, out: dict[str, Array]) -> Outcome:
    n = len(flight)
    return Outcome(
        alpha_faulty=out["alpha_faulty"][:n] > 0.5,
        vc_faulty=out["vc_faulty"][:n] > 0.5,
        alpha_rms=out["alpha_rms"][:n] * DEGREES,
        vc_rms=out["vc_rms"][:n],
        alpha_error=(out["alpha_hat"][:n] - flight["alpha_true"]) * DEGREES,
        vc_error=out["vc_hat"][:n] - flight["vc_true"],
        wx_hat=out["wx_hat"][:n],
        configuration=out["configuration"][:n],
    )


def first_frame(confirmed: NDArray[np.bool_], count: int) -> int | None:
    """The first frame in which at least ``count`` sensors (frames, n) are confirmed, or None."""
    enough = np.asarray(confirmed).sum(axis=1) >= count
    return int(np.argmax(enough)) if enough.any() else None
