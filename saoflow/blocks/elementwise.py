"""What element-wise symbols share: one shape for all operands (a scalar serves every element), and one unit."""

from __future__ import annotations

from collections.abc import Sequence

from saoflow.blocks.symbol import SymbolProblem
from saoflow.operations import Atom, Tensor
from saoflow.units import Unit, Units, collapse, conversion_hint, conversion_remedy
from saoflow.wires import WireType, shape_text


def common_shape(inputs: Sequence[WireType | None], symbol: str) -> tuple[int, ...]:
    """The shape of the operands that are not scalars. Raises SymbolProblem E204 if they differ."""
    shape: tuple[int, ...] = ()
    first = 0
    for i, wire in enumerate(inputs):
        if wire is None or not wire.shape:
            continue
        if not shape:
            shape, first = wire.shape, i
        elif wire.shape != shape:
            raise SymbolProblem(
                "E204",
                f"`{symbol}` needs operands of one shape",
                f"operand {first + 1} is {shape_text(shape)}, operand {i + 1} is {shape_text(wire.shape)}",
                "select, transpose or concatenate so that the shapes agree; a scalar fits any shape",
                operand=i,
            )
    return shape


def common_units(inputs: Sequence[WireType | None], shape: tuple[int, ...], symbol: str) -> Units:
    """The unit of each element, which all operands that state one must share. Raises SymbolProblem E211."""
    units: Units = None
    for i, wire in enumerate(inputs):
        if wire is None or wire.units is None:
            continue
        if units is None:
            units = wire.units
        elif wire.units != units:
            size = max(WireType(shape).size, 1)
            merged = [
                _agree(a, b, i, symbol) for a, b in zip(_spread(units, size), _spread(wire.units, size), strict=True)
            ]
            units = collapse(merged)
    return units


def _spread(units: Units, size: int) -> Sequence[Unit | None]:
    if isinstance(units, tuple):
        return units if len(units) == size else units * size
    return (units,) * size


def _agree(a: Unit | None, b: Unit | None, operand: int, symbol: str) -> Unit | None:
    if a is None or b is None:
        return a if b is None else b
    if a != b:
        raise SymbolProblem(
            "E211",
            f"`{symbol}` needs operands of one unit",
            f"{a} meets {b}: {conversion_hint(a, b)}",
            conversion_remedy(b, a),
            operand=operand,
        )
    return a


def element(tensor: Tensor, i: int) -> Atom:
    """The i-th atom; a scalar serves every element."""
    return tensor.atoms[i] if tensor.shape else tensor.atoms[0]
