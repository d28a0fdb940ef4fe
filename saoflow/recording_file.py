"""Reading the columns of CSV and Parquet files, quickly when all is well, and with the place of every mistake when not."""

from __future__ import annotations

import csv
import gzip
import io
import os
import re
import warnings
import zlib
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import IO, Any

import numpy as np

from saoflow.diagnosis import Diagnosis, DiagnosisError, Position

EXTENSIONS = (".csv", ".csv.gz", ".parquet")
MOST_BYTES = 2**30
"""Bound on the text of a recording, unpacked."""
MOST_SHOWN = 50
"""Mistakes shown one by one; the rest is counted."""
ROWS = 8192
"""Rows that are turned into numbers together."""

NUMBER = re.compile(r"[+-]?(\d+\.?\d*([eE][+-]?\d+)?|\.\d+([eE][+-]?\d+)?|inf(inity)?|nan)", re.IGNORECASE | re.ASCII)

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


def extension(path: str) -> str:
    """``.csv``, ``.csv.gz``, ``.parquet``, or whatever the name ends in."""
    name = os.path.basename(path).lower()
    return next((e for e in EXTENSIONS if name.endswith(e)), os.path.splitext(name)[1])


def read_columns(path: str, choose: Chooser, flags: frozenset[str] = frozenset()) -> Table:
    """The chosen columns of a file; those in ``flags`` hold 0 and 1. Raises DiagnosisError with all that is found."""
    if extension(path) not in EXTENSIONS:
        raise _unreadable(
            path,
            "the kind of file is not known by its extension",
            f"recordings end in {', '.join(EXTENSIONS)}",
        )
    try:
        size = os.stat(path).st_size
        if os.path.isdir(path):
            raise _unreadable(path, "it is a folder", "name a file")
        if size == 0:
            raise DiagnosisError([_nothing(path, "E103", "the recording is empty", "the file has no bytes")])
        if extension(path) == ".parquet":
            return _read_parquet(path, choose, flags)
        return _Reader(path, _content(path, size), flags).read(choose)
    except FileNotFoundError:
        raise _unreadable(path, "there is no such file", "check the path") from None
    except (EOFError, zlib.error, gzip.BadGzipFile) as error:
        raise _unreadable(path, f"it is not a whole gzip file: {error}", "pack it again, or give the .csv") from None
    except OSError as error:
        raise _unreadable(path, error.strerror or str(error), "check the path and your rights") from None
    except ValueError as error:
        if "null" not in str(error):
            raise
        raise _unreadable(path.replace("\0", "\\0"), "the path holds a null character", "check the path") from None


def _content(path: str, size: int) -> bytes:
    """All bytes of a text file, unpacked; bounded, whatever a packed file claims."""
    if size > MOST_BYTES:
        raise DiagnosisError([_too_large(path)])
    with gzip.open(path, "rb") if extension(path) == ".csv.gz" else open(path, "rb") as file:
        data: bytes = file.read(MOST_BYTES + 1)
    if len(data) > MOST_BYTES:
        raise DiagnosisError([_too_large(path)])
    if not data:
        raise DiagnosisError([_nothing(path, "E103", "the recording is empty", "there are no bytes in it")])
    if b"\0" in data:
        line = data.count(b"\n", 0, data.index(b"\0")) + 1
        raise _unreadable(
            path, f"line {line} holds a null character: this is no text", "give it the extension of what it is"
        )
    if not data.isascii():
        try:
            data.decode("utf-8")
        except UnicodeDecodeError as error:
            line = data.count(b"\n", 0, error.start) + 1
            raise _unreadable(
                path,
                f"line {line} holds the byte 0x{data[error.start]:02x}, which is not UTF-8 text",
                "save the file as UTF-8 text, or give it the extension of what it is",
            ) from None
    return data


def _unreadable(path: str, cause: str, remedy: str, line: int = 0, text: str | None = None) -> DiagnosisError:
    where = Position(path, line, 1) if line else None
    head = "the recording cannot be read" if line else f"{path}: the recording cannot be read"
    return DiagnosisError([Diagnosis("E501", head, where, cause, remedy, source_line=text)])


