"""Formatting a YAML file: laid out anew, and held to mean the same before it is given back."""

from __future__ import annotations

from dataclasses import fields, is_dataclass
from typing import Any

import yaml

from saoflow.authoring.layout import ENTRIES, Layout
from saoflow.diagnosis import Diagnosis, DiagnosisError, Position, in_order
from saoflow.diagrams.reader import read_text
from saoflow.diagrams.yaml_text import Mapping, Node, Scalar, SourceText, compose


def formatted(text: str, file: str) -> str:
    """The text as it should look; ``file`` is its name in messages. What is formatted already comes back unchanged.

    A file with anchors keeps its text but for blanks at the ends of lines. Raises DiagnosisError (E1xx, E222) for a file
    that `saoflow check` cannot read either, and E699 if the result would not mean the same.
    """
    text = text.removeprefix("\ufeff")
    root = _root(text, file)
    is_sheet = "campaign" not in root.keys
    if is_sheet:
        read_text(text, file)
    if _has_anchors(text):
        return _trimmed(text)
    result = Layout(SourceText(file, text)).text(root)
    if _meaning(result, file, is_sheet) != _meaning(text, file, is_sheet):
        raise DiagnosisError(
            [
                Diagnosis(
                    "E699",
                    f"{file} would not mean the same when it is formatted",
                    cause="this is a fault of saoflow; the file is as it was",
                    remedy="please report it with the file",
                )
            ]
        )
    return result


def _root(text: str, file: str) -> Mapping:
    source = SourceText(file, text)
    root = compose(source)
    if source.found:
        raise DiagnosisError(in_order(dict.fromkeys(source.found)))
    if type(root) is not Mapping:
        read_text(text, file)  # says what is wrong
        raise AssertionError("a sheet is a mapping")
    return root


def _has_anchors(text: str) -> bool:
    return any(getattr(event, "anchor", None) for event in yaml.parse(text, Loader=yaml.SafeLoader))


def _trimmed(text: str) -> str:
    return "\n".join(line.rstrip() for line in text.splitlines()).rstrip("\n") + "\n"


def _meaning(text: str, file: str, is_sheet: bool) -> object:
    """What a file says, without places: the sheet as it is read, and its tree of keys and values."""
    source = SourceText(file, text)
    tree = compose(source)
    assert tree is not None and not source.found
    return (_bare(read_text(text, file)) if is_sheet else None, _tree(tree, ()))


def _tree(node: Node, path: tuple[str, ...]) -> object:
    """Keys and values in their order, but for those whose order the formatter may change."""
    if type(node) is Scalar:
        return node.value
    if type(node) is Mapping:
        entries = [(key.value, _tree(value, (*path, key.value))) for key, value in node.entries]
        free = not path or (len(path) == 2 and path[0] in ENTRIES)
        return sorted(entries, key=lambda entry: entry[0]) if free else entries
    return [_tree(item, (*path, "")) for item in node.items]


def _bare(value: Any) -> object:
    """A part of a sheet without the places where its words stand."""
    if isinstance(value, Position):
        return None
    if is_dataclass(value):
        return (type(value).__name__, *(_bare(getattr(value, f.name)) for f in fields(value) if f.name != "lines"))
    return tuple(map(_bare, value)) if isinstance(value, tuple) else value
