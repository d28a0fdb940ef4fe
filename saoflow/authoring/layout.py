"""How a formatted YAML file looks: keys in their order, two blanks a level, one line for what is short, comments kept.

What a person has chosen stays: quotes, blank lines (one at a time), flow or block style where it fits, the columns of
trailing comments. A line is broken only if it is longer than :data:`LONGEST`; it is then filled up to :data:`WIDTH`. Flow
mappings under ``parameters``, ``inputs`` and ``outputs`` are never broken: together they read as a table.
"""

from __future__ import annotations

import re
import textwrap
from dataclasses import dataclass, field

from saoflow.diagrams.yaml_text import Mapping, Node, Scalar, Sequence, SourceText

WIDTH = 120
LONGEST = 130
"""A line a little too long reads better than a broken one."""
ROOT = ("campaign", "sheet", "doc", "equations", "profile", "parameters_of", "parameters", "inputs", "blocks", "outputs", "budget")
"""The order of a sheet's keys; a campaign's others follow in their own order."""
ENTRIES = {
    "parameters": ("value", "inherited", "unit", "range", "doc", "source"),
    "inputs": ("shape", "type", "unit", "doc"),
    "outputs": ("from", "unit", "doc"),
}
"""The order of the keys of one entry, by the root key that it stands under."""
_HEADER = re.compile(r"([|>])([-+]?)([1-9]?)([-+]?)$")


@dataclass(slots=True)
class _Line:
    """A line of the result; ``column`` is where its trailing comment was."""

    text: str
    comment: str = ""
    column: int = 0


@dataclass(slots=True)
class _Comment:
    line: int
    column: int
    text: str
    own: bool
    """Whether it has a line of its own."""


