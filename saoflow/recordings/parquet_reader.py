"""Reading the columns of Parquet files, with pyarrow (extra ``saoflow[parquet]``)."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from saoflow.diagnosis import Diagnosis, DiagnosisError, Position
from saoflow.recordings.table import MOST_SHOWN, Chooser, Part, Table, nothing_in, unreadable

ROWS = 8192
"""Rows that are read together."""
BUFFER = 1 << 16
"""Bytes that are read together of each column."""


def need_pyarrow(path: str) -> Any:
    """The package, or DiagnosisError E605."""
    try:
        import pyarrow
        import pyarrow.parquet
    except ImportError:
        raise DiagnosisError(
            [
                Diagnosis(
                    "E605",
                    f"{path}: Parquet needs the package pyarrow",
                    cause="pyarrow is not installed",
                    remedy="pip install 'saoflow[parquet]', or use .csv or .csv.gz",
                )
            ]
        ) from None
    return pyarrow


def parquet_parts(path: str, choose: Chooser, flags: frozenset[str]) -> Iterator[Part]:
    """The chosen columns, some rows at a time; those in ``flags`` hold 0 and 1. Mistakes as in :func:`csv_parts`."""
    pyarrow = need_pyarrow(path)
    try:
        # Buffered, and not ahead of the rows: a row group as long as the file stays on the disk.
        with pyarrow.parquet.ParquetFile(path, buffer_size=BUFFER, pre_buffer=False) as file:
            names = list(file.schema_arrow.names)
            chosen = choose(names)
            mistakes = [d for d in chosen if isinstance(d, Diagnosis)]
            wanted = [name for name in chosen if isinstance(name, str)]
            rows = file.metadata.num_rows
            mistakes += _parquet_mistakes(path, pyarrow, file.schema_arrow, wanted)
            if not rows and not mistakes:
                mistakes.append(nothing_in(path, "E504", "the recording has no rows", "the file has columns only"))
            if mistakes:
                raise DiagnosisError(mistakes)
            done = 0
            for batch in file.iter_batches(ROWS, columns=wanted, use_threads=False):
                columns = tuple(_parquet_column(batch.column(name), pyarrow) for name in wanted)
                for i, name in enumerate(wanted):
                    if name in flags and len(mistakes) < MOST_SHOWN:
                        mistakes += _parquet_flags(path, name, i, done, columns[i])
                done += batch.num_rows
                if not mistakes:
                    yield Part(Table(tuple(wanted), columns, batch.num_rows), done / rows)
    except pyarrow.ArrowException as error:
        raise unreadable(path, f"it is not a Parquet file: {str(error).splitlines()[0]}", "write it again") from None
    if mistakes:
        raise DiagnosisError(mistakes[:MOST_SHOWN])


def _parquet_mistakes(path: str, pyarrow: Any, schema: Any, wanted: Sequence[str]) -> list[Diagnosis]:
    found = []
    types = pyarrow.types
    for name in dict.fromkeys(wanted):
        places = schema.get_all_field_indices(name)
        position = Position(path, 1, places[0] + 1 if places else 1)
        if len(places) > 1:
            cause = f"columns {', '.join(str(i + 1) for i in places)} have this name"
            remedy = "rename or drop one of them"
            found.append(Diagnosis("E506", f"column `{name}` is there {len(places)} times", position, cause, remedy))
        elif places:
            kind = schema.field(places[0]).type
            tests = (types.is_floating, types.is_integer, types.is_boolean, types.is_decimal, types.is_null)
            if not any(test(kind) for test in tests):
                message = f"column `{name}` does not hold numbers"
                remedy = "write the column as float64; a missing sample is null or NaN"
                found.append(Diagnosis("E503", message, position, f"its type is {kind}", remedy))
    return found


def _parquet_column(column: Any, pyarrow: Any) -> np.ndarray:
    if not pyarrow.types.is_float64(column.type):
        column = column.cast(pyarrow.float64(), safe=False)
    return np.asarray(column.to_numpy(zero_copy_only=False), dtype=np.float64)  # null comes out as NaN


def _parquet_flags(path: str, name: str, place: int, before: int, column: np.ndarray) -> list[Diagnosis]:
    """Values of a boolean input that are neither; ``before``: rows before the first of ``column``."""
    odd = np.flatnonzero((column != 0) & (column != 1) & np.isfinite(column))
    return [
        Diagnosis(
            "E503",
            f"`{column[i]:g}` in row {before + i + 1} of column `{name}` is not 0 or 1",
            Position(path, before + int(i) + 1, place + 1),
            "the column is a boolean input: 0 or 1",
            "correct the cell; a missing sample is null or NaN",
        )
        for i in odd[:MOST_SHOWN]
    ]