def _nothing(path: str, code: str, message: str, cause: str) -> Diagnosis:
    return Diagnosis(
        code, message, Position(path, 1, 1), cause, "give a header line with the names, and a row for each frame"
    )


def _too_large(path: str) -> Diagnosis:
    return Diagnosis(
        "E110",
        "the recording is too large",
        Position(path, 1, 1),
        f"it holds more than {MOST_BYTES // 2**20} MiB",
        "split it, or leave out columns that the sheet does not need",
    )


@dataclass(slots=True)
class _Lines:
    """The lines of a file as text, kept for messages while their rows are at work."""

    file: IO[bytes]
    kept: list[str] = field(default_factory=list)
    first: int = 1
    """The number of the first line that is kept."""
    strange: bool = False
    """Whether a line since the last :meth:`forget` holds what ``float`` reads and we do not: ``1_000``."""

    def __iter__(self) -> Iterator[str]:
        for raw in self.file:
            text = raw.decode("utf-8-sig" if self.first + len(self.kept) == 1 else "utf-8")
            if not text.isascii() or "_" in text:
                self.strange = True
            self.kept.append(text)
            yield text

    def forget(self) -> None:
        """Drop the lines of the rows that are done."""
        self.first += len(self.kept)
        self.kept.clear()
        self.strange = False

    def line(self, number: int) -> str:
        """The text of a line that is kept."""
        index = number - self.first
        return self.kept[index].rstrip("\r\n") if 0 <= index < len(self.kept) else ""


