"""Every name in a sheet with its place: what it is, whose it is, and whether it is defined or used there."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Literal

from saoflow.blocks.library import SYMBOLS
from saoflow.diagnosis import Position
from saoflow.diagrams.expression import Array, Binary, Call, Expression, Index, Member, Name, Slice, Unary
from saoflow.diagrams.sheet import BlockDeclaration, Connection, IterationDeclaration, Sheet

Kind = Literal["sheet", "symbol", "parameter", "wire", "port", "output", "argument"]


@dataclass(frozen=True, slots=True)
class Place:
    """A name in a sheet."""

    kind: Kind
    """``port``, ``output`` and ``argument`` (a parameter that is given) are those of ``owner``; the rest are the sheet's."""
    name: str
    position: Position
    defines: bool
    owner: str = ""
    """The sheet or symbol whose port, output or parameter is named."""
    of: str = ""
    """The block that the name stands in."""


def places(sheet: Sheet) -> list[Place]:
    """All names of a sheet."""
    return list(_Places(sheet).all())


class _Places:
    def __init__(self, sheet: Sheet) -> None:
        self.sheet = sheet
        self.parameters = {p.name.text for p in sheet.parameters}
        self.targets = {b.name.text: target_of(b) for b in sheet.blocks}

    def all(self) -> Iterator[Place]:
        """In no order that matters."""
        sheet = self.sheet
        yield Place("sheet", sheet.name.text, sheet.name.position, True)
        if sheet.parameters_of is not None:
            yield Place("sheet", sheet.parameters_of.text, sheet.parameters_of.position, False)
        for parameter in sheet.parameters:
            yield Place("parameter", parameter.name.text, parameter.name.position, True)
            yield from self._names(parameter.value)
            yield from self._names(parameter.range)
        for port in sheet.inputs:
            yield Place("wire", port.name.text, port.name.position, True)
            for axis in port.shape or ():
                yield from self._names(axis)
        for block in sheet.blocks:
            yield from self._block(block)
        for output in sheet.outputs:
            if output.name.position != output.wire.position:  # in a list, the wire's name is the output's too
                yield Place("output", output.name.text, output.name.position, True, sheet.name.text)
            yield from self._names(output.wire)
        if sheet.budget is not None:
            for _, limit in sheet.budget.limits:
                yield from self._names(limit)
            yield from self._names(sheet.budget.period)

    def _block(self, block: BlockDeclaration | IterationDeclaration) -> Iterator[Place]:
        name, target = block.name.text, target_of(block)
        yield Place("wire", name, block.name.position, True, of=name)
        named = block.sheet if isinstance(block, IterationDeclaration) else block.symbol
        yield Place("symbol" if named.text in SYMBOLS else "sheet", named.text, named.position, False, of=name)
        if isinstance(block, IterationDeclaration):
            yield from self._names(block.count, name)
            for connections in (block.carry, block.each, block.common):
                yield from self._connections(connections, target, name)
        else:
            yield from self._connections(block.operands, target, name)
            if block.rate is not None:
                for part in (block.rate.every, block.rate.offset, block.rate.held):
                    yield from self._names(part, name)
        for argument in block.arguments:
            yield Place("argument", argument.name.text, argument.name.position, False, target, name)
            # In a formula of a table, x and y are what is looked up.
            own = ("x", "y") if _is_formula(target, argument.name.text) else ()
            yield from (place for place in self._names(argument.value, name) if place.name not in own)

    def _connections(self, connections: Sequence[Connection], target: str, block: str) -> Iterator[Place]:
        for connection in connections:
            if connection.port is not None:
                yield Place("port", connection.port.text, connection.port.position, False, target, block)
            yield from self._names(connection.wire, block)

    def _names(self, expression: Expression | None, block: str = "") -> Iterator[Place]:
        """The names in an expression."""
        stack: list[Expression | Slice | None] = [expression]
        while stack:
            here = stack.pop()
            match here:
                case Name():
                    kind: Kind = "parameter" if here.text in self.parameters else "wire"
                    if kind == "parameter" or here.text in self.targets or self._is_input(here.text):
                        yield Place(kind, here.text, here.position, False, of=block)
                case Member(base=base):
                    inner = base.base if isinstance(base, Index) else base
                    if isinstance(inner, Name) and inner.text in self.targets and here.name != "T":
                        yield Place("output", here.name, here.position, False, self.targets[inner.text], block)
                    stack.append(base)
                case Index(base=base, indices=indices):
                    stack += [base, *indices]
                case Slice(start=start, stop=stop):
                    stack += [start, stop]
                case Call(arguments=arguments):
                    stack += arguments
                case Unary(operand=operand):
                    stack.append(operand)
                case Binary(left=left, right=right):
                    stack += [left, right]
                case Array(items=items):
                    stack += items

    def _is_input(self, name: str) -> bool:
        return any(port.name.text == name for port in self.sheet.inputs)


def _is_formula(target: str, parameter: str) -> bool:
    """Whether a parameter of a symbol takes a formula."""
    return target in SYMBOLS and any(p.name == parameter and p.kind == "formula" for p in SYMBOLS[target].parameters)


def target_of(block: BlockDeclaration | IterationDeclaration) -> str:
    """The sheet or symbol that a block uses."""
    return (block.sheet if isinstance(block, IterationDeclaration) else block.symbol).text
