"""Columns of numbers from a recording, whatever the kind of file, and what can be wrong with all of them."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from saoflow.diagnosis import Diagnosis, DiagnosisError, Position

EXTENSIONS = (".csv", ".csv.gz", ".parquet")
MOST_BYTES = 2**30
"""Bound on the numbers of a recording that is read as a whole."""
MOST_SHOWN = 50
"""Mistakes shown one by one; the rest is counted."""

Chooser = Callable[[Sequence[str]], Sequence[str] | list[Diagnosis]]
"""From the names in the file to those that are wanted, or to what is wrong with them."""


@dataclass(frozen=True, slots=True, eq=False)
class Table:
    """Columns of numbers (rows,), by name."""

    names: tuple[str, ...]
    columns: tuple[np.ndarray, ...]
    rows: int

    def __len__(self) -> int:
        return self.rows

    def __getitem__(self, name: str) -> np.ndarray:
        return self.columns[self.names.index(name)]


@dataclass(frozen=True, slots=True, eq=False)
class Part:
    """Rows of a recording that is read in parts."""

    table: Table
    share: float
    """The share of the file that is read with them, 0 to 1."""


def extension(path: str) -> str:
    """``.csv``, ``.csv.gz``, ``.parquet``, or whatever the name ends in."""
    name = os.path.basename(path).lower()
    return next((e for e in EXTENSIONS if name.endswith(e)), os.path.splitext(name)[1])


def unreadable(path: str, cause: str, remedy: str, line: int = 0, text: str | None = None) -> DiagnosisError:
    """E501: the file as a whole, or from a line on."""
    where = Position(path, line, 1) if line else None
    head = "the recording cannot be read" if line else f"{path}: the recording cannot be read"
    return DiagnosisError([Diagnosis("E501", head, where, cause, remedy, source_line=text)])


def nothing_in(path: str, code: str, message: str, cause: str) -> Diagnosis:
    """A recording without frames."""
    return Diagnosis(
        code, message, Position(path, 1, 1), cause, "give a header line with the names, and a row for each frame"
    )


def too_large(path: str) -> Diagnosis:
    """E110."""
    return Diagnosis(
        "E110",
        "the recording is too large",
        Position(path, 1, 1),
        f"its numbers take more than {MOST_BYTES // 2**20} MiB",
        "split it, or leave out columns that the sheet does not need",
    )