@dataclass(slots=True)
class _Reader:
    """Reads one CSV file; collects mistakes."""

    path: str
    content: bytes
    flags: frozenset[str]
    mistakes: list[Diagnosis] = field(default_factory=list)
    further: int = 0

    def read(self, choose: Chooser) -> Table:
        file = io.BytesIO(self.content)
        lines = _Lines(file)
        reader = csv.reader(iter(lines), strict=True)
        try:
            names = self._header(reader)
            chosen = choose(names)
            problems = [d for d in chosen if isinstance(d, Diagnosis)]
            self.mistakes += problems
            wanted = [name for name in chosen if isinstance(name, str)]
            self._no_duplicates(names, wanted, lines)
            lines.forget()
            places = [(names.index(name), name) for name in wanted]
            quick = None if self.mistakes else self._quick(file.tell(), len(names), places)
            if quick is not None:
                return Table(tuple(wanted), quick, len(quick[0]) if quick else 0)
            chunks = list(self._chunks(reader, lines, names, places))
        except csv.Error as error:
            number = max(1, reader.line_num)
            raise _unreadable(
                self.path,
                f"{error}: a quote is opened or closed in the wrong place, or a cell is enormous",
                "mend the line; a quote inside a quoted cell is written twice",
                number,
                lines.line(number) or None,
            ) from None
        rows = sum(count for count, _ in chunks)
        if not rows and not self.mistakes:
            self.mistakes.append(_nothing(self.path, "E504", "the recording has no rows", "there is only a header"))
        self._raise()
        columns = tuple(np.concatenate([part[i] for _, part in chunks]) for i in range(len(places)))
        return Table(tuple(wanted), columns, rows)

    def _quick(self, start: int, width: int, places: Sequence[tuple[int, str]]) -> tuple[np.ndarray, ...] | None:
        """The columns if all is well: only numbers, no cell empty; else None, and the careful way finds out."""
        file = io.BytesIO(self.content)
        file.seek(start)
        ends = self.content.count(b"\n", start) + (not self.content.endswith(b"\n"))
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")  # that there are no rows is diagnosed elsewhere
                table = np.loadtxt(file, delimiter=",", comments=None, quotechar='"', ndmin=2, encoding="utf-8")
        except ValueError:
            return None
        if table.shape != (ends, width) or not ends:
            return None
        columns = tuple(np.ascontiguousarray(table[:, place]) for place, _ in places)
        fine = all(_is_flag(c) for c, (_, name) in zip(columns, places, strict=True) if name in self.flags)
        return columns if fine and columns else None

    def _header(self, reader: Any) -> list[str]:
        for row in reader:
            if any(cell.strip() for cell in row):
                return [cell.strip() for cell in row]
        raise DiagnosisError([_nothing(self.path, "E103", "the recording is empty", "the file has blank lines only")])

    def _no_duplicates(self, names: Sequence[str], wanted: Sequence[str], lines: _Lines) -> None:
        for name in dict.fromkeys(wanted):
            places = [i for i, other in enumerate(names) if other == name]
            for number, place in enumerate(places[1:], start=2):
                line = lines.first + len(lines.kept) - 1
                text = lines.line(line)
                start, length = _cell_at(text, place)
                self.mistakes.append(
                    Diagnosis(
                        "E506",
                        f"column `{name or '(no name)'}` is there {len(places)} times",
                        Position(self.path, line, start, length),
                        f"column {place + 1} has the name of column {places[0] + 1}",
                        "rename or drop one of them",
                        "" if len(places) == 2 else f"number {number}",
                        source_line=text,
                    )
                )

    def _chunks(
        self, reader: Any, lines: _Lines, names: Sequence[str], places: Sequence[tuple[int, str]]
    ) -> Iterator[tuple[int, list[np.ndarray]]]:
        """Rows in numbers, up to the end of the file; blank lines at the end are no rows."""
        count, blank = 0, 0
        ended = False
        while not ended:
            rows: list[list[str]] = []
            ends: list[int] = []
            for row in reader:
                rows.append(row)
                ends.append(reader.line_num)
                if len(rows) == ROWS:
                    break
            ended = len(rows) < ROWS
            if blank and any(rows):
                self._note_blank(lines.first, blank, names)
                blank = 0
            while rows and not rows[-1]:
                rows.pop()
                ends.pop()
                blank += 1
            if rows:
                yield len(rows), self._numbers(rows, ends, count, lines, names, places)
                count += len(rows)
            lines.forget()

    def _note_blank(self, line: int, blank: int, names: Sequence[str]) -> None:
        self._add(
            "E505",
            f"{blank} empty {'line' if blank == 1 else 'lines'} between rows",
            Position(self.path, line - 1, 1),
            f"every row has {len(names)} {'cell' if len(names) == 1 else 'cells'}",
            "drop the empty lines; a missing sample is an empty cell",
        )

    def _numbers(
        self,
        rows: list[list[str]],
        ends: list[int],
        before: int,
        lines: _Lines,
        names: Sequence[str],
        places: Sequence[tuple[int, str]],
    ) -> list[np.ndarray]:
        width = len(names)
        if any(len(row) != width for row in rows):
            fine = []
            for i, row in enumerate(rows):
                if len(row) == width:
                    fine.append(i)
                else:
                    self._wrong_length(row, ends[i], before + i + 1, lines, width)
            rows, ends = [rows[i] for i in fine], [ends[i] for i in fine]
        cells = list(zip(*rows, strict=True)) if rows else [()] * width
        return [self._column(cells[k], k, name, ends, before, lines) for k, name in places]

    def _column(
        self, cells: Sequence[str], place: int, name: str, ends: list[int], before: int, lines: _Lines
    ) -> np.ndarray:
        if not lines.strange:
            try:
                column = np.fromiter(map(float, cells), np.float64, len(cells))
                if name not in self.flags or _is_flag(column):
                    return column
            except ValueError:
                pass
        column = np.full(len(cells), np.nan)
        for i, cell in enumerate(cells):
            text = cell.strip()
            if not text:
                continue
            if NUMBER.fullmatch(text) is None:
                self._no_number(cell, place, name, ends[i], before + i + 1, lines, "a number")
                continue
            column[i] = float(text)
            if name in self.flags and column[i] not in (0.0, 1.0) and np.isfinite(column[i]):
                self._no_number(cell, place, name, ends[i], before + i + 1, lines, "0 or 1")
        return column

    def _wrong_length(self, row: list[str], line: int, number: int, lines: _Lines, width: int) -> None:
        text = lines.line(line)
        start, length = _cell_at(text, width) if len(row) > width else (max(1, len(text)), 1)
        cells = "1 cell" if len(row) == 1 else f"{len(row)} cells"
        self._add(
            "E505",
            f"row {number} has {cells if row else 'no cells'}, the header {width}",
            Position(self.path, line, start, length),
            "every row has one cell for each name of the header",
            "drop the line, or fill in the cells; a missing sample is an empty cell" if len(row) < width
            else "drop what is too much; numbers are written with a point, as 1.5",
            text,
        )  # fmt: skip

    def _no_number(self, cell: str, place: int, name: str, line: int, number: int, lines: _Lines, wanted: str) -> None:
        text = lines.line(line)
        start, length = _cell_at(text, place)
        shown = cell.strip() if len(cell) <= 40 else cell.strip()[:37] + "..."
        self._add(
            "E503",
            f"`{shown}` in row {number} of column `{name}` is not {wanted}",
            Position(self.path, line, start, length),
            "the column is a boolean input: 0 or 1" if wanted == "0 or 1" else "a cell is a number such as -1.5e-3",
            "correct the cell; a missing sample is an empty cell or nan",
            text,
        )

    def _add(
        self, code: str, message: str, position: Position, cause: str, remedy: str, text: str | None = None
    ) -> None:
        if len(self.mistakes) < MOST_SHOWN:
            self.mistakes.append(Diagnosis(code, message, position, cause, remedy, source_line=text))
        else:
            self.further += 1

    def _raise(self) -> None:
        if self.further:
            self.mistakes.append(
                Diagnosis(
                    self.mistakes[-1].code,
                    f"{self.path}: {self.further} further mistakes are not shown",
                    cause=f"the first {MOST_SHOWN} stand above",
                    remedy="correct those first; often one cause explains all",
                )
            )
        if self.mistakes:
            raise DiagnosisError(self.mistakes)