@dataclass(slots=True)
class Layout:
    """Lays out one file. Line numbers count from 0 here."""

    source: SourceText
    lines: list[_Line] = field(default_factory=list)
    comments: list[_Comment] = field(default_factory=list)
    levels: list[tuple[int, int]] = field(default_factory=list)
    """Column in the text and in the result of every open mapping, and of those that were open in the entry before."""
    at: int = 0
    """The first line of the text that has not been laid out."""

    def text(self, root: Mapping) -> str:
        """The whole file, laid out anew."""
        self.comments = list(_comments(self.source, root))
        chunks: list[tuple[str, list[_Line]]] = []
        self._root(root, chunks)
        self.lines = []
        self._pending(len(self.source.lines))
        tail = self.lines
        while tail and not (tail[-1].text or tail[-1].comment):
            tail.pop()
        head = _head(chunks[0][1]) if chunks else []
        if chunks:
            chunks[0][1][: len(head)] = []
        chunks.sort(key=lambda chunk: ROOT.index(chunk[0]) if chunk[0] in ROOT else len(ROOT))
        while chunks and chunks[0][1] and not chunks[0][1][0].text:
            chunks[0][1].pop(0)
        for _, chunk in chunks:
            _align(chunk)
        everything = [*head, *(line for _, chunk in chunks for line in chunk), *tail]
        return "\n".join(_joined(line) for line in everything) + "\n"

    def _root(self, root: Mapping, chunks: list[tuple[str, list[_Line]]]) -> None:
        self.levels = [(root.column, 0)]
        for key, value in root.entries:
            self.lines = []
            self._entry(key, value, 0, 0, (key.value,))
            chunks.append((key.value, self.lines))

    # -- entries

    def _mapping(self, node: Mapping, indent: int, path: tuple[str, ...]) -> None:
        depth = len(self.levels)
        self.levels.append((node.column, indent))
        for key, value in node.entries:
            self._entry(key, value, indent, depth, (*path, key.value))

    def _entry(self, key: Scalar, value: Node, indent: int, depth: int, path: tuple[str, ...]) -> None:
        self._pending(key.line)
        del self.levels[depth + 1 :]
        start = f"{' ' * indent}{self._raw(key)}:"
        self._value(start, key, value, indent, path)

    def _value(self, start: str, before: Node, value: Node, indent: int, path: tuple[str, ...]) -> None:
        """``start``, which is a key or a dash, with its value behind or below it."""
        if type(value) is Scalar:
            self._scalar(start, before, value, indent)
        elif self._is_flow(value):
            self._flow(start, before, value, indent, path)
        elif type(value) is Mapping:
            self._add(start, before.line)
            self._mapping(value, indent + 2, path)
        elif type(value) is Sequence:
            self._add(start, before.line)
            depth = len(self.levels)
            self.levels.append((value.column, indent + 2))
            for item in value.items:
                self._item(item, depth, indent + 2, path)

    def _item(self, item: Node, depth: int, indent: int, path: tuple[str, ...]) -> None:
        """An item of a list in block style. A mapping begins beside its dash."""
        self._pending(item.line)
        del self.levels[depth + 1 :]
        if type(item) is Mapping and not self._is_flow(item):
            first = len(self.lines)
            self._mapping(item, indent + 2, path)
            own = next(line for line in self.lines[first:] if line.text)
            own.text = f"{' ' * indent}- {own.text.lstrip()}"
        else:
            self._value(f"{' ' * indent}-", item, item, indent, path)

    def _scalar(self, start: str, before: Node, value: Scalar, indent: int) -> None:
        raw = self._raw(value)
        header, *rest = raw.split("\n")
        if value.plain and not value.value and not raw.strip():
            self._add(start, before.line)
        elif _HEADER.match(header.split(" #")[0].strip()) and not value.plain:
            self._block_scalar(start, header, rest, value, indent)
        else:
            self._add(f"{start} {header.rstrip()}", value.line)
            for number, line in enumerate(rest, start=value.line + 1):
                self._add(f"{' ' * (indent + 2)}{line.strip()}" if line.strip() else "", number)
            self.at = value.end_line + 1

    def _block_scalar(self, start: str, header: str, rest: list[str], value: Scalar, indent: int) -> None:
        """Text below ``|`` or ``>``; folded text is filled anew if one of its lines is too long."""
        body = [line if line.strip() else "" for line in rest]  # blanks at the end of a line are part of the text
        while body and not body[-1]:
            body.pop()
        margin = min((len(line) - len(line.lstrip()) for line in body if line), default=0)
        body = [line[margin:] for line in body]
        plain = _HEADER.match(header.strip())
        simple = header.startswith(">") and plain is not None and not plain[3]
        if simple and not any(line != line.strip() for line in body) and any(
            len(line) + indent + 2 > LONGEST for line in body
        ):
            body = _filled(body, WIDTH - indent - 2)
        self._add(f"{start} {header.rstrip()}", value.line)
        self.lines += [_Line(f"{' ' * (indent + 2)}{line}" if line else "") for line in body]
        self.at = value.line + 1 + len([line for line in rest if line.strip()] and body)
        self.at = max(self.at, value.end_line)

    def _flow(self, start: str, before: Node, value: Sequence | Mapping, indent: int, path: tuple[str, ...]) -> None:
        """On one line, if it fits or was so; else over lines as block style if that helps, or as it was."""
        many = value.end_line > value.line
        commented = any(value.line <= c.line < value.end_line for c in self.comments)
        below = value.line > before.end_line
        if commented or not self._regular(value):
            self._verbatim(start, value, indent)
            return
        if below:  # the value of a long key stands below it
            self._add(start, before.line)
            start = " " * (indent + 1)
        whole = f"{start} {self._rendered(value, path)}"
        if len(whole) <= (WIDTH if many else LONGEST) or (path[0] in ENTRIES and not many):
            self._add(whole, value.end_line)
            return
        parts = []
        if type(value) is Mapping and path[0] not in ENTRIES and not below and not start.endswith("-"):
            for key, part in value.entries:
                text = f"{' ' * (indent + 2)}{self._raw(key)}: {self._rendered(part, (*path, key.value))}"
                parts.append(_Line(text.rstrip()))
        if parts and all(len(part.text) <= WIDTH for part in parts):
            self._add(start, value.end_line)
            self.lines += parts
        elif many:
            self._verbatim(start, value, indent)
        else:
            self._add(whole, value.end_line)

    def _verbatim(self, start: str, value: Sequence | Mapping, indent: int) -> None:
        """As it was, moved with its key."""
        raw = self._raw(value).split("\n")
        shift = indent - (len(self.source.lines[value.line]) - len(self.source.lines[value.line].lstrip()))
        self._add(f"{start} {raw[0].rstrip()}", value.line if len(raw) == 1 else -1)
        for number, line in enumerate(raw[1:], start=value.line + 1):
            at = max(indent + 1, len(line) - len(line.lstrip()) + shift)
            self._add(f"{' ' * at}{line.strip()}" if line.strip() else "", number if number == value.end_line else -1)
        self.at = value.end_line + 1

    # -- flow style

    def _is_flow(self, node: Node) -> bool:
        return type(node) is not Scalar and bool(self.source.lines[node.line].startswith(("{", "["), node.column))

    def _regular(self, node: Node) -> bool:
        """Whether it can be written on one line: no text over lines, no pair without braces."""
        if type(node) is Scalar:
            return bool(node.line == node.end_line)
        if not self._is_flow(node):
            return False
        if type(node) is Mapping:
            return all(key.line == key.end_line and self._regular(value) for key, value in node.entries)
        return all(map(self._regular, node.items))

    def _rendered(self, node: Node, path: tuple[str, ...]) -> str:
        if type(node) is Mapping:
            entries = list(node.entries)
            if len(path) == 2 and path[0] in ENTRIES:
                order = ENTRIES[path[0]]
                entries.sort(key=lambda entry: order.index(entry[0].value) if entry[0].value in order else len(order))
            return "{" + ", ".join(f"{self._raw(k)}: {self._rendered(v, (*path, k.value))}" for k, v in entries) + "}"
        if type(node) is Sequence:
            return "[" + ", ".join(self._rendered(item, (*path, "")) for item in node.items) + "]"
        return self._raw(node)

    def _raw(self, node: Node) -> str:
        """The text of a node as it stands in the file."""
        lines = self.source.lines[node.line : node.end_line + 1]
        if node.line == node.end_line:
            return lines[0][node.column : node.end_column]
        return "\n".join([lines[0][node.column :], *lines[1:-1], lines[-1][: node.end_column]])

    # -- lines and comments

    def _add(self, text: str, number: int) -> None:
        """A line of the result, with the trailing comment that the text has on a line."""
        found = next((c for c in self.comments if c.line == number and not c.own), None)
        self.lines.append(_Line(text, found.text if found else "", found.column if found else 0))
        self.at = max(self.at, number + 1)

    def _pending(self, line: int) -> None:
        """Blank lines, one at a time, and comments on lines of their own before a line of the text."""
        for number in range(self.at, line):
            own = next((c for c in self.comments if c.line == number and c.own), None)
            if own is not None:
                indent = next((new for old, new in reversed(self.levels) if old <= own.column), 0)
                self.lines.append(_Line(" " * indent + own.text))
            elif not self.source.lines[number].strip() and not (self.lines and not self.lines[-1].text):
                self.lines.append(_Line(""))
        self.at = max(self.at, line)


