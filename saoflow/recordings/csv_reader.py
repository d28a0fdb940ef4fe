"""Reading the columns of CSV files in parts, quickly when all is well, and with the place of every mistake when not."""

from __future__ import annotations

import csv
import io
import re
import warnings
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from saoflow.diagnosis import Diagnosis, DiagnosisError, Position, in_order
from saoflow.recordings.table import MOST_SHOWN, Chooser, Part, Table, nothing_in, unreadable
from saoflow.recordings.text import Lines, Text

ROWS = 8192
"""Rows that are turned into numbers together, where that is not quick."""
LOOK_ON = 32
"""Blocks that are looked through for more mistakes, from the first mistake on; one if the header is wrong."""

NUMBER = re.compile(r"[+-]?(\d+\.?\d*([eE][+-]?\d+)?|\.\d+([eE][+-]?\d+)?|inf(inity)?|nan)", re.IGNORECASE | re.ASCII)


def csv_parts(path: str, choose: Chooser, flags: frozenset[str]) -> Iterator[Part]:
    """The chosen columns, a block of the file at a time; those in ``flags`` hold 0 and 1.

    Nothing comes after the first mistake; the rest of the file is looked through for more. Raises DiagnosisError at
    the end, with all that is found, and OSError.
    """
    text = Text(path)
    try:
        yield from _Reader(path, text, flags).parts(choose)
    finally:
        text.close()


