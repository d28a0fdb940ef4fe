"""Reading the blocks of a sheet: symbols and sheets with their operands, ``fold`` and ``map``."""

from __future__ import annotations

from saoflow.diagrams.expression import Array
from saoflow.diagrams.reader_values import ValueReader
from saoflow.diagrams.sheet import (
    Argument,
    BlockDeclaration,
    Connection,
    IterationDeclaration,
    Named,
    RateDeclaration,
)
from saoflow.diagrams.yaml_text import Mapping, Node, Scalar, Sequence, short

Block = BlockDeclaration | IterationDeclaration

_RATE = ("every", "offset", "transition", "held")
"""Keys of a block that runs at a rate of its own; without ``every``, the last two are arguments like others."""
_HOW = "write `name: {symbol: [wires], key: value}`"


def read_blocks(values: ValueReader, node: Node) -> tuple[Block, ...]:
    """``blocks: {name: {...}}`` in the order of the text."""
    found = []
    for key, value in values.entries(node, "`blocks`", f"under `blocks:`, {_HOW}"):
        block = _block(values, key, value)
        if block is not None:
            found.append(block)
    return tuple(found)


def _block(values: ValueReader, key: Scalar, node: Node) -> Block | None:
    """One block: its first key is the symbol or sheet, or ``fold`` or ``map``."""
    name = values.name(key, "a block")
    if type(node) is not Mapping:
        values.wrong_kind(node, f"the block `{short(key.value)}`", "a mapping", _HOW)
        return None
    if not node.entries or node.entries[0][0].value == "doc":
        at: Node = node.entries[0][0] if node.entries else node
        values.report(
            "E107",
            f"the block `{short(key.value)}` names no symbol",
            at,
            "the first key of a block is its symbol or sheet",
            _HOW,
        )
        return None
    for later, _ in node.entries[1:]:
        if later.value in ("fold", "map"):
            values.report(
                "E108",
                f"`{later.value}` must be the first key of its block",
                later,
                f"the first key, `{short(node.entries[0][0].value)}`, is taken for the symbol",
                f"move `{later.value}` to the front",
            )
            return None
    if node.entries[0][0].value in ("fold", "map"):
        return _iteration(values, name or values.named(key), node)
    first, operands = node.entries[0]
    symbol = values.name(first, "a symbol or sheet")
    rate, rest = _rate(values, node.entries[1:])
    arguments, doc = _arguments(values, rest)
    connections = _operands(values, first, operands)
    if name is None or symbol is None:
        return None
    return BlockDeclaration(name, symbol, connections, arguments, doc, rate)


def _rate(
    values: ValueReader, entries: list[tuple[Scalar, Node]]
) -> tuple[RateDeclaration | None, list[tuple[Scalar, Node]]]:
    """The rate of a block, and the entries that are not about it."""
    found = {key.value: (key, node) for key, node in entries if key.value in _RATE}
    if "every" not in found:
        return None, entries
    rest = [(key, node) for key, node in entries if key.value not in _RATE]
    key, node = found["every"]
    every = values.expression(node, "`every`")
    offset = held = None
    automatic = False
    if "offset" in found:
        at = found["offset"][1]
        automatic = type(at) is Scalar and at.value == "auto"
        if not automatic:
            offset = values.expression(at, "`offset`")
    if "held" in found:
        held = values.expression(found["held"][1], "`held`")
    transition = None
    if "transition" in found:
        transition = values.choice(found["transition"][1], "transition", ("hold", "delay"))
        if transition is None:
            return None, rest
    if every is None:
        return None, rest
    return RateDeclaration(every, values.named(key).position, offset, automatic, transition, held), rest


def _operands(values: ValueReader, symbol: Scalar, node: Node) -> tuple[Connection, ...]:
    """A list of wires, one wire, ``port: wire`` entries, or nothing.

    A list under ``constant`` is one operand, the constant's value.
    """
    if type(node) is Mapping:
        return values.connections(node, f"the wires of `{short(symbol.value)}`")
    if type(node) is Scalar and node.nothing:
        return ()
    what = f"a wire of `{short(symbol.value)}`"
    nodes = node.items if type(node) is Sequence and symbol.value != "constant" else [node]
    wires = [values.expression(item, what) for item in nodes]
    return tuple(Connection(None, wire) for wire in wires if wire is not None)


def _arguments(values: ValueReader, entries: list[tuple[Scalar, Node]]) -> tuple[tuple[Argument, ...], str]:
    """The keys after the first: ``doc``, and arguments."""
    doc = ""
    found = []
    for key, node in entries:
        if key.value == "doc":
            doc = values.word(node, "`doc`") or ""
        elif key.value in ("every", "offset"):
            _no_rate(values, key)
        else:
            argument = values.argument(key, node)
            if argument is not None:
                found.append(argument)
    return tuple(found), doc


def _no_rate(values: ValueReader, key: Scalar) -> None:
    if key.value == "offset":
        cause = "an offset says in which of every n frames a block runs, and the block has no `every`"
        values.report("E224", "`offset` without `every`", key, cause, "add `every: n`, or remove `offset`")
        return
    values.report(
        "E224",
        "a fold or map cannot have a rate of its own",
        key,
        "`every` is for a block of a sheet",
        "put the fold or map into a sheet, and give the block of that sheet the rate",
    )


def _iteration(values: ValueReader, name: Named, node: Mapping) -> IterationDeclaration | None:
    """``fold`` or ``map`` of a sheet."""
    first, sheet_node = node.entries[0]
    kind = first.value
    sheet = values.name(sheet_node, f"the sheet of a {kind}")
    parts: dict[str, tuple[Connection, ...]] = {"carry": (), "each": (), "in": ()}
    rest: list[tuple[Scalar, Node]] = []
    count, reverse = None, False
    for key, value in node.entries[1:]:
        if kind == "map" and key.value in ("carry", "order"):
            values.report(
                "E106",
                f"unknown key `{key.value}` in a map",
                key,
                "the instances of a map do not depend on each other, so nothing is carried and no order is needed",
                "remove it, or use `fold`",
            )
        elif key.value in parts:
            parts[key.value] = values.connections(value, f"`{key.value}`")
        elif key.value == "count":
            count = values.expression(value, "`count`")
            if isinstance(count, Array):
                values.wrong_kind(value, "`count`", "a number", "write a whole number or an expression")
        elif key.value == "order":
            order = values.choice(value, "order", ("forward", "reverse"))
            reverse = order is not None and order.text == "reverse"
        else:
            rest.append((key, value))
    arguments, doc = _arguments(values, rest)
    if "count" not in node.keys:
        values.report(
            "E107",
            f"the {kind} `{short(name.text)}` has no `count`",
            first,
            "the number of instances is fixed when the sheet is read",
            "add `count: N`",
        )
    if sheet is None or count is None:
        return None
    return IterationDeclaration(
        name, kind, sheet, count, reverse, parts["carry"], parts["each"], parts["in"], arguments, doc
    )
