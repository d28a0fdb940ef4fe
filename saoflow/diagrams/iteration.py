"""Laying out ``fold`` and ``map``: the same sheet a fixed number of times."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Protocol

import numpy as np

from saoflow.diagnosis import Position, did_you_mean
from saoflow.diagrams.connections import match, unconnected
from saoflow.diagrams.expression_value import Quantity
from saoflow.diagrams.netlist import Structure
from saoflow.diagrams.operands import Operands
from saoflow.diagrams.scope import Scope
from saoflow.diagrams.sheet import Argument, Connection, IterationDeclaration, Named, Sheet


class Placer(Protocol):
    """The sheet that a fold or map stands in: what it can do for an instance."""

    scope: Scope

    def child(
        self, sheet: Sheet, arguments: Sequence[Argument], used: Named, extra: Mapping[str, Quantity]
    ) -> Structure | None:
        """The structure of an instance, or None after a diagnosis."""
        ...

    def instantiate(
        self,
        path: str,
        position: Position,
        structure: Structure,
        wires_by_port: dict[str, int],
        positions: dict[str, Position],
        outputs: dict[str, int],
    ) -> None:
        """Place an instance between its wires."""
        ...


class Iteration:
    """One fold or map of a sheet."""

    def __init__(self, sheet: Placer, block: IterationDeclaration, target: Sheet) -> None:
        self.user = sheet
        self.scope = sheet.scope
        self.block = block
        self.target = target
        self.instances = sheet.scope.blocks[block.name.text].instances

    def lay_out(self) -> None:
        """Place every instance, in the order in which they run."""
        block, name = self.block, self.block.name.text
        ports = [i.name.text for i in self.target.inputs]
        everything = [*block.carry, *block.each, *block.common]
        matched = match(self.scope, block.sheet, ports, everything)
        carried = self._carried()
        if matched is None or carried is None:
            return
        missing = [p for p in ports if p not in matched]
        if missing:
            unconnected(self.scope, block.sheet, missing)
            return
        count = len(self.instances)
        operands = Operands(self.scope, name)
        common = {_port(c): operands.wire(c.wire) for c in block.common}
        start = {_port(c): operands.wire(c.wire) for c in block.carry}
        positions: dict[str, Position] = {port: expression.position for port, expression in matched.items()}
        order = range(count - 1, -1, -1) if block.reverse else range(count)
        previous: int | None = None
        for i in order:
            structure = self.user.child(
                self.target, block.arguments, block.sheet, {"index": Quantity(np.array(float(i)), None)}
            )
            if structure is None:
                return
            wires = dict(common)
            local = Operands(self.scope, f"{name}[{i}]")
            for connection in block.each:
                wires[_port(connection)] = local.slice_of(connection.wire, i, count)
            for port in carried:
                wires[port] = start[port] if previous is None else self.instances[previous][port]
            self.user.instantiate(f"{name}[{i}]", block.name.position, structure, wires, positions, self.instances[i])
            previous = i

    def _carried(self) -> list[str] | None:
        """The ports that pass from one instance to the next; None after a diagnosis."""
        outputs = [o.name.text for o in self.target.outputs]
        fine = True
        carried = []
        for connection in self.block.carry:
            port = _port(connection)
            carried.append(port)
            if port not in outputs:
                assert connection.port is not None
                self.scope.report(
                    "E203",
                    f"`{self.target.name.text}` has no output `{port}` to carry",
                    connection.port.position,
                    f"each instance takes the previous one's output of that name; the outputs are: {', '.join(outputs)}",
                    did_you_mean(port, outputs) or "give the sheet an output of that name",
                )
                fine = False
        return carried if fine else None


def _port(connection: Connection) -> str:
    assert connection.port is not None
    return connection.port.text
