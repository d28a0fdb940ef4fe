"""``constant``: a fixed number, vector or matrix. Its zeros and ones are structure."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from saoflow.blocks.symbol import Arguments, Parameter, Port, Symbol, SymbolProblem
from saoflow.operations import Expander, Tensor
from saoflow.units import Units
from saoflow.wires import WireType


@dataclass(frozen=True, slots=True, eq=False)
class Value:
    """The number or array, its unit, and whether it means true and false."""

    array: np.ndarray
    units: Units
    boolean: bool = False


class Constant(Symbol[Value]):
    """Configured by its value."""

    name: ClassVar[str] = "constant"
    summary: ClassVar[str] = "a fixed value; costs nothing, and its zeros and ones are left out of products and sums"
    equation: ClassVar[str] = "y = value"
    glyph: ClassVar[str] = '<text class="sign">c</text>'
    examples: ClassVar[tuple[str, ...]] = (
        "{constant: 9.80665, unit: m/s^2}",
        "{constant: [[1, 0], [0, 1]]}",
    )
    ports: ClassVar[tuple[Port, ...]] = ()
    parameters: ClassVar[tuple[Parameter, ...]] = (
        Parameter("value", "array", "the number, vector or matrix"),
        Parameter("unit", "unit", "its unit"),
        Parameter("type", "word", "real, or boolean (then 0 is false and 1 is true)", ("real", "boolean")),
    )

    def configure(self, arguments: Arguments, signs: tuple[int, ...]) -> Value:
        """Raises SymbolProblem E207, E208."""
        given = arguments.get("value")
        if given is None or given.array is None:
            raise SymbolProblem("E207", "a constant needs a value", "none is given", "write {constant: 1.5, unit: kt}")
        if not np.all(np.isfinite(given.array)):
            raise SymbolProblem(
                "E208", "a constant must be finite", "it contains NaN or infinity", "give a finite number"
            )
        boolean = "type" in arguments and arguments["type"].word == "boolean"
        if boolean and not np.all((given.array == 0) | (given.array == 1)):
            raise SymbolProblem(
                "E210",
                "a boolean constant is 0 or 1",
                f"it is {given.array}",
                "write 0 for false, 1 for true",
            )
        units = arguments["unit"].unit if "unit" in arguments else given.unit
        return Value(given.array, units, boolean)

    def glyph_of(self, configuration: Value) -> str:
        """The number, or the shape of what is no number."""
        array = configuration.array
        shown = f"{float(array):.4g}" if array.ndim == 0 else "×".join(map(str, array.shape))
        return f'<text class="word">{shown}</text>'

    def output_type(self, inputs: tuple[WireType | None, ...], configuration: Value) -> WireType:
        """The shape of the value."""
        return WireType(configuration.array.shape, configuration.boolean, configuration.units)

    def expand(
        self, inputs: tuple[Tensor | None, ...], output: WireType, configuration: Value, emit: Expander
    ) -> Tensor:
        """Literals."""
        values = np.ravel(configuration.array)
        return Tensor(
            output.shape,
            tuple(emit.literal(bool(v) if configuration.boolean else float(v)) for v in values),
        )
