"""A recording: a table of frames in memory, and its text form.

The text form is CSV with a header line, 9 significant digits, gzip-compressed if the name ends in ``.gz``;
Parquet (with pyarrow, extra ``saoflow[parquet]``) if it ends in ``.parquet``.
"""

from __future__ import annotations

import csv
import gzip
import io
import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from verification.flights.errors import FlightError, did_you_mean

Array = NDArray[np.float64]

FRAME_PERIOD = 0.048
"""Frame period [s]: 370 samples take 17.76 s in paper 004, section VI."""

SENSOR_INPUTS = ("alpha", "vc")
INERTIAL_INPUTS = ("vg", "vz", "theta", "q", "ax", "az", "z")


@dataclass(frozen=True, eq=False)
class Recording:
    """A table of frames.

    ``names``: column names; ``columns``: one array (n,) for each name; ``period``: frame period [s].
    Columns are copied and not writable. Raises :class:`FlightError` E725 if the columns do not fit together.
    """

    names: tuple[str, ...]
    columns: tuple[Array, ...]
    period: float = FRAME_PERIOD

    def __post_init__(self) -> None:
        if len(self.names) != len(self.columns) or len(set(self.names)) != len(self.names):
            raise FlightError(
                "E725",
                f"a recording of {len(self.names)} names and {len(self.columns)} columns",
                cause="names and columns must be in pairs, every name once",
                remedy="give one column for every name",
            )
        lengths = {column.shape for column in self.columns}
        if len(lengths) != 1 or len(next(iter(lengths))) != 1 or next(iter(lengths)) == (0,):
            raise FlightError(
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
        """Column ``name``, shape (n,), not writable. Raises E722 for an unknown name."""
        if name not in self.names:
            raise FlightError(
                "E722",
                f"the recording has no column '{name}'",
                cause=f"its columns are {', '.join(self.names)}",
                remedy="name one of them",
                hint=did_you_mean(name, self.names),
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
        ``ax``, ``az`` [kt/s^2], ``z`` [m] of shape (n,). Raises E722 if there are no sensor readings yet.
        """
        for sensor in SENSOR_INPUTS:
            if f"{sensor}_1" not in self.names:
                raise FlightError(
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
    table = np.stack(recording.columns, axis=1)
    lines = [",".join(recording.names)]
    lines.extend(",".join(f"{value:.9g}" for value in row) for row in table.tolist())
    return "\n".join(lines) + "\n"


def check_output(path: str | Path) -> None:
    """Raises E724 if :func:`write_recording` could not write ``path``: before the work, not after it."""
    path = Path(path)
    if not path.name.lower().endswith((".csv", ".csv.gz", ".parquet")):
        raise FlightError(
            "E724",
            f"{path}: the kind of file is not known by its extension",
            cause="recordings are written as .csv, .csv.gz or .parquet",
            remedy="choose one of these extensions",
        )
    cause = ""
    if path.is_dir():
        cause = "it is a folder"
    elif not path.parent.is_dir():
        cause = f"there is no folder '{path.parent}'"
    elif not os.access(path.parent, os.W_OK):
        cause = f"the folder '{path.parent}' may not be written to"
    if cause:
        raise FlightError(
            "E724",
            f"{path}: cannot be written",
            cause=cause,
            remedy="name a file in a folder that exists and that you may write to",
        )
    if path.name.lower().endswith(".parquet"):
        _pyarrow(path)


def write_recording(recording: Recording, path: str | Path) -> None:
    """Writes ``.csv``, ``.csv.gz`` or ``.parquet``, all of it or nothing. Raises E724."""
    check_output(path)
    path = Path(path)
    name = path.name.lower()
    if name.endswith(".parquet"):
        payload = _to_parquet(recording, path)
    elif name.endswith(".csv.gz"):
        # No time stamp and no file name inside: the same recording gives the same bytes.
        payload = gzip.compress(to_csv(recording).encode("ascii"), compresslevel=9, mtime=0)
    else:
        payload = to_csv(recording).encode("ascii")
    _replace(path, payload)


def _pyarrow(path: Path) -> Any:
    try:
        import pyarrow
        import pyarrow.parquet
    except ImportError:
        raise FlightError(
            "E724",
            f"{path}: Parquet needs pyarrow",
            cause="pyarrow is not installed",
            remedy="pip install 'saoflow[parquet]', or write .csv",
        ) from None
    return pyarrow


def _to_parquet(recording: Recording, path: Path) -> bytes:
    pyarrow = _pyarrow(path)
    table = pyarrow.table(dict(zip(recording.names, recording.columns, strict=True)))
    buffer = io.BytesIO()
    pyarrow.parquet.write_table(table, buffer)
    return buffer.getvalue()


def _replace(path: Path, payload: bytes) -> None:
    temporary = path.with_name(f".{path.name}.{os.getpid()}.part")
    try:
        temporary.write_bytes(payload)
        os.replace(temporary, path)
    except OSError as error:
        temporary.unlink(missing_ok=True)
        raise FlightError(
            "E724",
            f"{path}: cannot be written",
            cause=error.strerror or str(error),
            remedy="choose a path in a folder that exists and that you may write to",
        ) from None


def read_recording(path: str | Path, period: float = FRAME_PERIOD) -> Recording:
    """Reads ``.csv`` or ``.csv.gz`` as written by :func:`write_recording`. Raises E723 with line and
    column.
    """
    path = Path(path)
    try:
        raw = path.read_bytes()
        text = (gzip.decompress(raw) if path.name.endswith(".gz") else raw).decode("utf-8")
    except (OSError, EOFError, UnicodeDecodeError) as error:
        raise FlightError(
            "E723",
            f"{path}: cannot be read",
            cause=str(error),
            remedy="name a CSV file, plain or .gz",
        ) from None
    rows = list(csv.reader(io.StringIO(text)))
    if len(rows) < 2:
        raise FlightError(
            "E723",
            f"{path}: no frames in it",
            cause="a recording is a header line and one line for each frame",
            remedy="record it again",
        )
    names = tuple(name.strip() for name in rows[0])
    table = np.empty((len(rows) - 1, len(names)))
    for line, row in enumerate(rows[1:], start=2):
        if len(row) != len(names):
            raise FlightError(
                "E723",
                f"{path}:{line}: {len(row)} values for {len(names)} columns",
                cause="every line has one value for each name of the header",
                remedy="mend or drop the line",
            )
        try:
            table[line - 2] = row  # numpy reads the numbers; text like 'nan' and 'inf' is a number here
        except ValueError:
            bad = next(i for i, value in enumerate(row) if not _is_number(value))
            raise FlightError(
                "E723",
                f"{path}:{line}: column '{names[bad]}': '{row[bad]}' is not a number",
                cause="every value of a recording is a number",
                remedy="mend the value; a missing one is 'nan'",
            ) from None
    return Recording(names, tuple(table.T), period)


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True
