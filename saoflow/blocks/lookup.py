"""``lookup``: a table in one or two dimensions, from data or from a function with a proved error."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from saoflow.blocks.elementwise import common_shape, element
from saoflow.blocks.symbol import (
    Arguments,
    Parameter,
    Port,
    Symbol,
    SymbolProblem,
    connected,
    need_real,
    present,
    word_of,
)
from saoflow.operations import Expander, Table, Tensor
from saoflow.tables.tabulate import TabulateError, tabulate
from saoflow.units import Unit, conversion_hint
from saoflow.wires import WireType, shape_text

INTERPOLATION = Parameter(
    "interpolation",
    "word",
    "linear between breakpoints, or hold the value at the left one",
    ("linear", "hold"),
)
DIMENSIONLESS = Unit.parse("1")


@dataclass(frozen=True, slots=True)
class TableUse:
    """The table and the units of its inputs (None: unchecked) and of its output."""

    table: Table
    input_units: tuple[Unit | None, ...]
    output_unit: Unit | None


class Lookup(Symbol[TableUse]):
    """Outside its breakpoints it holds the end value; NaN gives the first value."""

    name: ClassVar[str] = "lookup"
    summary: ClassVar[str] = (
        "table look-up, linear or hold-left; from data, or from a function with a proved largest error"
    )
    equation: ClassVar[str] = "y = table(min(max(u, first), last))"
    glyph: ClassVar[str] = '<path class="stroke" d="M-16 14V-14M-16 14H16"/><path class="curve" d="M-14 11L-4 6L4-6L14-10"/>'
    examples: ClassVar[tuple[str, ...]] = (
        "{lookup: x, function: sin, range: [0, 1], error: 1e-4}",
        "{lookup: x, breakpoints: [0, 1, 3], values: [5, 6, 6.5]}",
    )
    ports: ClassVar[tuple[Port, ...]] = (
        Port("u", "input along the first axis"),
        Port("v", "input along the second axis", optional=True),
    )
    parameters: ClassVar[tuple[Parameter, ...]] = (
        Parameter("breakpoints", "array", "data: increasing breakpoints of the first axis"),
        Parameter("columns", "array", "data: increasing breakpoints of the second axis"),
        Parameter("values", "array", "data: one value per breakpoint, or a matrix"),
        Parameter("function", "formula", "a named function (sin) or a formula in x (and y): (1 + x)^3.5 - 1"),
        Parameter("range", "array", "function: [low, high], or one such pair per axis"),
        Parameter("error", "array", "function: the largest absolute error allowed"),
        Parameter("relative_error", "array", "function: the largest relative error allowed"),
        INTERPOLATION,
        Parameter("input_unit", "unit", "unit of the input; one per axis as [rad, kt]"),
        Parameter("unit", "unit", "unit of the output"),
    )

    def configure(self, arguments: Arguments, signs: tuple[int, ...]) -> TableUse:
        """Raises SymbolProblem E208, E214, E215, E223."""
        linear = word_of(arguments, INTERPOLATION) == "linear"
        if ("function" in arguments) == ("values" in arguments):
            both = "function" in arguments
            raise SymbolProblem(
                "E215",
                "a table needs either data or a function",
                "both are given" if both else "neither is given",
                "give breakpoints and values, or function, range and error",
            )
        from_function = "function" in arguments
        table = _function_table(arguments, linear) if from_function else _data_table(arguments, linear)
        axes = len(table.breakpoints)
        given = arguments["input_unit"].unit if "input_unit" in arguments else None
        plain = DIMENSIONLESS if from_function else None
        units = given if isinstance(given, tuple) else ((given or plain),) * axes
        if len(units) != axes:
            raise SymbolProblem(
                "E215",
                "one input unit per axis is needed",
                f"the table has {axes} axes, {len(units)} units are given",
                "write input_unit: kt, or input_unit: [rad, kt]",
                parameter="input_unit",
            )
        output = arguments["unit"].unit if "unit" in arguments else plain
        return TableUse(table, units, output if not isinstance(output, tuple) else None)

    def glyph_of(self, configuration: TableUse) -> str:
        """The table's own curve; of two axes, its first, middle and last row."""
        table = configuration.table
        rows = table.values.reshape(1, -1) if table.values.ndim == 1 else table.values.T[[0, table.values.shape[1] // 2, -1]]
        return '<path class="stroke" d="M-17 15V-15M-17 15H17"/>' + "".join(
            _curve(table.breakpoints[0], row, float(rows.min()), float(rows.max()), table.linear) for row in rows
        )

    def output_type(self, inputs: tuple[WireType | None, ...], configuration: TableUse) -> WireType:
        """The common shape of the inputs. Raises SymbolProblem E205, E211."""
        need_real(inputs, self.name)
        axes = len(configuration.table.breakpoints)
        wires = present(inputs)
        if len(wires) != axes:
            raise SymbolProblem(
                "E221",
                f"the table has {axes} {'axis' if axes == 1 else 'axes'}",
                f"{len(wires)} {'input is' if len(wires) == 1 else 'inputs are'} connected",
                "connect one input per axis",
            )
        for i, (wire, unit) in enumerate(zip(wires, configuration.input_units, strict=True)):
            for found in wire.element_units():
                if unit is not None and found is not None and found != unit:
                    raise SymbolProblem(
                        "E211",
                        "the table's input has another unit",
                        f"the wire is in {found}, the table takes {unit}: {conversion_hint(found, unit)}",
                        f"convert the wire, or state input_unit: {found} if the table is meant for it",
                        operand=i,
                    )
        return WireType(common_shape(inputs, self.name), False, configuration.output_unit)

    def expand(
        self, inputs: tuple[Tensor | None, ...], output: WireType, configuration: TableUse, emit: Expander
    ) -> Tensor:
        """One look-up per element."""
        operands = connected(inputs)
        atoms = (emit.lookup(configuration.table, *(element(u, i) for u in operands)) for i in range(output.size))
        return Tensor(output.shape, tuple(atoms))


def _curve(x: np.ndarray, y: np.ndarray, low: float, high: float, linear: bool) -> str:
    """A row of a table as a path inside the glyph, of at most 25 points."""
    which = np.unique(np.linspace(0, len(x) - 1, min(len(x), 25)).round().astype(int))
    across = (x[which] - x[0]) / (x[-1] - x[0]) * 30.0 - 15.0
    up = 12.0 - (y[which] - low) / ((high - low) or 1.0) * 24.0
    steps = [f"M{across[0]:.1f} {up[0]:.1f}"]
    for a, b in zip(across[1:], up[1:], strict=True):
        steps.append(f"L{a:.1f} {b:.1f}" if linear else f"H{a:.1f}V{b:.1f}")
    return f'<path class="curve" d="{"".join(steps)}"/>'


def _function_table(arguments: Arguments, linear: bool) -> Table:
    given = arguments["function"]
    if given.formula is None:
        raise SymbolProblem(
            "E208",
            "`function` is not a formula",
            "nothing to evaluate",
            "write function: sin",
            parameter="function",
        )
    relative = "relative_error" in arguments
    if relative == ("error" in arguments):
        raise SymbolProblem(
            "E215",
            "a function's table needs its largest error",
            "both error and relative_error are given" if relative else "neither error nor relative_error is given",
            "write error: 1e-4, or relative_error: 1e-4",
        )
    error = _number(arguments, "relative_error" if relative else "error")
    limits = arguments["range"].array if "range" in arguments else None
    if limits is None or limits.size % 2 or limits.ndim not in (1, 2):
        raise SymbolProblem(
            "E215",
            "a function's table needs its range",
            "range is missing, or is no pair of numbers",
            "write range: [-0.5, 0.5]",
        )
    pairs = tuple((float(a), float(b)) for a, b in limits.reshape(-1, 2))
    try:
        return tabulate(given.word, given.formula, pairs, error=error, relative=relative, linear=linear)
    except TabulateError as problem:
        raise SymbolProblem(
            problem.code, problem.message, problem.cause, problem.remedy, parameter="function"
        ) from None


def _number(arguments: Arguments, name: str) -> float:
    array = arguments[name].array
    if array is None or array.ndim:
        raise SymbolProblem("E208", f"`{name}` must be one number", "it is not", f"write {name}: 1e-4", parameter=name)
    return float(array)


def _data_table(arguments: Arguments, linear: bool) -> Table:
    axes = [name for name in ("breakpoints", "columns") if name in arguments]
    if "breakpoints" not in axes:
        raise SymbolProblem(
            "E215", "the table has no breakpoints", "values alone say nothing", "give breakpoints: [0, 1, 2]"
        )
    breakpoints = tuple(_axis(arguments, name) for name in axes)
    values = arguments["values"].array
    expected = tuple(b.size for b in breakpoints)
    if values is None or values.shape != expected or not np.all(np.isfinite(values)):
        shown = "missing" if values is None else f"{list(values.shape)}"
        cause = f"values is {shown}, the breakpoints ask for {list(expected)}"
        if values is not None and values.shape == expected:
            cause = "values contains NaN or infinity"
        raise SymbolProblem(
            "E215",
            "the table's values do not fit its breakpoints",
            cause,
            "give one finite value per breakpoint (a row per breakpoint, for two axes)",
            parameter="values",
        )
    return Table("data", breakpoints, values.astype(np.float64), linear)


def _axis(arguments: Arguments, name: str) -> np.ndarray:
    array = arguments[name].array
    if array is None or array.ndim != 1 or array.size < 2 or not np.all(np.isfinite(array)):
        raise SymbolProblem(
            "E215",
            f"`{name}` must be a list of at least two finite numbers",
            "it is missing" if array is None else _listed(array),
            f"write {name}: [0, 1, 2]",
            parameter=name,
        )
    steps = np.diff(array)
    if np.any(steps <= 0):
        i = int(np.argmax(steps <= 0))
        raise SymbolProblem(
            "E214",
            f"`{name}` does not increase",
            f"{array[i]:g} is followed by {array[i + 1]:g} (number {i + 2} of {array.size})",
            "sort the breakpoints, and leave out repeated ones",
            parameter=name,
        )
    return array.astype(np.float64)


def _listed(array: np.ndarray) -> str:
    if array.ndim != 1:
        return f"it is {shape_text(array.shape)}"
    return "it has 1 element" if array.size == 1 else "it holds what is not finite"
