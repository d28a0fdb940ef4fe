"""PyYAML's complaints in the words of a diagnosis: what is usually wrong, and what to do."""

from __future__ import annotations

import re

import yaml

from saoflow.diagnosis import Note, Position
from saoflow.diagrams.yaml_nodes import LINE_BREAK, SourceText

_TROUBLES = (
    # what PyYAML says, its usual cause, the remedy
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
    (
        "found unexpected ':'",
        "in brackets, a `:` after a word must be followed by a space",
        "write `key: value`, or put the text into quotes",
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


def report_yaml_error(source: SourceText, error: yaml.YAMLError) -> None:
    """A syntax error as a diagnosis; PyYAML's own words stand as the cause unless a better one is known."""
    problem = str(getattr(error, "problem", None) or getattr(error, "reason", None) or error)
    mark = getattr(error, "problem_mark", None) or getattr(error, "context_mark", None)
    if isinstance(error, yaml.reader.ReaderError) or "control characters" in problem:
        report_character(source)
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
    if mark is not None and (source.line(mark.line + 1) or "")[mark.column : mark.column + 1] == "\t":
        cause, remedy = "a tab stands where only spaces may indent", "indent with spaces"
    elif begun is not None and ("end of stream" in problem or "expected ':'" in problem):
        mark, notes = begun, ()  # where it began says more than where it was noticed
    position = source.at_mark(mark)
    if position is not None and source.line(position.line) in (None, "") and len(source.lines) > 1:
        last = max((n for n, line in enumerate(source.lines, 1) if line.strip()), default=1)
        if position.line > last:  # the end of the file: show where its text ends
            position = Position(source.file, last, len(source.lines[last - 1]) + 1)
    source.report("E102", "the text is not YAML", position, cause=cause, notes=notes, remedy=remedy)


_NOT_TEXT = re.compile("[^\t\n\r\x20-\x7e\x85\xa0-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")


def report_character(source: SourceText) -> None:
    """Report the first character that YAML does not allow."""
    match = _NOT_TEXT.search(source.text)
    before = LINE_BREAK.split(source.text[: match.start()] if match else "")
    what = f"the character U+{ord(match.group()):04X}" if match else "a character in the file"
    source.report(
        "E104",
        f"{what} is not text",
        Position(source.file, len(before), len(before[-1]) + 1),
        cause="control characters and halves of characters cannot stand in a sheet",
        remedy="remove it; if the file is no text at all, name another file",
    )
