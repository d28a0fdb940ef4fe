"""The columns of a recording, whatever the kind of file: in parts, or all at once."""

from __future__ import annotations

import gzip
import os
import zlib
from collections.abc import Generator

import numpy as np

from saoflow.diagnosis import DiagnosisError
from saoflow.recordings import table
from saoflow.recordings.csv_reader import csv_parts
from saoflow.recordings.parquet_reader import parquet_parts
from saoflow.recordings.table import EXTENSIONS, Chooser, Part, Table, extension, nothing_in, too_large, unreadable


def column_parts(path: str, choose: Chooser, flags: frozenset[str] = frozenset()) -> Generator[Part, None, None]:
    """The chosen columns of a file, rows in order; those in ``flags`` hold 0 and 1.

    No row comes after the first mistake, and DiagnosisError with all mistakes at the end. Memory does not grow with
    the length of the file.
    """
    if extension(path) not in EXTENSIONS:
        raise unreadable(
            path,
            "the kind of file is not known by its extension",
            f"recordings end in {', '.join(EXTENSIONS[:-1])} or {EXTENSIONS[-1]}",
        )
    try:
        size = os.stat(path).st_size
        if os.path.isdir(path):
            raise unreadable(path, "it is a folder", "name a file")
        if size == 0:
            raise DiagnosisError([nothing_in(path, "E103", "the recording is empty", "the file has no bytes")])
        yield from (parquet_parts if extension(path) == ".parquet" else csv_parts)(path, choose, flags)
    except FileNotFoundError:
        raise unreadable(path, "there is no such file", "check the path") from None
    except (EOFError, zlib.error, gzip.BadGzipFile) as error:
        raise unreadable(path, f"it is not a whole gzip file: {error}", "pack it again, or give the .csv") from None
    except OSError as error:
        raise unreadable(path, error.strerror or str(error), "check the path and your rights") from None
    except ValueError as error:
        if "null" not in str(error):
            raise
        raise unreadable(path.replace("\0", "\\0"), "the path holds a null character", "check the path") from None


def read_columns(path: str, choose: Chooser, flags: frozenset[str] = frozenset()) -> Table:
    """The chosen columns as a whole. Raises DiagnosisError with all that is found, E110 for more than memory holds."""
    tables: list[Table] = []
    taken = 0
    for part in column_parts(path, choose, flags):
        tables.append(part.table)
        taken += sum(column.nbytes for column in part.table.columns)
        if taken > table.MOST_BYTES:
            raise DiagnosisError([too_large(path)])
    if len(tables) == 1:
        return tables[0]
    columns = tuple(np.concatenate(parts) for parts in zip(*(one.columns for one in tables), strict=True))
    return Table(tables[0].names, columns, sum(len(one) for one in tables))
