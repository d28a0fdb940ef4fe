"""YAML text to a tree of nodes with exact places: a composer of our own on PyYAML's events.

It differs from PyYAML's loaders in what a sheet needs: every key and scalar keeps its line and column, a key written
twice is an error, no scalar is interpreted (``no`` and ``1e-3`` stay text), tags are refused, and neither aliases nor
nesting can explode. PyYAML's C parser is used where it is installed.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import Any, final

import yaml
from yaml import events as e

from saoflow.diagnosis import Diagnosis, Note, Position

DEEPEST = 64
"""Levels of mappings and sequences inside each other, aliases followed."""
MOST_ALIASED = 200_000
"""Nodes that all aliases together may stand for."""
_LINE_BREAK = re.compile("\r\n|[\r\n\x85\u2028\u2029]")
_C_LOADER: Any = getattr(yaml, "CLoader", None)


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
        self.lines = tuple(_LINE_BREAK.split(self.text))

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
        line = self.line(position.line) if position else None
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
        places = self._align(node)

        def locate(offset: int, length: int) -> Position:
            line, column = places[min(offset, len(places) - 1)]
            return Position(file, line, column, length)

        return locate

    def _align(self, node: Scalar) -> list[tuple[int, int]]:
        """The line and column (from 1) of each character of a scalar, and of its end, found by walking the text."""
        line, column = node.line, node.column
        if not node.plain:
            column += 1
            if (self.line(line + 1) or "")[column - 1 : column] in ("|", ">"):
                line, column = line + 1, 0
        places: list[tuple[int, int]] = []
        last = (node.end_line, node.end_column)
        for character in node.value:
            if not character.isspace():
                row, at = line, column
                while (row, at) < last and row < len(self.lines):
                    found = self.lines[row].find(character, at)
                    if found >= 0 and (row, found) < last:
                        line, column = row, found
                        break
                    row, at = row + 1, 0
            places.append((line + 1, column + 1))
            if not character.isspace():
                column += 1
        places.append((line + 1, column + 1))
        return places


class _Stop(Exception):
    """Composing cannot go on; the reason has been reported."""


def compose(source: SourceText) -> Node | None:
    """The root node of the only document; None if the text is empty or broken. What is wrong is in ``source.found``."""
    composer = _Composer(source)
    try:
        return composer.run()
    except _Stop:
        return None
    except yaml.YAMLError as error:
        _report_yaml_error(source, error)
    except UnicodeEncodeError as error:
        source.report("E104", "the text holds a character that is none", None, cause=str(error.reason))
    return None


def _parse_events(text: str) -> Iterator[Any]:
    """The events of a text, by the C parser if PyYAML has it."""
    if _C_LOADER is None:
        yield from yaml.parse(text, Loader=yaml.SafeLoader)
        return
    loader = _C_LOADER(text)
    try:
        event = loader.get_event()
        while event is not None:
            yield event
            event = loader.get_event()
    finally:
        loader.dispose()


class _Composer:
    def __init__(self, source: SourceText) -> None:
        self.source = source
        self.anchors: dict[str, Node] = {}
        self.aliased = 0
        self.count = 0

    def run(self) -> Node | None:
        """One pass over the events with a stack of open collections (no recursion)."""
        root: Node | None = None
        documents = 0
        stack: list[Sequence | Mapping] = []
        counts: list[int] = []
        for event in _parse_events(self.source.text):
            kind = type(event)
            node: Node
            if kind is e.ScalarEvent:
                node = Scalar(event.value, event.implicit[0], event.start_mark, event.end_mark)
                self.count += 1
                if event.anchor is not None or event.tag is not None:
                    self.properties(event, node)
            elif kind is e.MappingStartEvent or kind is e.SequenceStartEvent:
                node = Mapping(event.start_mark) if kind is e.MappingStartEvent else Sequence(event.start_mark)
                if event.anchor is not None or event.tag is not None:
                    self.properties(event, node)
                if len(stack) >= DEEPEST:
                    self.too_deep(event.start_mark)
                stack.append(node)
                counts.append(self.count)
                self.count += 1
                continue
            elif kind is e.MappingEndEvent or kind is e.SequenceEndEvent:
                node = stack.pop()
                node.end_line, node.end_column = event.end_mark.line, event.end_mark.column
                node.size = self.count - counts.pop()
            elif kind is e.AliasEvent:
                node = self.alias(event, len(stack))
            elif kind is e.DocumentStartEvent:
                documents += 1
                if documents > 1:
                    self.second_document(event)
                continue
            else:
                continue
            if not stack:
                root = node
                continue
            parent = stack[-1]
            if type(node) is not Scalar and node.height >= parent.height:
                parent.height = node.height + 1
            if type(parent) is Sequence:
                parent.items.append(node)
            elif type(parent) is Mapping:
                if parent.key is None:
                    parent.key = node
                else:
                    self.entry(parent, parent.key, node)
                    parent.key = None
        return root

    def entry(self, mapping: Mapping, key: Node, value: Node) -> None:
        """Add an entry unless its key is no word or was there before."""
        if type(key) is not Scalar:
            self.source.report(
                "E108",
                "a key must be a word",
                self.source.position(key),
                cause=f"a {'list' if type(key) is Sequence else 'mapping'} stands where a key belongs",
                remedy="write `key: value`; put text with brackets or braces into quotes",
            )
            return
        first = mapping.keys.setdefault(key.value, key)
        if first is key:
            mapping.entries.append((key, value))
            return
        self.source.report(
            "E105",
            f"`{short(key.value)}` is written twice",
            self.source.position(key),
            cause="a key may stand only once in a mapping; one of the two would be lost",
            notes=(Note(f"the first `{short(key.value)}` is here", self.source.position(first)),),
            remedy="rename or remove one of them",
        )

    def properties(self, event: Any, node: Node) -> None:
        """Anchors are remembered, tags refused."""
        if event.anchor is not None:
            self.anchors[event.anchor] = node
        if event.tag is not None:
            self.source.report(
                "E114",
                f"the tag `{short(event.tag)}` has no meaning in a sheet",
                self.source.at_mark(event.start_mark),
                cause="values of a sheet are words, numbers and expressions; their type follows from where they stand",
                remedy="remove the tag",
            )

    def alias(self, event: Any, depth: int) -> Node:
        """The node that an alias stands for. Raises _Stop for none, for itself, and over the bounds."""
        node = self.anchors.get(event.anchor)
        place = self.source.at_mark(event.start_mark)
        if node is None:
            self.source.report(
                "E102",
                f"no anchor `&{short(event.anchor)}` comes before this alias",
                place,
                cause="an alias repeats a value that was marked with an anchor earlier in the file",
                remedy="write the value itself; put text that starts with `*` into quotes",
            )
            return Scalar("", True, event.start_mark, event.end_mark)
        size = 1
        if type(node) is not Scalar:
            if node.size == 0:
                self.source.report(
                    "E109",
                    f"the alias `*{short(event.anchor)}` stands inside its own anchor",
                    place,
                    cause="the value would contain itself without end",
                    remedy="write the value itself",
                )
                raise _Stop
            if depth + node.height > DEEPEST:
                self.too_deep(event.start_mark)
            size = node.size
        self.aliased += size
        self.count += size
        if self.aliased > MOST_ALIASED:
            self.source.report(
                "E109",
                "aliases repeat too much",
                place,
                cause=f"up to here they stand for more than {MOST_ALIASED} values",
                remedy="use a sheet several times, or `fold` or `map`, instead of repeated text",
            )
            raise _Stop
        return node

    def too_deep(self, mark: Any) -> None:
        self.source.report(
            "E109",
            "nested too deeply",
            self.source.at_mark(mark),
            cause=f"at most {DEEPEST} lists and mappings may lie inside each other",
            remedy="a sheet needs far fewer levels: look for a bracket that is not closed",
        )
        raise _Stop

    def second_document(self, event: Any) -> None:
        self.source.report(
            "E114",
            "a second document starts",
            self.source.at_mark(event.start_mark),
            cause="a file holds one sheet",
            remedy="remove the line `---`, or move the second sheet into a file of its own",
        )
        raise _Stop


_TROUBLES = (
    # what PyYAML says, its usual cause, the remedy
    ("found character '\\t'", "a tab stands where only spaces may indent", "indent with spaces"),
    ("cannot start any token", "a character stands here that YAML reserves", "put the text into quotes"),
    (
        "mapping values are not allowed",
        "a `:` stands where no key can be",
        "check the indentation, or put text with `: ` into quotes",
    ),
    (
        "did not find expected ',' or",
        "a list or mapping is not closed, or text in it needs quotes",
        'close it, or put text with brackets such as "P[-1]" into quotes',
    ),
    ("could not find expected ':'", "a line is no `key: value`", "add the `:` and a value"),
    (
        "did not find expected key",
        "the indentation does not fit, or text follows a quote or bracket",
        "indent the keys of one mapping alike",
    ),
    ("found unexpected end of stream", "a quote is not closed", "close the quote"),
    ("unexpected end", "a bracket or a quote is not closed", "close it"),
    (
        "alphabetic or numeric character",
        "`&` and `*` mark anchors and aliases in YAML",
        "put text that starts with `&` or `*` into quotes",
    ),
)


def _report_yaml_error(source: SourceText, error: yaml.YAMLError) -> None:
    """A syntax error as a diagnosis; PyYAML's own words stand as the cause unless a better one is known."""
    problem = str(getattr(error, "problem", None) or getattr(error, "reason", None) or error)
    mark = getattr(error, "problem_mark", None) or getattr(error, "context_mark", None)
    if isinstance(error, yaml.reader.ReaderError) or "control characters" in problem:
        _report_character(source)
        return
    context, begun = getattr(error, "context", None), getattr(error, "context_mark", None)
    notes: tuple[Note, ...] = ()
    if context and begun is not None and mark is not None and begun.line != mark.line:
        notes = (Note(str(context), source.at_mark(begun)),)
    cause, remedy = problem, "correct the YAML; most often an indentation, a quote or a bracket is wrong"
    for words, why, what in _TROUBLES:
        if words in problem:
            cause, remedy = why, what
            break
    position = source.at_mark(mark)
    if position is not None and source.line(position.line) in (None, "") and len(source.lines) > 1:
        last = max((n for n, line in enumerate(source.lines, 1) if line.strip()), default=1)
        if position.line > last:  # the end of the file: show where its text ends
            position = Position(source.file, last, len(source.lines[last - 1]) + 1)
    source.report("E102", "the text is not YAML", position, cause=cause, notes=notes, remedy=remedy)


_NOT_TEXT = re.compile("[^\t\n\r\x20-\x7e\x85\xa0-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")


def _report_character(source: SourceText) -> None:
    """The first character that YAML does not allow."""
    match = _NOT_TEXT.search(source.text)
    if match is None:
        source.report("E104", "the file holds a character that text may not have", None, remedy="save it as UTF-8 text")
        return
    before = _LINE_BREAK.split(source.text[: match.start()])
    source.report(
        "E104",
        f"the character U+{ord(match.group()):04X} is not text",
        Position(source.file, len(before), len(before[-1]) + 1),
        cause="control characters cannot stand in a sheet",
        remedy="remove it; if the file is no text at all, name another file",
    )


def short(text: str, limit: int = 64) -> str:
    """Text for a message: on one line, and cut if it is long."""
    text = " ".join(text.split())
    return text if len(text) <= limit else text[: limit - 3] + "..."
