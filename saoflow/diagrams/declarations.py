"""What a sheet declares: inputs, units, budget."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from saoflow.blocks.symbol import Given
from saoflow.diagnosis import DiagnosisError, Note, Position
from saoflow.diagrams.expression import Expression
from saoflow.diagrams.netlist import Budget, InputPort
from saoflow.diagrams.operands import Operands
from saoflow.diagrams.scope import Scope
from saoflow.diagrams.sheet import BlockDeclaration, IterationDeclaration, Sheet, UnitText
from saoflow.units import Unit, Units, collapse
from saoflow.wires import MOST_ELEMENTS, wrong_unit_count


class Declarations:
    """Reads the declarations of one sheet into its scope."""

    def __init__(self, sheet: Sheet, scope: Scope) -> None:
        self.sheet = sheet
        self.scope = scope

    def inputs(self) -> tuple[InputPort, ...]:
        """Declare the inputs as wires."""
        ports = []
        for declaration in self.sheet.inputs:
            name = declaration.name.text
            if name in self.scope.parameters:
                self._twice(name, declaration.name.position, "a parameter")
            wire = self.scope.new_wire()
            self.scope.inputs[name] = wire
            shape = None if declaration.shape is None else self._shape(declaration.shape)
            units = None if declaration.unit is None else self.units(declaration.unit)
            wrong = "" if shape is None or declaration.unit is None else wrong_unit_count(units, shape)
            if declaration.unit is not None and wrong:
                self.scope.report(
                    "E211",
                    f"the units of `{name}` do not fit its shape",
                    declaration.unit.position,
                    wrong,
                    "give one unit for the whole wire, or one for each element",
                )
                units = None
            ports.append(
                InputPort(name, wire, shape, declaration.boolean, units, declaration.doc, declaration.name.position)
            )
        return tuple(ports)

    def _shape(self, axes: Sequence[Expression]) -> tuple[int, ...] | None:
        sizes = []
        for axis in axes:
            size = Operands(self.scope, "").whole_number(axis, "the size of an axis")
            if size is None:
                return None
            if not 1 <= size <= MOST_ELEMENTS:
                self.scope.report(
                    "E216",
                    "the size of an axis is out of range",
                    axis.position,
                    f"it is {size}, and must lie in 1 to {MOST_ELEMENTS}",
                    "give the number of elements along the axis",
                )
                return None
            sizes.append(size)
        if math.prod(sizes) > MOST_ELEMENTS:
            self.scope.report(
                "E219",
                "the wire is too large",
                axes[0].position,
                f"it has {math.prod(sizes)} elements, and at most {MOST_ELEMENTS} can be laid out one by one",
                "make it smaller",
            )
            return None
        return tuple(sizes)

    def units(self, text: UnitText) -> Units:
        """The declared unit, or one per element."""
        return units_of(self.scope, text)

    def distinct_blocks(self) -> list[BlockDeclaration | IterationDeclaration]:
        """The blocks whose names are not taken by an input or a parameter."""
        distinct = []
        for block in self.sheet.blocks:
            name = block.name.text
            if name in self.scope.inputs:
                self._twice(name, block.name.position, "an input")
            elif name in self.scope.parameters:
                self._twice(name, block.name.position, "a parameter")
            else:
                distinct.append(block)
        return distinct

    def _twice(self, name: str, position: Position, other: str) -> None:
        names = [*(d.name for d in self.sheet.inputs), *(d.name for d in self.sheet.parameters)]
        first = next((n.position for n in names if n.text == name and n.position != position), None)
        self.scope.report(
            "E222",
            f"`{name}` is used twice",
            position,
            f"it is {other} already",
            "rename one of them",
            notes=[Note("it is declared here", first)] if first is not None else [],
        )

    def budget(self) -> Budget | None:
        """The budget in numbers."""
        declared = self.sheet.budget
        if declared is None:
            return None
        limits: list[tuple[str, float]] = []
        for kind, expression in declared.limits:
            value = self._number(expression)
            if value is not None:
                limits.append((kind.text, value))
        period = None if declared.period is None else self._number(declared.period)
        return Budget(tuple(limits), period, declared.position)

    def _number(self, expression: Expression) -> float | None:
        quantity = self.scope.value_of(expression)
        if quantity is None:
            return None
        array = np.asarray(quantity.array if quantity.text is None else np.nan, dtype=np.float64)
        if array.ndim or not array >= 0:
            self.scope.report(
                "E208",
                "a budget needs a number",
                expression.position,
                "it is negative, or no number",
                "write the most that a frame may cost",
            )
            return None
        return float(array)


def units_of(scope: Scope, text: UnitText) -> Units:
    """A declared unit; None after a diagnosis."""
    if not isinstance(text.items, str):
        return collapse(_flatten(scope, text))
    try:
        return Unit.parse(text.items, text.position, scope.sources.line(text.position))
    except DiagnosisError as error:
        scope.found.extend(error.diagnoses)
        return None


def _flatten(scope: Scope, text: UnitText) -> list[Unit | None]:
    if isinstance(text.items, str):
        found = units_of(scope, text)
        return [found] if not isinstance(found, tuple) else list(found)
    return [unit for item in text.items for unit in _flatten(scope, item)]


def unit_of(scope: Scope, items: Sequence[Expression] | None, text: str, position: Position) -> Given | None:
    """The unit given to a symbol: one, or one per axis or element; None after a diagnosis."""
    if items is None:
        units = units_of(scope, UnitText(text, position))
    else:
        units = tuple(_one(units_of(scope, UnitText(scope.sources.word(i.position), i.position))) for i in items)
    return None if units is None else Given(unit=units)


def _one(units: Units) -> Unit | None:
    return units if isinstance(units, Unit) else None