class _Reader:
    """Reads one CSV file; collects mistakes."""

    def __init__(self, path: str, text: Text, flags: frozenset[str]) -> None:
        self.path = path
        self.text = text
        self.lines = Lines(text)
        self.flags = flags
        self.mistakes: list[Diagnosis] = []
        self.in_header = 0
        """How many of the mistakes are of the header: they are told first."""
        self.further = 0
        self.rows = 0
        self.blank = 0
        """Empty lines before the line that comes next."""

    def parts(self, choose: Chooser) -> Iterator[Part]:
        names = self._header()
        chosen = choose(names)
        wanted = [name for name in chosen if isinstance(name, str)]
        self.mistakes += [d for d in chosen if isinstance(d, Diagnosis)]
        self._no_duplicates(names, wanted, self.lines)
        places = [(names.index(name), name) for name in wanted]
        self.in_header = len(self.mistakes)
        look_on = 1 if self.mistakes else LOOK_ON
        while look_on and self.text.more():
            for count, columns in self._block(names, places):
                self.rows += count
                if not self.mistakes:
                    yield Part(Table(tuple(wanted), columns, count), self.text.share)
            look_on -= bool(self.mistakes)
        if not self.rows and not self.mistakes:
            self.mistakes.append(nothing_in(self.path, "E504", "the recording has no rows", "there is only a header"))
        self._raise()

    def _block(
        self, names: Sequence[str], places: Sequence[tuple[int, str]]
    ) -> Iterator[tuple[int, tuple[np.ndarray, ...]]]:
        """The rows of what is left of the block, in numbers."""
        quick = self._quick(self.text.rest(), len(names), places)
        if quick is None:
            yield from self._rows(names, places)
            return
        if self.blank:
            self._note_blank(self.text.line, len(names))
        self.text.skip()
        yield quick

    def _quick(
        self, block: bytes, width: int, places: Sequence[tuple[int, str]]
    ) -> tuple[int, tuple[np.ndarray, ...]] | None:
        """Rows and columns if all is well: only numbers, no cell empty; else None, and the careful way finds out."""
        if b'"' in block:
            return None
        ends = block.count(b"\n") + (not block.endswith(b"\n"))
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")  # that there are no rows is diagnosed elsewhere
                table = np.loadtxt(io.BytesIO(block), delimiter=",", comments=None, ndmin=2, encoding="utf-8")
        except ValueError:
            return None
        if table.shape != (ends, width) or not ends:
            return None
        columns = tuple(np.ascontiguousarray(table[:, place]) for place, _ in places)
        fine = all(_is_flag(c) for c, (_, name) in zip(columns, places, strict=True) if name in self.flags)
        return (ends, columns) if fine else None

    def _header(self) -> list[str]:
        reader = csv.reader(iter(self.lines), strict=True)
        while (row := self._next_row(reader, 0)) is not None:
            if any(cell.strip() for cell in row):
                return [cell.strip() for cell in row]
        raise DiagnosisError([nothing_in(self.path, "E103", "the recording is empty", "the file has blank lines only")])

    def _no_duplicates(self, names: Sequence[str], wanted: Sequence[str], lines: Lines) -> None:
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

    def _rows(
        self, names: Sequence[str], places: Sequence[tuple[int, str]]
    ) -> Iterator[tuple[int, tuple[np.ndarray, ...]]]:
        """Row by row to the end of the block, or of the row that goes beyond it; empty lines at the end are no rows."""
        lines = self.lines
        lines.forget()
        before = lines.first - 1
        reader = csv.reader(iter(lines), strict=True)
        while self.text.left:
            rows: list[list[str]] = []
            ends: list[int] = []
            while self.text.left and len(rows) < ROWS:
                row = self._next_row(reader, before)
                rows.append(row or [])
                ends.append(before + reader.line_num)
            if self.blank and any(rows):
                self._note_blank(lines.first, len(names))
            while rows and not rows[-1]:
                rows.pop()
                ends.pop()
                self.blank += 1
            if rows:
                yield len(rows), self._numbers(rows, ends, lines, len(names), places)
            lines.forget()

    def _next_row(self, reader: Any, before: int) -> list[str] | None:
        """One row, or None at the end. ``before``: lines of the file before the reader's first."""
        try:
            return next(reader, None)
        except csv.Error as error:
            number = before + max(1, reader.line_num)
            cause = f"{error}: a quote is opened or closed in the wrong place, or a cell is enormous"
            remedy = "mend the line; a quote inside a quoted cell is written twice"
            if "new-line character" in str(error):
                cause = "a carriage return stands inside a line: the lines end as on an old Macintosh, or are broken"
                remedy = "save the file with line feeds, or CR LF"
            told = unreadable(
                self.path,
                cause,
                remedy,
                number,
                self.lines.line(number) or None,
            )
            raise DiagnosisError([*self.mistakes, *told.diagnoses]) from None

    def _note_blank(self, line: int, width: int) -> None:
        """Empty lines, and then a row in ``line``."""
        blank, self.blank = self.blank, 0
        self._add(
            "E505",
            f"{blank} empty {'line' if blank == 1 else 'lines'} between rows",
            Position(self.path, line - 1, 1),
            f"every row has {width} {'cell' if width == 1 else 'cells'}",
            "drop the empty lines; a missing sample is an empty cell",
        )

    def _numbers(
        self,
        rows: list[list[str]],
        ends: list[int],
        lines: Lines,
        width: int,
        places: Sequence[tuple[int, str]],
    ) -> tuple[np.ndarray, ...]:
        before = self.rows
        if any(len(row) != width for row in rows):
            fine = []
            for i, row in enumerate(rows):
                if len(row) == width:
                    fine.append(i)
                else:
                    self._wrong_length(row, ends[i], before + i + 1, lines, width)
            rows, ends = [rows[i] for i in fine], [ends[i] for i in fine]
        cells = list(zip(*rows, strict=True)) if rows else [()] * width
        return tuple(self._column(cells[k], k, name, ends, before, lines) for k, name in places)

    def _column(
        self, cells: Sequence[str], place: int, name: str, ends: list[int], before: int, lines: Lines
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

    def _wrong_length(self, row: list[str], line: int, number: int, lines: Lines, width: int) -> None:
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

    def _no_number(self, cell: str, place: int, name: str, line: int, number: int, lines: Lines, wanted: str) -> None:
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
        if self.mistakes and self.text.more():
            self.mistakes.append(
                Diagnosis(
                    self.mistakes[0].code,
                    f"{self.path}: nothing from line {self.text.line} on was looked at",
                    cause="the recording is long, and cannot be run as it is",
                    remedy="correct what stands above first",
                )
            )
        if self.mistakes:
            header, cells = self.mistakes[: self.in_header], self.mistakes[self.in_header :]
            raise DiagnosisError([*header, *in_order(cells)])


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
