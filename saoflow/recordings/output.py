"""Writing recordings: whole files or none, checked before the work that leads to them."""

from __future__ import annotations

import contextlib
import gzip
import io
import os
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np

from saoflow.diagnosis import Diagnosis, DiagnosisError
from saoflow.recordings.parquet_reader import need_pyarrow
from saoflow.recordings.table import EXTENSIONS, extension

ROWS = 8192
"""Rows that are turned into text together."""
GROUP = 1 << 16
"""Rows of a row group of Parquet."""

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
    output = check_place(path, recording)
    if extension(shown) == ".parquet":
        need_pyarrow(shown)
    return output


def check_place(path: str | Path, recording: str | Path | None = None) -> Output:
    """:func:`check_output` for a file of any kind. Raises DiagnosisError E601."""
    remedy = "name a file in a folder that exists and that you may write to"
    try:
        output = _output(path, recording, remedy)
        with open(output.temporary, "wb"):
            pass
        os.unlink(output.temporary)
    except (OSError, ValueError) as error:  # a ValueError: a null character in the path
        raise _refusal(str(path), getattr(error, "strerror", None) or str(error), remedy) from None
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
    with open_table(path, formatter) as writer:
        writer.write(columns)


@contextlib.contextmanager
def open_table(path: str | Path | Output, formatter: Formatter = float.__repr__) -> Iterator[TableWriter]:
    """A recording to be written in parts. It takes its name at the end; nothing is left if it does not get there.

    The same rows give the same bytes, whatever the parts. Raises DiagnosisError E601, E605.
    """
    output = path if isinstance(path, Output) else check_output(path)
    kind = extension(output.path.name)
    writer: TableWriter | None = None
    try:
        with _told(output):
            file = open(output.temporary, "wb")  # noqa: SIM115  closed by the writer
        make = {".parquet": _ParquetWriter, ".csv.gz": _PackedWriter}.get(kind, TableWriter)
        writer = make(output, file, formatter)
        yield writer
        with _told(output):
            writer.close()
            os.replace(output.temporary, output.path)
    except BaseException:
        if writer is not None:
            writer.abandon()
        with contextlib.suppress(OSError):
            os.unlink(output.temporary)
        raise


class TableWriter:
    """Rows for a recording, made by :func:`open_table`; this one writes CSV."""

    def __init__(self, output: Output, file: BinaryIO, formatter: Formatter) -> None:
        self._output = output
        self._file = file
        self._text: BinaryIO | gzip.GzipFile = file
        self._formatter = formatter
        self._names: tuple[str, ...] | None = None

    def write(self, columns: Mapping[str, np.ndarray]) -> None:
        """Append rows: columns (n,) by name, the same names every time. Raises DiagnosisError E601."""
        with _told(self._output):
            if self._names is None:
                self._names = tuple(columns)
                self._begin(columns)
            assert tuple(columns) == self._names, "the columns of a table stay what they are"
            self._rows(columns)

    def close(self) -> None:
        """The end of the table. Raises OSError."""
        self._file.close()

    def abandon(self) -> None:
        """Close what is open, whatever that says."""
        with contextlib.suppress(OSError, ValueError):
            self._file.close()

    def _begin(self, columns: Mapping[str, np.ndarray]) -> None:
        self._text.write((",".join(_quoted(name) for name in columns) + "\n").encode())

    def _rows(self, columns: Mapping[str, np.ndarray]) -> None:
        rows = len(next(iter(columns.values()))) if columns else 0
        for start in range(0, rows, ROWS):
            cells = [_cells(column[start : start + ROWS], self._formatter) for column in columns.values()]
            self._text.write(("\n".join(map(",".join, zip(*cells, strict=True))) + "\n").encode())


class _PackedWriter(TableWriter):
    """CSV packed by gzip: no time stamp and no file name inside, so that the same rows give the same bytes."""

    def __init__(self, output: Output, file: BinaryIO, formatter: Formatter) -> None:
        super().__init__(output, file, formatter)
        self._packed = gzip.GzipFile("", "wb", 6, file, mtime=0)
        self._text = self._packed

    def close(self) -> None:
        self._packed.close()
        super().close()

    def abandon(self) -> None:
        with contextlib.suppress(OSError, ValueError):
            self._packed.close()
        super().abandon()


class _ParquetWriter(TableWriter):
    """Parquet, in row groups of one size."""

    def __init__(self, output: Output, file: BinaryIO, formatter: Formatter) -> None:
        super().__init__(output, file, formatter)
        self._pyarrow = need_pyarrow(str(output.path))
        self._writer: Any = None
        self._waiting: list[Any] = []
        """Tables that do not fill a row group yet."""
        self._count = 0

    def close(self) -> None:
        self._put()
        if self._writer is not None:
            self._writer.close()
        super().close()

    def abandon(self) -> None:
        super().abandon()
        with contextlib.suppress(OSError, ValueError, self._pyarrow.ArrowException):
            if self._writer is not None:
                self._writer.close()

    def _begin(self, columns: Mapping[str, np.ndarray]) -> None:
        schema = self._table(columns).schema
        self._writer = self._pyarrow.parquet.ParquetWriter(self._file, schema)

    def _rows(self, columns: Mapping[str, np.ndarray]) -> None:
        table = self._table(columns)
        while len(table):
            taken = min(len(table), GROUP - self._count)
            self._waiting.append(table.slice(0, taken))
            self._count += taken
            table = table.slice(taken)
            if self._count == GROUP:
                self._put()

    def _put(self) -> None:
        if self._waiting:
            self._writer.write_table(self._pyarrow.concat_tables(self._waiting).combine_chunks(), GROUP)
        self._waiting, self._count = [], 0

    def _table(self, columns: Mapping[str, np.ndarray]) -> Any:
        return self._pyarrow.table({name: np.ascontiguousarray(column) for name, column in columns.items()})


@contextlib.contextmanager
def _told(output: Output) -> Iterator[None]:
    """A failure of the file system as a diagnosis."""
    try:
        yield
    except OSError as error:
        raise _refusal(
            str(output.path), error.strerror or str(error), "make room, or name a file that can be written"
        ) from None


def csv_text(columns: Mapping[str, np.ndarray], formatter: Formatter = float.__repr__) -> str:
    """Columns as the text that :func:`write_table` writes into a CSV file."""
    buffer = io.BytesIO()
    TableWriter(Output(Path(), Path()), buffer, formatter).write(columns)
    return buffer.getvalue().decode()


def _cells(column: np.ndarray, formatter: Formatter) -> list[str]:
    if column.dtype.kind in "biu":
        return list(map(str, column.astype(np.int64).tolist()))
    return list(map(formatter, column.astype(np.float64).tolist()))


def _quoted(name: str) -> str:
    return '"' + name.replace('"', '""') + '"' if any(mark in name for mark in ',"\r\n') else name


def _refusal(path: str, cause: str, remedy: str) -> DiagnosisError:
    return DiagnosisError([Diagnosis("E601", f"{path}: cannot be written", None, cause, remedy)])
