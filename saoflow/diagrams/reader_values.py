"""What the values of a sheet are made of: names, words, expressions, units, keys; each checked where it stands."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator
from dataclasses import dataclass

from saoflow.diagnosis import DiagnosisError, Position, did_you_mean
from saoflow.diagrams.expression import Array, Expression, Text
from saoflow.diagrams.expression_parser import LONGEST_NAME, ExpressionFailure, parse_at
from saoflow.diagrams.sheet import Argument, Connection, Named, UnitText
from saoflow.diagrams.yaml_text import Mapping, Node, Scalar, Sequence, SourceText, short
from saoflow.units import Unit


@dataclass(slots=True)
class ValueReader:
    """Turns YAML nodes into names, expressions and units. What is wrong is reported to ``source``; the methods then
    return None (or leave the part out) and reading goes on, since the sheet is not going to be used."""

    source: SourceText

    def report(self, code: str, message: str, node: Node, cause: str, remedy: str) -> None:
        """A diagnosis at a node."""
        self.source.report(code, message, self.source.position(node), cause=cause, remedy=remedy)

    # ------------------------------------------------------------ words and names

    def named(self, node: Scalar) -> Named:
        """A word with its place, not checked."""
        return Named(node.value, self.source.position(node))

    def name(self, node: Node, what: str) -> Named | None:
        """The name of something that is declared; ``what`` says of what ("a block")."""
        if type(node) is not Scalar:
            self.wrong_kind(node, f"the name of {what}", "a word", "write a name")
            return None
        text = node.value
        if text.isidentifier() and len(text) <= LONGEST_NAME and not node.nothing:
            return self.named(node)
        if node.nothing:
            cause = f"`{text}` stands for nothing in YAML" if text else "it is empty"
        elif text == "<<":
            cause = "YAML's merge keys are not used in sheets: what a sheet says stands in it"
        elif len(text) > LONGEST_NAME:
            cause = f"it has {len(text)} characters; at most {LONGEST_NAME} are allowed"
        else:
            cause = "names consist of letters, digits and underscores, and do not start with a digit"
        better = re.sub(r"\W+", "_", text).strip("_")
        better = f"_{better}" if better[:1].isdigit() else better
        remedy = (
            f"write `{better}`, for example"
            if better.isidentifier() and better != text and len(better) <= LONGEST_NAME
            else "choose another name"
        )
        self.report("E112", f"`{short(text)}` is not a name for {what}", node, cause, remedy)
        return None

    def word(self, node: Node, what: str) -> str | None:
        """The text of a scalar (``doc``, ``equations``, ``source``); nothing is an empty text."""
        if type(node) is Scalar:
            return "" if node.nothing else node.value
        self.wrong_kind(node, what, "text", "write text; put text with brackets or braces into quotes")
        return None

    def choice(self, node: Node, what: str, choices: Collection[str]) -> Named | None:
        """One of a few words."""
        if type(node) is Scalar and node.value in choices:
            return self.named(node)
        listed = " or ".join(f"`{c}`" for c in choices)
        if type(node) is Scalar and not node.nothing:
            near = did_you_mean(node.value, choices)
            self.report(
                "E108",
                f"`{short(node.value)}` is no {what}",
                node,
                f"it is {listed}",
                near or f"write {listed}",
            )
        else:
            self.wrong_kind(node, what, "a word", f"write {listed}")
        return None

    # ------------------------------------------------------------ collections

    def wrong_kind(self, node: Node, what: str, wanted: str, remedy: str) -> None:
        """The diagnosis for a value of the wrong kind (E108); ``wanted`` says what belongs there."""
        found = "a list" if type(node) is Sequence else "a mapping" if type(node) is Mapping else ""
        if type(node) is Scalar:
            found = "nothing" if node.nothing else f"`{short(node.value)}`"
        self.report("E108", f"{what} cannot be {found}", node, f"{wanted} should stand here", remedy)

    def entries(self, node: Node, what: str, remedy: str) -> Iterator[tuple[Scalar, Node]]:
        """The entries of a mapping; nothing counts as an empty one."""
        if type(node) is Mapping:
            yield from node.entries
        elif not (type(node) is Scalar and node.nothing):
            self.wrong_kind(node, what, "`key: value` entries", remedy)

    def unknown_key(self, key: Scalar, what: str, known: Collection[str]) -> None:
        """The diagnosis for a key that is none of ``known`` (E106)."""
        near = did_you_mean(key.value, known)
        self.report(
            "E106",
            f"unknown key `{short(key.value)}` in {what}",
            key,
            f"the keys are {', '.join(known)}",
            near or "remove it, or choose one of the keys",
        )

    # ------------------------------------------------------------ expressions

    def expression(self, node: Node, what: str) -> Expression | None:
        """A scalar as an expression, a list as an array of expressions."""
        if type(node) is Scalar:
            if node.nothing:
                self.report("E108", f"{what} has no value", node, "nothing stands here", "write an expression")
                return None
            try:
                return parse_at(node.value, self.source.locator(node))
            except ExpressionFailure as failure:
                diagnosis = failure.diagnosis(self.source.locator(node))
                self.source.report(
                    diagnosis.code,
                    diagnosis.message,
                    diagnosis.position,
                    cause=diagnosis.cause,
                    remedy=diagnosis.remedy,
                )
                return None
        if type(node) is Sequence:
            items = [self.expression(item, what) for item in node.items]
            return Array(tuple(i for i in items if i is not None), self.source.position(node))
        self.wrong_kind(node, what, "an expression", "write an expression or a list of expressions")
        return None

    def connections(self, node: Node, what: str) -> tuple[Connection, ...]:
        """``port: operand`` entries."""
        found = []
        for key, value in self.entries(node, what, "write `port: wire` entries"):
            port = self.name(key, "a port")
            wire = self.expression(value, f"the port `{short(key.value)}`")
            if wire is not None:
                found.append(Connection(port, wire))
        return tuple(found)

    def argument(self, key: Scalar, node: Node) -> Argument | None:
        """``key: value`` of a block: an expression where it reads as one; else its text is for the symbol to judge."""
        name = self.name(key, "a parameter")
        if name is None:
            return None
        if type(node) is Mapping:
            self.wrong_kind(
                node, f"`{name.text}`", "an expression, a word or a list", "write an expression, a word or a list"
            )
            return None
        if type(node) is Scalar and node.nothing:
            self.report("E108", f"`{name.text}` has no value", key, "nothing stands after the key", "write a value")
            return None
        position = self.source.position(node)
        if type(node) is Scalar:
            value = self._expression_or_text(node, position)
            return Argument(name, None if type(value) is Text else value, node.value, position)
        return Argument(name, self._expression_or_text(node, position), "", position)

    def _expression_or_text(self, node: Node, position: Position) -> Expression:
        if type(node) is Scalar:
            try:
                return parse_at(node.value, self.source.locator(node))
            except ExpressionFailure:
                return Text(node.value, position)
        if type(node) is Sequence:
            items = [self._expression_or_text(item, self.source.position(item)) for item in node.items]
            return Array(tuple(items), position)
        self.wrong_kind(node, "an element of a list", "an expression or a word", "write an expression or a word")
        return Text("", position)

    # ------------------------------------------------------------ units

    def unit(self, node: Node) -> UnitText | None:
        """A unit as text, or a list of units, one per element; each is checked to be one."""
        if type(node) is Sequence:
            items = [self.unit(item) for item in node.items]
            return UnitText(tuple(i for i in items if i is not None), self.source.position(node))
        if type(node) is Mapping or (type(node) is Scalar and node.nothing):
            self.wrong_kind(
                node, "a unit", "text or a list", "write a unit such as kt/s, 1 for none, or leave the key out"
            )
            return None
        place = self.source.locator(node)(0, len(node.value))
        try:
            Unit.parse(node.value, place)
        except DiagnosisError as error:
            for d in error.diagnoses:
                self.source.report(d.code, d.message, d.position, cause=d.cause, remedy=d.remedy)
            return None
        return UnitText(node.value, place)
