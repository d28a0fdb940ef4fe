"""``concatenate``: joins wires into vectors, matrices and stacks. Wiring: costs nothing."""

from __future__ import annotations

from collections.abc import Callable
from typing import ClassVar

import numpy as np

from saoflow.blocks.symbol import (
    Arguments,
    Parameter,
    Port,
    Symbol,
    SymbolProblem,
    connected,
    present,
    word_of,
)
from saoflow.operations import Atom, Expander, Tensor
from saoflow.units import Units, collapse
from saoflow.wires import WireType, shape_text

AXIS = Parameter(
    "axis",
    "word",
    "rows: one after the other (scalars count as one row); columns: side by side; new: a stack",
    ("rows", "columns", "new"),
)


class Concatenate(Symbol[str]):
    """Configured by the axis along which it joins."""

    name: ClassVar[str] = "concatenate"
    summary: ClassVar[str] = "joins wires along an axis; as an operand: [a, b] stacks along a new first axis"
    equation: ClassVar[str] = "y = [u1; u2; ...]"
    glyph: ClassVar[str] = '<path class="stroke" d="M-12-12H-4V12H-12M-4 0H12"/>'
    examples: ClassVar[tuple[str, ...]] = (
        "{concatenate: [x, v]}",
        "{concatenate: [A, B], axis: columns}",
    )
    ports: ClassVar[tuple[Port, ...]] = (Port("u", "a part"),)
    variadic: ClassVar[bool] = True
    parameters: ClassVar[tuple[Parameter, ...]] = (AXIS,)

    def configure(self, arguments: Arguments, signs: tuple[int, ...]) -> str:
        """The axis. Raises SymbolProblem E208."""
        return word_of(arguments, AXIS)

    def output_type(self, inputs: tuple[WireType | None, ...], configuration: str) -> WireType:
        """Raises SymbolProblem E204, E210."""
        wires = present(inputs)
        for i, wire in enumerate(wires):
            if wire.boolean != wires[0].boolean:
                raise SymbolProblem(
                    "E210",
                    "`concatenate` joins wires of one kind",
                    f"operand 1 is {wires[0]}, operand {i + 1} is {wire}",
                    "make all parts real or all boolean",
                    operand=i,
                )
        numbers, start = [], 0
        for wire in wires:
            numbers.append(np.arange(start, start + wire.size).reshape(wire.shape))
            start += wire.size
        joined = _join(numbers, configuration)
        units: Units = wires[0].units
        if any(wire.units != units or isinstance(wire.units, tuple) for wire in wires):
            flat = [u for wire in wires for u in wire.element_units()]
            units = collapse([flat[int(i)] for i in joined.ravel()])
        return WireType(joined.shape, wires[0].boolean, units)

    def expand(self, inputs: tuple[Tensor | None, ...], output: WireType, configuration: str, emit: Expander) -> Tensor:
        """Reorders atoms."""
        atoms: list[Atom] = []
        numbers = []
        for tensor in connected(inputs):
            numbers.append(np.arange(len(atoms), len(atoms) + len(tensor.atoms)).reshape(tensor.shape))
            atoms.extend(tensor.atoms)
        joined = _join(numbers, configuration)
        return Tensor(output.shape, tuple(atoms[int(i)] for i in joined.ravel()))


def _join(parts: list[np.ndarray], axis: str) -> np.ndarray:
    if axis == "new":
        return np.stack(_same(parts, lambda p: p.shape))
    if axis == "columns":
        wide = [p.reshape(-1, 1) if p.ndim < 2 else p for p in parts]
        return np.concatenate(_same(wide, lambda p: (p.shape[0], *p.shape[2:])), axis=1)
    tall = [p.reshape(1) if p.ndim == 0 else p for p in parts]
    return np.concatenate(_same(tall, lambda p: p.shape[1:]), axis=0)


def _same(parts: list[np.ndarray], key: Callable[[np.ndarray], tuple[int, ...]]) -> list[np.ndarray]:
    for i, part in enumerate(parts):
        if key(part) != key(parts[0]):
            raise SymbolProblem(
                "E204",
                "the parts do not join",
                f"operand 1 is {shape_text(parts[0].shape)}, operand {i + 1} is {shape_text(part.shape)}",
                "join along another axis, or make the other axes agree",
                operand=i,
            )
    return parts
