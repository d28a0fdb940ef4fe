"""Values of a campaign file: numbers, ranges, names; each checked where it stands."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator

from saoflow.diagnosis import did_you_mean
from saoflow.yaml_document import Document, Mapping, Node, Scalar, Sequence, short
from verification.campaigns.plan import Range

MOST = 10_000_000
"""Runs of a set, flights of a set."""


def number(document: Document, node: Node, what: str, low: float, high: float, unit: str = "") -> float | None:
    """A number from ``low`` to ``high``; None after a diagnosis (E108, E801)."""
    value = _number(document, node, what)
    if value is None:
        return None
    if not low <= value <= high:
        _out_of_range(document, node, what, value, low, high, unit)
        return None
    return value


def whole(document: Document, node: Node, what: str, low: int, high: int = MOST) -> int | None:
    """A whole number from ``low`` to ``high``; None after a diagnosis."""
    value = number(document, node, what, low, high)
    if value is not None and not value.is_integer():
        document.report("E108", f"{what} cannot be `{value:g}`", node, "it is a whole number", f"write {round(value)}")
        return None
    return None if value is None else int(value)


def interval(document: Document, node: Node, what: str, low: float, high: float, unit: str = "") -> Range | None:
    """``[from, to]``, or one number for both; None after a diagnosis."""
    if type(node) is Scalar:
        value = number(document, node, what, low, high, unit)
        return None if value is None else Range(value, value)
    if type(node) is not Sequence or len(node.items) != 2:
        document.wrong_kind(node, what, "a list of two numbers", f"write [{low:g}, {high:g}], for example")
        return None
    ends = [number(document, item, what, low, high, unit) for item in node.items]
    if ends[0] is None or ends[1] is None:
        return None
    if ends[0] > ends[1]:
        document.report(
            "E801", f"{what} goes from {ends[0]:g} down to {ends[1]:g}", node, "the first is the lowest", "swap them"
        )
        return None
    return Range(ends[0], ends[1])


def words(
    document: Document, node: Node, what: str, known: Collection[str], code: str = "E801"
) -> tuple[str, ...] | None:
    """A list of names, each one of ``known`` and only once; a single name is a list of one. None after a diagnosis."""
    found: list[str] = []
    fine = True
    for item in items(document, node, what):
        if type(item) is not Scalar or item.nothing:
            document.wrong_kind(item, what, "a name", f"one of {', '.join(known)}")
            fine = False
        elif item.value not in known:
            fine = False
            unknown(document, item, what, known, code)
        elif item.value in found:
            fine = False
            document.report(
                "E105", f"`{item.value}` is named twice", item, f"{what} holds each name once", "remove one"
            )
        else:
            found.append(item.value)
    if fine and not found:
        document.report("E108", f"{what} is empty", node, "at least one name is needed", f"one of {', '.join(known)}")
    return tuple(found) if fine and found else None


def items(document: Document, node: Node, what: str) -> Iterator[Node]:
    """The items of a list; a single word is a list of one."""
    if type(node) is Sequence:
        yield from node.items
    elif type(node) is Mapping or (type(node) is Scalar and node.nothing):
        document.wrong_kind(node, what, "a list", "write [first, second]")
    else:
        yield node


def unknown(document: Document, node: Scalar, what: str, known: Collection[str], code: str = "E801") -> None:
    """The diagnosis for a name that is none of ``known``."""
    document.report(
        code,
        f"{what}: there is no `{short(node.value)}`",
        node,
        f"there are {', '.join(known)}" if known else "there are none",
        did_you_mean(node.value, known) or "name one that is there",
    )


def _number(document: Document, node: Node, what: str) -> float | None:
    if type(node) is Scalar and not node.nothing:
        try:
            value = float(node.value)
        except ValueError:
            value = math.nan
        if math.isfinite(value) and "_" not in node.value:
            return value
    document.wrong_kind(node, what, "a number", "write a number")
    return None


def _out_of_range(document: Document, node: Node, what: str, value: float, low: float, high: float, unit: str) -> None:
    text = f"{low:.10g} to {high:.10g} {unit}".rstrip()
    document.report("E801", f"{what} cannot be {value:.10g}", node, f"it is {text}", f"write a number from {text}")
