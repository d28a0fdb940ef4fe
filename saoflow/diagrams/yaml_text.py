"""YAML text to a tree of nodes with exact places: a composer of our own on PyYAML's events.

It differs from PyYAML's loaders in what a sheet needs: every key and scalar keeps its line and column, a key written
twice is an error, no scalar is interpreted (``no`` and ``1e-3`` stay text), tags are refused, and neither aliases nor
nesting can explode. PyYAML's C parser is used where it is installed.
"""

from __future__ import annotations

from typing import Any

import yaml
from yaml import events as e

from saoflow.diagnosis import Note
from saoflow.diagrams.yaml_errors import report_character, report_yaml_error
from saoflow.diagrams.yaml_nodes import Mapping, Node, Scalar, Sequence, SourceText, short

__all__ = ["Mapping", "Node", "Scalar", "Sequence", "SourceText", "compose", "short"]

DEEPEST = 64
"""Levels of mappings and sequences inside each other, aliases followed."""
MOST_ALIASED = 200_000
"""Nodes that all aliases together may stand for."""
_LOADER: Any = getattr(yaml, "CLoader", yaml.SafeLoader)


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
        report_yaml_error(source, error)
    except UnicodeEncodeError:  # half of a surrogate pair, in text that was not read from a file
        report_character(source)
    return None


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
        next_event = _LOADER(self.source.text).get_event
        while (event := next_event()) is not None:
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
                    break
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
            return Scalar("_", True, event.start_mark, event.end_mark)  # a word, so that nothing else is said of it
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
