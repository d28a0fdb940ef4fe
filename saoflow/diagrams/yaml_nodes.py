"""The nodes of a YAML text with their places, and the text itself, which collects what is wrong in it."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, final

from saoflow.diagnosis import Diagnosis, Note, Position

LINE_BREAK = re.compile("\r\n|[\r\n\x85\u2028\u2029]")
"""Where YAML ends a line."""
_LONGEST_ALIGNED = 20_000
"""Characters of a scalar up to which places inside it are looked for."""
_FARTHEST = 1000
"""Characters of indentation and escapes that are skipped between two characters of a value."""
_ESCAPES = dict(zip('0abtnvfre"/\\N_LP ', '\0\a\b\t\n\v\f\r\x1b"/\\\x85\xa0\u2028\u2029 ', strict=True))
_PROPERTIES = re.compile(r"(?:[&!]\S*\s+)+")
"""Anchors and tags before a value."""
_ESCAPE = re.compile(r"\\(?:x([0-9a-fA-F]{2})|u([0-9a-fA-F]{4})|U([0-9a-fA-F]{8})|.)")


@final
class Scalar:
    """A word or text as written, without the quotes."""

    __slots__ = ("column", "end_column", "end_line", "line", "plain", "value")

    def __init__(self, value: str, plain: bool, start: Any, end: Any) -> None:
        self.value, self.plain = value, plain
        self.line, self.column = start.line, start.column
        self.end_line, self.end_column = end.line, end.column

    @property
    def nothing(self) -> bool:
        """Whether it stands for no value: empty, ``~`` or ``null`` without quotes."""
        return self.plain and self.value in ("", "~", "null")


@final
class Sequence:
    """A list of nodes."""

    __slots__ = ("column", "end_column", "end_line", "height", "items", "line", "size")

    def __init__(self, start: Any) -> None:
        self.items: list[Node] = []
        self.line, self.column = start.line, start.column
        self.end_line, self.end_column = self.line, self.column
        self.height = 1
        self.size = 0
        """Nodes in it, aliases followed; known when it is complete, 0 before."""


@final
class Mapping:
    """Keys with their values in the order of the text; each key once."""

    __slots__ = ("column", "end_column", "end_line", "entries", "height", "key", "keys", "line", "size")

    def __init__(self, start: Any) -> None:
        self.entries: list[tuple[Scalar, Node]] = []
        self.keys: dict[str, Scalar] = {}
        self.key: Node | None = None
        """A key whose value has not come yet."""
        self.line, self.column = start.line, start.column
        self.end_line, self.end_column = self.line, self.column
        self.height = 1
        self.size = 0


Node = Scalar | Sequence | Mapping


@dataclass(slots=True)
class SourceText:
    """A file's text, its lines, and the diagnoses found in it."""

    file: str
    text: str
    lines: tuple[str, ...] = ()
    found: list[Diagnosis] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.lines = tuple(LINE_BREAK.split(self.text))

    def line(self, number: int) -> str | None:
        """The text of a line by its number from 1, None outside the file."""
        return self.lines[number - 1] if 0 < number <= len(self.lines) else None

    def report(
        self,
        code: str,
        message: str,
        position: Position | None,
        *,
        cause: str = "",
        remedy: str = "",
        label: str = "",
        notes: tuple[Note, ...] = (),
    ) -> None:
        """Remember a diagnosis, with the line it is about."""
        line = (self.line(position.line) if position else None) or None
        if code == "E104" and line is not None:
            line = _visible(line)
        message, cause, remedy = _visible(message), _visible(cause), _visible(remedy)
        self.found.append(Diagnosis(code, message, position, cause, remedy, label, notes, line))

    def position(self, node: Node) -> Position:
        """Where a node stands: with its quotes or brackets; one of several lines by its first line or character."""
        length = node.end_column - node.column if node.end_line == node.line else 0
        if length <= 0:
            line = self.line(node.line + 1) or ""
            length = len(line.rstrip()) - node.column if isinstance(node, Scalar) else 1
        return Position(self.file, node.line + 1, node.column + 1, max(1, length))

    def at_mark(self, mark: Any) -> Position | None:
        """The place of a mark of PyYAML."""
        return Position(self.file, mark.line + 1, mark.column + 1) if mark is not None else None

    def locator(self, node: Scalar) -> Callable[[int, int], Position]:
        """From an offset in a scalar's value and a length to the place in the file.

        Exact on one line, plain or quoted without escapes; for text over several lines or with escapes, each
        character that can be found again in order.
        """
        file, quotes = self.file, 0 if node.plain else 1
        if node.line == node.end_line and node.end_column - node.column == len(node.value) + 2 * quotes:
            line, column = node.line + 1, node.column + 1 + quotes
            return lambda offset, length: Position(file, line, column + offset, length)
        places: list[tuple[int, int]] = []

        def locate(offset: int, length: int) -> Position:
            if not places:  # only where a place is asked for
                places.extend(self._align(node))
            line, column = places[min(offset, len(places) - 1)]
            return Position(file, line, column, length)

        return locate

    def _align(self, node: Scalar) -> list[tuple[int, int]]:
        """The line and column (from 1) of each character of a scalar, and of its end, found by walking the text."""
        if len(node.value) > _LONGEST_ALIGNED:
            return [(node.line + 1, node.column + 1)]
        atoms = self._atoms(node)
        places: list[tuple[int, int]] = []
        at = 0
        for character in node.value:
            found, end = at, min(at + _FARTHEST, len(atoms))
            while found < end and atoms[found][0] != character and not character.isspace():
                found += 1
            if found < end:  # spaces need not be found: line ends become spaces
                at = found
            places.append(atoms[min(at, len(atoms) - 1)][1:])
            if not character.isspace() or (at < len(atoms) and atoms[at][0].isspace()):
                at += 1
        places.append(atoms[at][1:] if at < len(atoms) else (atoms[-1][1], atoms[-1][2] + 1))
        return places

    def _atoms(self, node: Scalar) -> list[tuple[str, int, int]]:
        """The characters of a scalar in the text with line and column; an escape is one character. Never empty."""
        first = self.line(node.line + 1) or ""
        column = node.column
        if (properties := _PROPERTIES.match(first, column)) is not None:
            column = properties.end()
        quote = first[column : column + 1] if not node.plain else ""
        start = (node.line + 1, 0) if quote in ("|", ">") and quote else (node.line, column + len(quote))
        atoms: list[tuple[str, int, int]] = []
        for row in range(start[0], min(node.end_line + 1, len(self.lines))):
            line = self.lines[row]
            column = start[1] if row == start[0] else 0
            stop = node.end_column if row == node.end_line else len(line)
            while column < stop:
                escape = _ESCAPE.match(line, column) if quote == '"' else None
                if escape is not None:
                    digits = escape.group(1) or escape.group(2) or escape.group(3)
                    letter = escape.group()[1:]
                    character = chr(min(int(digits, 16), 0x10FFFF)) if digits else _ESCAPES.get(letter, letter)
                    atoms.append((character, row + 1, column + 1))
                    column = escape.end()
                else:
                    atoms.append((line[column], row + 1, column + 1))
                    column += 1
        return atoms or [("", node.line + 1, node.column + 1)]


def _visible(text: str) -> str:
    """Without characters that would act on a terminal instead of being shown."""
    return text if text.isprintable() else "".join(c if c.isprintable() else "\ufffd" for c in text)


def short(text: str, limit: int = 64) -> str:
    """Text for a message: on one line, and cut if it is long."""
    text = " ".join(text.split())
    return text if len(text) <= limit else text[: limit - 3] + "..."
