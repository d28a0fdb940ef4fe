"""A recording: a table of frames in memory, and its text form.

The text form is CSV with a header line, 9 significant digits, gzip-compressed if the name ends in ``.gz``;
Parquet (with pyarrow, extra ``saoflow[parquet]``) if it ends in ``.parquet``.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from saoflow import recordings as recording_files
from saoflow.diagnosis import did_you_mean, refusal
from saoflow.recordings import csv_text

Array = NDArray[np.float64]

FRAME_PERIOD = 0.048
"""Frame period [s]: 370 samples take 17.76 s in paper 004, section VI."""

NINE_DIGITS = "{:.9g}".format
"""How numbers are written: more digits than any sensor has, in half the space."""

SENSOR_INPUTS = ("alpha", "vc")
INERTIAL_INPUTS = ("vg", "vz", "theta", "q", "ax", "az", "z")


@dataclass(frozen=True, eq=False)
class Recording:
    """A table of frames.

    ``names``: column names; ``columns``: one array (n,) for each name; ``period``: frame period [s].
    Columns are copied and not writable. Raises DiagnosisError E725 if the columns do not fit together.
    """

    names: tuple[str, ...]
    columns: tuple[Array, ...]
    period: float = FRAME_PERIOD

    def __post_init__(self) -> None:
        if len(self.names) != len(self.columns) or len(set(self.names)) != len(self.names):
            raise refusal(
                "E725",
                f"a recording of {len(self.names)} names and {len(self.columns)} columns",
                cause="names and columns must be in pairs, every name once",
                remedy="give one column for every name",
            )
        lengths = {column.shape for column in self.columns}
        if len(lengths) != 1 or len(next(iter(lengths))) != 1 or next(iter(lengths)) == (0,):
            raise refusal(
                "E725",
                "columns of a recording differ in length, are empty or are not vectors",
                cause=f"shapes found: {sorted(lengths)}",
                remedy="give columns of one length, at least 1",
            )
        object.__setattr__(self, "names", tuple(self.names))
        columns = tuple(np.array(column, dtype=np.float64) for column in self.columns)
        for column in columns:
            column.setflags(write=False)
        object.__setattr__(self, "columns", columns)

    def __len__(self) -> int:
        """The number of frames n."""
        return len(self.columns[0])

    def __contains__(self, name: object) -> bool:
        return name in self.names

    def __getitem__(self, name: str) -> Array:
        """Column ``name``, shape (n,), not writable. Raises DiagnosisError E722 for an unknown name."""
        if name not in self.names:
            raise refusal(
                "E722",
                f"the recording has no column `{name}`",
                cause=f"its columns are {', '.join(self.names)}",
                remedy=did_you_mean(name, self.names) or "name one of them",
            )
        return self.columns[self.names.index(name)]

    def with_columns(self, new: Mapping[str, Array]) -> Recording:
        """A recording with columns replaced (same name) or appended (new name)."""
        merged = dict(zip(self.names, self.columns, strict=True))
        merged.update(new)
        return Recording(tuple(merged), tuple(merged.values()), self.period)

    def part(self, start_s: float, end_s: float) -> Recording:
        """The frames with start_s <= time since the first frame < end_s, [s]."""
        first, last = round(start_s / self.period), round(end_s / self.period)
        return Recording(self.names, tuple(column[first:last] for column in self.columns), self.period)

    def inputs(self) -> dict[str, Array]:
        """The flagship's inputs as simulators take them.

        ``alpha`` [rad] and ``vc`` [kt] of shape (n, 3); ``vg``, ``vz`` [kt], ``theta`` [rad], ``q`` [rad/s],
        ``ax``, ``az`` [kt/s^2], ``z`` [m] of shape (n,). Raises DiagnosisError E722 if there are no
        sensor readings yet.
        """
        for sensor in SENSOR_INPUTS:
            if f"{sensor}_1" not in self.names:
                raise refusal(
                    "E722",
                    f"the recording has no sensor readings {sensor}_1, {sensor}_2, {sensor}_3",
                    cause="it holds the truth; readings are made from it by seed, with noise and faults",
                    remedy="make them first: sensors(recording, seed=1).inputs()",
                )
        found: dict[str, Array] = {
            sensor: np.stack([self[f"{sensor}_{i}"] for i in (1, 2, 3)], axis=1) for sensor in SENSOR_INPUTS
        }
        return found | {name: self[name].copy() for name in INERTIAL_INPUTS}


def to_csv(recording: Recording) -> str:
    """The recording as CSV text, numbers with 9 significant digits."""
    return csv_text(_columns(recording), NINE_DIGITS)


def write_recording(recording: Recording, path: str | Path) -> None:
    """Writes ``.csv``, ``.csv.gz`` or ``.parquet``, all of it or nothing. Raises DiagnosisError E601, E605."""
    recording_files.write_table(path, _columns(recording), NINE_DIGITS)


def read_recording(path: str | Path, period: float = FRAME_PERIOD) -> Recording:
    """Reads ``.csv``, ``.csv.gz`` or ``.parquet``. Raises DiagnosisError as :func:`saoflow.recordings.read_table` does,
    with line and column.
    """
    table = recording_files.read_table(path)
    return Recording(table.names, table.columns, period)


def _columns(recording: Recording) -> dict[str, Array]:
    return dict(zip(recording.names, recording.columns, strict=True))
