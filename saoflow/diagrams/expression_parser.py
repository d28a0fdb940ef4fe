"""Reading the expression language of sheets: tokens, precedence, and positions down to each name.

From loose to tight: ``+ -``, ``* /``, unary ``- +``, ``^`` (right to left, ``**`` is the same), then calls, members
and brackets. So ``-x^2`` is ``-(x^2)`` and ``2^-3`` is allowed.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Sequence
from typing import TypeVar

from saoflow.diagnosis import Diagnosis, DiagnosisError, Position
from saoflow.diagrams.expression import (
    Array,
    Binary,
    Call,
    Expression,
    Index,
    Member,
    Name,
    Number,
    Slice,
    Text,
    Unary,
)

LONGEST = 10_000
"""Characters that one expression may have."""
LONGEST_NAME = 64
"""Characters that a name may have."""
DEEPEST = 100
"""Levels that the tree of one expression may have, so that walking it by recursion is safe."""
NESTED = 50
"""Brackets, signs and right-hand sides inside each other, of those levels."""

Locate = Callable[[int, int], Position]
"""From an offset in the text and a length to the place in the file."""

_NUMBER = r"(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?"
_PLAIN_NAME = re.compile(r"[^\W\d]\w*", re.UNICODE)
_PLAIN_NUMBER = re.compile(rf"-?{_NUMBER}")
_TOKEN = re.compile(
    rf"\s*(?:(?P<number>{_NUMBER})|(?P<name>[^\W\d]\w*)|(?P<operator>\*\*|[-+*/^()\[\],:.])|(?P<other>\S))"
)
_LEVELS = {"+": 1, "-": 1, "*": 2, "/": 2, "^": 4}
_UNARY_LEVEL = 3


_Item = TypeVar("_Item")


class ExpressionFailure(Exception):
    """Why a text is no expression, and where in it (offset and length)."""

    def __init__(self, message: str, offset: int, length: int, cause: str, remedy: str) -> None:
        super().__init__(message)
        self.message, self.offset, self.length = message, offset, max(1, length)
        self.cause, self.remedy = cause, remedy

    def diagnosis(self, locate: Locate, source_line: str | None = None) -> Diagnosis:
        """The failure as a diagnosis (E111)."""
        return Diagnosis(
            "E111",
            self.message,
            locate(self.offset, self.length),
            cause=self.cause,
            remedy=self.remedy,
            source_line=source_line,
        )


def parse_expression(text: str, position: Position, source_line: str | None = None) -> Expression:
    """The tree of ``text``, which stands on one line from ``position`` on.

    ``source_line`` (the whole line) is shown in the message. Raises DiagnosisError (E111).
    """

    def locate(offset: int, length: int) -> Position:
        return Position(position.file, position.line, position.column + offset, length)

    try:
        return parse_at(text, locate)
    except ExpressionFailure as failure:
        raise DiagnosisError([failure.diagnosis(locate, source_line)]) from None


def parse_at(text: str, locate: Locate) -> Expression:
    """The tree of ``text``, with ``locate`` telling the place of each part. Raises ExpressionFailure.

    Plain names and numbers, which are most of a sheet, take a short way.
    """
    if len(text) > LONGEST:
        raise ExpressionFailure(
            f"an expression of {len(text)} characters", 0, 1, f"at most {LONGEST} are read", "split it up"
        )
    if len(text) <= LONGEST_NAME and _PLAIN_NAME.fullmatch(text) and (text.isascii() or text.isidentifier()):
        return Name(text, locate(0, len(text)))
    if _PLAIN_NUMBER.fullmatch(text):
        return Number(_finite(text, 0), locate(0, len(text)))
    if text[:1] == "-" and len(text) <= LONGEST_NAME and _PLAIN_NAME.fullmatch(text, 1) and text.isascii():
        return Unary("-", Name(text[1:], locate(1, len(text) - 1)), locate(0, len(text)))
    parser = _Parser(text, locate)
    result = parser.whole()
    # Long chains (a + b + c ...) make deep trees without nesting; only they need to be measured.
    if len(parser.tokens) > DEEPEST and height(result) > DEEPEST:
        raise _too_deep(0)
    return result


def height(expression: Expression) -> int:
    """The number of levels of a tree; found without recursion."""
    level: list[Expression | Slice] = [expression]
    levels = 0
    while level:
        levels += 1
        level = [child for node in level for child in children(node)]
    return levels


def children(node: Expression | Slice) -> Sequence[Expression | Slice]:
    """The direct parts of a node, from left to right (a call's function name is not one of them)."""
    match node:
        case Number() | Name() | Text():
            return ()
        case Member():
            return (node.base,)
        case Slice():
            return tuple(end for end in (node.start, node.stop) if end is not None)
        case Index():
            return (node.base, *node.indices)
        case Call():
            return node.arguments
        case Unary():
            return (node.operand,)
        case Binary():
            return (node.left, node.right)
        case Array():
            return node.items


def _finite(text: str, offset: int) -> float:
    value = float(text)
    if math.isinf(value):
        raise ExpressionFailure(
            "a number is too large",
            offset,
            len(text),
            "binary64 holds numbers up to 1.8e308",
            "write a smaller number",
        )
    return value


def _too_deep(offset: int) -> ExpressionFailure:
    return ExpressionFailure(
        "an expression is nested too deeply",
        offset,
        1,
        f"at most {NESTED} brackets inside each other and {DEEPEST} operators in a chain are read",
        "split it up, by parameters or by blocks",
    )


class _Parser:
    """Precedence climbing over a list of tokens (kind, text, offset)."""

    def __init__(self, text: str, locate: Locate) -> None:
        self.text = text
        self.locate = locate
        self.tokens: list[tuple[str, str, int]] = []
        for match in _TOKEN.finditer(text):
            kind = match.lastgroup or "other"
            self.tokens.append((kind, match.group(kind), match.start(kind)))
        self.tokens.append(("end", "", len(text.rstrip())))
        self.at = 0
        self.depth = 0

    # ------------------------------------------------------------ tokens

    def peek(self) -> str:
        """The operator that comes next; empty for anything else."""
        kind, word, _ = self.tokens[self.at]
        return word if kind == "operator" else ""

    def take(self, operator: str) -> bool:
        if self.peek() == operator:
            self.at += 1
            return True
        return False

    def require(self, operator: str) -> None:
        if not self.take(operator):
            raise self.unexpected(f"`{operator}`")

    def unexpected(self, wanted: str) -> ExpressionFailure:
        kind, word, offset = self.tokens[self.at]
        remedy = "write arithmetic with + - * / ^, calls f(x), members a.b and brackets a[i]"
        if kind == "end":
            return ExpressionFailure("an expression ends too early", offset, 1, f"{wanted} should follow", remedy)
        before = self.tokens[self.at - 1] if self.at else ("", "", 0)
        if before[0] == "number" and kind == "name" and before[2] + len(before[1]) == offset:
            remedy = f"write {before[1]}*{word} for a product; names do not start with a digit"
        return ExpressionFailure(
            f"`{word}` is not expected here", offset, len(word), f"{wanted} should stand here", remedy
        )

    def span(self, start: int) -> Position:
        """From offset ``start`` to the end of the last token taken."""
        _, word, offset = self.tokens[self.at - 1]
        return self.locate(start, offset + len(word) - start)

    # ------------------------------------------------------------ grammar

    def whole(self) -> Expression:
        if len(self.tokens) == 1:
            raise ExpressionFailure(
                "an expression is empty",
                0,
                1,
                "a name, a number or an expression should stand here",
                "write one",
            )
        result = self.expression(0)
        if self.tokens[self.at][0] != "end":
            raise self.unexpected("an operator or the end")
        return result

    def expression(self, level: int) -> Expression:
        """Everything that binds at least as tightly as ``level``."""
        start = self.tokens[self.at][2]
        self.depth += 1
        if self.depth > NESTED:
            raise _too_deep(start)
        left = self.signed()
        while True:
            word = self.peek()
            operator = "^" if word == "**" else word
            binds = _LEVELS.get(operator, -1)
            if binds < level or binds < 0:
                break
            self.at += 1
            right = self.expression(binds if operator == "^" else binds + 1)
            left = Binary(operator, left, right, self.span(start))
        self.depth -= 1
        return left

    def signed(self) -> Expression:
        word = self.peek()
        if word not in ("-", "+"):
            return self.postfix()
        start = self.tokens[self.at][2]
        self.at += 1
        operand = self.expression(_UNARY_LEVEL)
        return Unary(word, operand, self.span(start))

    def postfix(self) -> Expression:
        start = self.tokens[self.at][2]
        base = self.primary()
        while True:
            word = self.peek()
            if word == ".":
                self.at += 1
                kind, name, offset = self.tokens[self.at]
                if kind != "name":
                    raise self.unexpected("the name of an output, or T,")
                self.at += 1
                base = Member(base, name, self.locate(offset, len(name)))
            elif word == "[":
                self.at += 1
                indices = self.items("]", self.index)
                if not indices:
                    self.at -= 1
                    raise self.unexpected("an index")
                base = Index(base, tuple(indices), self.span(start))
            elif word == "(" and isinstance(base, Name):
                self.at += 1
                arguments = self.items(")", lambda: self.expression(0))
                base = Call(base, tuple(arguments), self.span(start))
            else:
                return base

    def items(self, close: str, item: Callable[[], _Item]) -> list[_Item]:
        """``item, item, ... close``; none at all is allowed."""
        found: list[_Item] = []
        if self.take(close):
            return found
        while True:
            found.append(item())
            if self.take(close):
                return found
            if not self.take(","):
                raise self.unexpected(f"`,` or `{close}`")

    def index(self) -> Expression | Slice:
        start = self.tokens[self.at][2]
        first = None if self.peek() == ":" else self.expression(0)
        if not self.take(":"):
            if first is None:
                raise self.unexpected("`:`")
            return first
        stop = None if self.peek() in (",", "]") else self.expression(0)
        return Slice(first, stop, self.span(start))

    def primary(self) -> Expression:
        kind, word, offset = self.tokens[self.at]
        if kind == "number":
            self.at += 1
            return Number(_finite(word, offset), self.locate(offset, len(word)))
        if kind == "name" and word.isidentifier():
            if len(word) > LONGEST_NAME:
                raise ExpressionFailure(
                    f"a name of {len(word)} characters",
                    offset,
                    len(word),
                    f"names have at most {LONGEST_NAME}",
                    "shorten it",
                )
            self.at += 1
            return Name(word, self.locate(offset, len(word)))
        if word == "(":
            self.at += 1
            inner = self.expression(0)
            self.require(")")
            return inner
        if word == "[":
            self.at += 1
            items = self.items("]", lambda: self.expression(0))
            return Array(tuple(items), self.span(offset))
        raise self.unexpected("a name, a number or `(`")
