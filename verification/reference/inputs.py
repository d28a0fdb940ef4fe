"""The inputs of a frame, and a recording cut into frames."""

from __future__ import annotations

import difflib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from verification.reference.arrays import Array

INERTIAL = ("vg", "vz", "theta", "q", "ax", "az", "z")
"""The inertial inputs, in the order of `Inputs.inertial`."""

SHAPES: dict[str, tuple[int, ...]] = {"alpha": (3,), "vc": (3,), **dict.fromkeys(INERTIAL, ())}


class RecordingError(ValueError):
    """A recording that cannot be run: the message says which input, why, and what to do."""


@dataclass(frozen=True)
class Inputs:
    """One frame of inputs, in the units of the ports. NaN and infinity mark a missing sample."""

    sensors: Array  # (2, 3): alpha in rad, vc in kt
    inertial: Array  # (7,): vg, vz in kt; theta in rad; q in rad/s; ax, az in kt/s^2; z in m


def frames(recording: Mapping[str, npt.ArrayLike]) -> Iterator[Inputs]:
    """Yield the frames of a recording: `alpha`, `vc` of shape (n, 3), the inertial inputs of shape (n,).

    Other entries are ignored.

    Raises:
        RecordingError: an input is missing, is not numbers, or has another shape.
    """
    columns = {name: _column(recording, name, shape) for name, shape in SHAPES.items()}
    lengths = {name: len(column) for name, column in columns.items()}
    if len(set(lengths.values())) > 1:
        raise RecordingError(f"the inputs differ in length: {lengths}; give one row a frame to each")
    inertial = np.stack([columns[name] for name in INERTIAL], axis=1)
    sensors = np.stack([columns["alpha"], columns["vc"]], axis=1)
    for sensors_k, inertial_k in zip(sensors, inertial, strict=True):
        yield Inputs(sensors_k, inertial_k)


def _column(recording: Mapping[str, npt.ArrayLike], name: str, shape: tuple[int, ...]) -> Array:
    if name not in recording:
        near = difflib.get_close_matches(name, list(recording), n=1)
        hint = f"; did you mean {near[0]!r}?" if near else ""
        raise RecordingError(f"input {name!r} is missing (present: {sorted(recording)}){hint}")
    try:
        column = np.asarray(recording[name], dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise RecordingError(f"input {name!r} is not an array of numbers: {error}") from error
    if column.ndim != 1 + len(shape) or column.shape[1:] != shape:
        expected = ", ".join(["n", *map(str, shape)])
        raise RecordingError(f"input {name!r} has shape {column.shape}, expected ({expected})")
    return column