def _comments(source: SourceText, root: Mapping) -> list[_Comment]:
    """Every comment: what starts with # outside of keys and values."""
    covered: dict[int, list[tuple[int, int]]] = {}
    inside: set[int] = set()
    stack: list[Node] = [root]
    while stack:
        node = stack.pop()
        if type(node) is Mapping:
            stack += [part for entry in node.entries for part in entry]
        elif type(node) is Sequence:
            stack += node.items
        elif node.line == node.end_line:
            covered.setdefault(node.line, []).append((node.column, node.end_column))
        else:
            covered.setdefault(node.line, []).append((node.column, 10**9))
            covered.setdefault(node.end_line, []).append((0, node.end_column))
            inside.update(range(node.line + 1, node.end_line))
    found = []
    for number, line in enumerate(source.lines):
        if number in inside:
            continue
        for match in re.finditer(r"(?<!\S)#", line):
            if not any(start <= match.start() < end for start, end in covered.get(number, ())):
                text = line[match.start() :].rstrip()
                found.append(_Comment(number, match.start(), text, not line[: match.start()].strip()))
                break
    return found


def _head(lines: list[_Line]) -> list[_Line]:
    """The comments at the top of a file, which stay there whatever the order of keys."""
    count = next((i for i, line in enumerate(lines) if line.text and not line.text.startswith("#")), 0)
    return lines[:count]


def _filled(body: list[str], width: int) -> list[str]:
    """Paragraphs of folded text, filled; empty lines between them stay."""
    found: list[str] = []
    paragraph: list[str] = []
    for line in [*body, ""]:
        if line:
            paragraph.append(line)
            continue
        if paragraph:
            found += textwrap.wrap(" ".join(paragraph), width, break_long_words=False, break_on_hyphens=False)
        found.append("")
        paragraph = []
    return found[:-1]


def _align(lines: list[_Line]) -> None:
    """Trailing comments at least two blanks behind their text; those in one column move together."""
    columns = {line.column for line in lines if line.comment}
    for column in columns:
        group = [line for line in lines if line.comment and line.column == column]
        needed = max(len(line.text) + 2 for line in group)
        for line in group:
            line.column = max(column, needed)


def _joined(line: _Line) -> str:
    if not line.comment:
        return line.text
    return f"{line.text.ljust(line.column)}{line.comment}" if line.text else line.comment
