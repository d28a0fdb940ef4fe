"""Reading the columns of CSV files (other kinds are passed on), quickly when all is well, and with the place of every mistake when not."""

from __future__ import annotations

import csv
import gzip
import io
import os
import re
import warnings
import zlib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import IO, Any

import numpy as np

from saoflow import recording_table
from saoflow.diagnosis import Diagnosis, DiagnosisError, Position
from saoflow.recording_table import EXTENSIONS, MOST_SHOWN, Chooser, Table, extension, nothing_in, too_large, unreadable

ROWS = 8192
"""Rows that are turned into numbers together."""

NUMBER = re.compile(r"[+-]?(\d+\.?\d*([eE][+-]?\d+)?|\.\d+([eE][+-]?\d+)?|inf(inity)?|nan)", re.IGNORECASE | re.ASCII)


def read_columns(path: str, choose: Chooser, flags: frozenset[str] = frozenset()) -> Table:
    """The chosen columns of a file; those in ``flags`` hold 0 and 1. Raises DiagnosisError with all that is found."""
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
        if extension(path) == ".parquet":
            from saoflow.recording_parquet import read_parquet

            return read_parquet(path, choose, flags)
        return _Reader(path, _content(path, size), flags).read(choose)
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


def _content(path: str, size: int) -> bytes:
    """All bytes of a text file, unpacked; bounded, whatever a packed file claims."""
    if size > recording_table.MOST_BYTES:
        raise DiagnosisError([too_large(path)])
    with gzip.open(path, "rb") if extension(path) == ".csv.gz" else open(path, "rb") as file:
        data: bytes = file.read(recording_table.MOST_BYTES + 1)
    if len(data) > recording_table.MOST_BYTES:
        raise DiagnosisError([too_large(path)])
    if not data:
        raise DiagnosisError([nothing_in(path, "E103", "the recording is empty", "there are no bytes in it")])
    if b"\0" in data:
        line = data.count(b"\n", 0, data.index(b"\0")) + 1
        raise unreadable(
            path, f"line {line} holds a null character: this is no text", "give it the extension of what it is"
        )
    if not data.isascii():
        try:
            data.decode("utf-8")
        except UnicodeDecodeError as error:
            line = data.count(b"\n", 0, error.start) + 1
            raise unreadable(
                path,
                f"line {line} holds the byte 0x{data[error.start]:02x}, which is not UTF-8 text",
                "save the file as UTF-8 text, or give it the extension of what it is",
            ) from None
    return data


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
            raise unreadable(
                self.path,
                f"{error}: a quote is opened or closed in the wrong place, or a cell is enormous",
                "mend the line; a quote inside a quoted cell is written twice",
                number,
                lines.line(number) or None,
            ) from None
        rows = sum(count for count, _ in chunks)
        if not rows and not self.mistakes:
            self.mistakes.append(nothing_in(self.path, "E504", "the recording has no rows", "there is only a header"))
        self._raise()
        columns = tuple(np.concatenate([part[i] for _, part in chunks]) for i in range(len(places)))
        return Table(tuple(wanted), columns, rows)

    def _quick(self, start: int, width: int, places: Sequence[tuple[int, str]]) -> tuple[np.ndarray, ...] | None:
        """The columns if all is well: only numbers, no cell empty; else None, and the careful way finds out."""
        if self.content.find(b'"', start) >= 0:
            return None
        file = io.BytesIO(self.content)
        file.seek(start)
        ends = self.content.count(b"\n", start) + (not self.content.endswith(b"\n"))
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")  # that there are no rows is diagnosed elsewhere
                table = np.loadtxt(file, delimiter=",", comments=None, ndmin=2, encoding="utf-8")
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
        raise DiagnosisError([nothing_in(self.path, "E103", "the recording is empty", "the file has blank lines only")])

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
        wanted = "0 or 1" if name in self.flags else "a number"
        for i, cell in enumerate(cells):
            text = cell.strip()
            if not text:
                continue
            if NUMBER.fullmatch(text) is None:
                self._no_number(cell, place, name, ends[i], before + i + 1, lines, wanted)
                continue
            column[i] = float(text)
            if name in self.flags and column[i] not in (0.0, 1.0) and np.isfinite(column[i]):
                self._no_number(cell, place, name, ends[i], before + i + 1, lines, wanted)
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
