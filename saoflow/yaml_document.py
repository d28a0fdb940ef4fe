"""A YAML file that is no sheet: its nodes with their places, and what is wrong in it told as for a sheet."""

from __future__ import annotations

import os

from saoflow.diagnosis import DiagnosisError, Position, in_order
from saoflow.diagrams.reader import file_text
from saoflow.diagrams.reader_values import ValueReader
from saoflow.diagrams.yaml_text import Mapping, Node, Scalar, Sequence, SourceText, compose, short

__all__ = ["Document", "Mapping", "Node", "Scalar", "Sequence", "open_document", "short"]


class Document(ValueReader):
    """An open document: ``root``, its keys and values, and the means to say what is wrong with them."""

    def __init__(self, source: SourceText, root: Mapping) -> None:
        super().__init__(source)
        self.root = root

    def missing(self, node: Node, key: str, cause: str, remedy: str) -> None:
        """The diagnosis for a key that a mapping must have (E107); it stands where the mapping begins."""
        place = Position(self.source.file, node.line + 1, node.column + 1)
        self.source.report("E107", f"the key `{key}` is missing", place, cause=cause, remedy=remedy)

    def raise_if_wrong(self) -> None:
        """Raises DiagnosisError with all that has been reported, in the order of the text."""
        if self.source.found:
            raise DiagnosisError(in_order(dict.fromkeys(self.source.found)))


def open_document(path: str | os.PathLike[str], what: str, start: str) -> Document:
    """Read a file whose root is a mapping. ``what`` it is ("a campaign"), and how one starts (for remedies).

    Raises DiagnosisError E101, E103, E104, E108, E110 and those of broken YAML.
    """
    file = os.fspath(path)
    source = SourceText(file, file_text(file).removeprefix("\ufeff"))
    root = compose(source)
    if type(root) is Mapping:
        return Document(source, root)
    if root is None or (type(root) is Scalar and root.nothing):
        if not source.found:
            source.report(
                "E103",
                "the file is empty",
                Position(source.file, 1, 1),
                cause="it holds no key at all",
                remedy=f"{what} starts with {start}",
            )
    else:
        ValueReader(source).wrong_kind(root, what, "a mapping", f"start with {start}")
    raise DiagnosisError(in_order(dict.fromkeys(source.found)))
