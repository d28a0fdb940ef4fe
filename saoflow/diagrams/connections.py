"""Matching the operands of a block with the ports of its symbol or sheet."""

from __future__ import annotations

from collections.abc import Collection, Sequence

from saoflow.blocks.library import AnySymbol
from saoflow.diagnosis import Position, did_you_mean
from saoflow.diagrams.expression import Expression
from saoflow.diagrams.operands import Operands
from saoflow.diagrams.scope import Scope
from saoflow.diagrams.sheet import Argument, BlockDeclaration, Connection, Named

SymbolOperands = tuple[tuple[int, ...], tuple[int | None, ...], tuple[Position | None, ...]]
"""Signs (of a sum), wires and positions, by port."""


def split_arguments(block: BlockDeclaration, ports: Collection[str]) -> tuple[list[Connection], list[Argument]]:
    """The connections of a block (its operands, and keys that name a port) and its parameters."""
    connections = list(block.operands)
    arguments: list[Argument] = []
    for argument in block.arguments:
        if argument.name.text in ports and argument.value is not None:
            connections.append(Connection(argument.name, argument.value))
        else:
            arguments.append(argument)
    return connections, arguments


def symbol_operands(
    scope: Scope, symbol: AnySymbol, used: Named, connections: Sequence[Connection], operands: Operands
) -> SymbolOperands | None:
    """Signs, wires and positions by port; None after a diagnosis."""
    ports = symbol.ports
    if symbol.variadic:
        named = [c.port for c in connections if c.port is not None and c.port.text != ports[-1].name]
        for port in named:
            scope.report(
                "E203",
                f"`{symbol.name}` has no input `{port.text}`",
                port.position,
                "its operands have no names of their own",
                f"write a list: {{{symbol.name}: [a, b]}}",
            )
        pairs = [
            operands.signed_wire(c.wire) if symbol.takes_signs else (1, operands.wire(c.wire)) for c in connections
        ]
        if not pairs:
            scope.report(
                "E221",
                f"`{symbol.name}` needs operands",
                used.position,
                "none is given",
                f"write {{{symbol.name}: [a, b]}}",
            )
            return None
        places = tuple(c.wire.position for c in connections)
        return None if named else (tuple(s for s, _ in pairs), tuple(w for _, w in pairs), places)
    byport = match(scope, used, [p.name for p in ports], connections)
    if byport is None:
        return None
    missing = [p.name for p in ports if p.name not in byport and not p.optional]
    if missing:
        unconnected(scope, used, missing)
        return None
    return (
        (),
        tuple(operands.wire(byport[p.name]) if p.name in byport else None for p in ports),
        tuple(byport[p.name].position if p.name in byport else None for p in ports),
    )


def match(
    scope: Scope, target: Named, ports: list[str], connections: Sequence[Connection]
) -> dict[str, Expression] | None:
    """Connections by port name; None after a diagnosis."""
    found: dict[str, Expression] = {}
    fine = True
    for i, connection in enumerate(connections):
        position = connection.port.position if connection.port else connection.wire.position
        if connection.port is None and i >= len(ports):
            scope.report(
                "E221",
                f"`{target.text}` takes {len(ports)} operand{'' if len(ports) == 1 else 's'}",
                position,
                f"{sum(c.port is None for c in connections)} are given; its inputs are: {', '.join(ports) or 'none'}",
                "leave out those that are too many",
            )
            return None
        port = connection.port.text if connection.port else ports[i]
        if port not in ports:
            scope.report(
                "E203",
                f"`{target.text}` has no input `{port}`",
                position,
                f"its inputs are: {', '.join(ports) or 'none'}",
                did_you_mean(port, ports) or "name one of them",
            )
            fine = False
        elif port in found:
            scope.report(
                "E222", f"input `{port}` is connected twice", position, "an input takes one wire", "leave one out"
            )
            fine = False
        else:
            found[port] = connection.wire
    return found if fine else None


def unconnected(scope: Scope, target: Named, missing: Sequence[str]) -> None:
    """Diagnose inputs without a wire."""
    plural = "s" if len(missing) > 1 else ""
    scope.report(
        "E205",
        f"input{plural} {', '.join(f'`{m}`' for m in missing)} of `{target.text}` {'are' if plural else 'is'} not connected",
        target.position,
        "every input needs a wire",
        f"connect {'them' if plural else 'it'}: {{{target.text}: {{{missing[0]}: wire}}}}",
    )