def _is_flag(column: np.ndarray) -> bool:
    """Only 0, 1 and missing samples."""
    return bool(((column == 0) | (column == 1) | ~np.isfinite(column)).all())


def _cell_at(text: str, place: int) -> tuple[int, int]:
    """Column (from 1) and length of a cell in a line of CSV."""
    start, quoted, seen = 0, False, 0
    for i, mark in enumerate(text):
        if mark == '"':
            quoted = not quoted
        elif mark == "," and not quoted:
            if seen == place:
                return start + 1, max(1, i - start)
            seen += 1
            start = i + 1
    return start + 1, max(1, len(text) - start)


# -- Parquet


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


def _read_parquet(path: str, choose: Chooser, flags: frozenset[str]) -> Table:
    pyarrow = need_pyarrow(path)
    try:
        with pyarrow.parquet.ParquetFile(path) as file:
            names = list(file.schema_arrow.names)
            chosen = choose(names)
            mistakes = [d for d in chosen if isinstance(d, Diagnosis)]
            wanted = [name for name in chosen if isinstance(name, str)]
            rows = file.metadata.num_rows
            mistakes += _parquet_mistakes(path, pyarrow, file.schema_arrow, wanted)
            if rows * max(1, len(wanted)) * 8 > MOST_BYTES:
                mistakes.append(_too_large(path))
            if not rows and not mistakes:
                mistakes.append(_nothing(path, "E504", "the recording has no rows", "the file has columns only"))
            if mistakes:
                raise DiagnosisError(mistakes)
            table = file.read(columns=wanted)
        columns = tuple(_parquet_column(table.column(name), pyarrow) for name in wanted)
    except pyarrow.ArrowException as error:
        raise _unreadable(path, f"it is not a Parquet file: {str(error).splitlines()[0]}", "write it again") from None
    mistakes = []
    for name, column in zip(wanted, columns, strict=True):
        if name in flags:
            odd = np.flatnonzero((column != 0) & (column != 1) & np.isfinite(column))
            mistakes += [_parquet_flag(path, name, wanted.index(name), int(i), column[i]) for i in odd[:MOST_SHOWN]]
    if mistakes:
        raise DiagnosisError(mistakes[:MOST_SHOWN])
    return Table(tuple(wanted), columns, rows)


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
    return np.asarray(column.to_numpy(), dtype=np.float64)  # null comes out as NaN


def _parquet_flag(path: str, name: str, place: int, row: int, value: float) -> Diagnosis:
    return Diagnosis(
        "E503",
        f"`{value:g}` in row {row + 1} of column `{name}` is not 0 or 1",
        Position(path, row + 1, place + 1),
        "the column is a boolean input: 0 or 1",
        "correct the cell; a missing sample is null or NaN",
    )
