"""Writing recordings: whole files or none, checked before the work that leads to them."""

from __future__ import annotations

import contextlib
import gzip
import io
import os
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO

import numpy as np

from saoflow.diagnosis import Diagnosis, DiagnosisError
from saoflow.recording_parquet import need_pyarrow
from saoflow.recording_table import EXTENSIONS, extension

ROWS = 8192
"""Rows that are turned into text together."""

Formatter = Callable[[float], str]


@dataclass(frozen=True, slots=True)
class Output:
    """A file that can be written: where it is in the end, and where it is made."""

    path: Path
    temporary: Path


def check_output(path: str | Path, recording: str | Path | None = None) -> Output:
    """Refuse now an output that could not be written later. ``recording``: the input, which must be another file.

    Raises DiagnosisError E601, E605.
    """
    shown = str(path)
    if extension(shown) not in EXTENSIONS:
        raise _refusal(
            shown,
            "the kind of file is not known by its extension",
            f"choose a name that ends in {', '.join(EXTENSIONS[:-1])} or {EXTENSIONS[-1]}",
        )
    remedy = "name a file in a folder that exists and that you may write to"
    try:
        output = _output(path, recording, remedy)
        with open(output.temporary, "wb"):
            pass
        os.unlink(output.temporary)
    except (OSError, ValueError) as error:  # a ValueError: a null character in the path
        raise _refusal(shown, getattr(error, "strerror", None) or str(error), remedy) from None
    if extension(shown) == ".parquet":
        need_pyarrow(shown)
    return output


def _output(path: str | Path, recording: str | Path | None, remedy: str) -> Output:
    """Where to write, if nothing is in the way."""
    shown = str(path)
    target = Path(os.path.realpath(path))
    if os.path.isdir(target):
        raise _refusal(shown, "it is a folder", "name a file")
    if not os.path.isdir(target.parent):
        raise _refusal(shown, f"there is no folder `{Path(path).parent}`", "make the folder first, or name another")
    if recording is not None and os.path.exists(target) and os.path.exists(recording) and target.samefile(recording):
        raise _refusal(shown, "it is the recording that is read", "name another file")
    if os.path.exists(target) and not os.access(target, os.W_OK):
        raise _refusal(shown, "the file is there and may not be written to", remedy)
    with contextlib.suppress(FileNotFoundError):
        os.lstat(target)  # a name that the file system does not take is told here
    return Output(target, target.with_name(f".saoflow-{os.getpid()}.part"))


def write_table(
    path: str | Path | Output, columns: Mapping[str, np.ndarray], formatter: Formatter = float.__repr__
) -> None:
    """Write columns (n,) by name: the whole file, or none. Reals are written so that they come back to the same bits.

    Raises DiagnosisError E601, E605.
    """
    output = path if isinstance(path, Output) else check_output(path)
    kind = extension(output.path.name)
    try:
        with _whole_file(output) as file:
            if kind == ".parquet":
                _write_parquet(columns, file, str(output.path))
            elif kind == ".csv.gz":
                # No time stamp and no file name inside: the same columns give the same bytes.
                with gzip.GzipFile("", "wb", 6, file, mtime=0) as packed:
                    _write_text(columns, packed, formatter)
            else:
                _write_text(columns, file, formatter)
    except OSError as error:
        raise _refusal(
            str(output.path), error.strerror or str(error), "make room, or name a file that can be written"
        ) from None


@contextlib.contextmanager
def _whole_file(output: Output) -> Iterator[BinaryIO]:
    """A file that takes its name when it is complete; nothing is left behind if it is not."""
    try:
        with open(output.temporary, "wb") as file:
            yield file
        os.replace(output.temporary, output.path)
    except BaseException:
        with contextlib.suppress(OSError):
            os.unlink(output.temporary)
        raise


def _write_text(columns: Mapping[str, np.ndarray], file: BinaryIO | gzip.GzipFile, formatter: Formatter) -> None:
    file.write((",".join(_quoted(name) for name in columns) + "\n").encode())
    rows = len(next(iter(columns.values()))) if columns else 0
    for start in range(0, rows, ROWS):
        cells = [_cells(column[start : start + ROWS], formatter) for column in columns.values()]
        file.write(("\n".join(map(",".join, zip(*cells, strict=True))) + "\n").encode())


def csv_text(columns: Mapping[str, np.ndarray], formatter: Formatter = float.__repr__) -> str:
    """Columns as the text that :func:`write_table` writes into a CSV file."""
    buffer = io.BytesIO()
    _write_text(columns, buffer, formatter)
    return buffer.getvalue().decode()


def _cells(column: np.ndarray, formatter: Formatter) -> list[str]:
    if column.dtype.kind in "biu":
        return list(map(str, column.astype(np.int64).tolist()))
    return list(map(formatter, column.astype(np.float64).tolist()))


def _quoted(name: str) -> str:
    return '"' + name.replace('"', '""') + '"' if any(mark in name for mark in ',"\r\n') else name


def _write_parquet(columns: Mapping[str, np.ndarray], file: BinaryIO, path: str) -> None:
    pyarrow = need_pyarrow(path)
    buffer = io.BytesIO()
    pyarrow.parquet.write_table(pyarrow.table({name: np.asarray(c) for name, c in columns.items()}), buffer)
    file.write(buffer.getbuffer())


def _refusal(path: str, cause: str, remedy: str) -> DiagnosisError:
    return DiagnosisError([Diagnosis("E601", f"{path}: cannot be written", None, cause, remedy)])
