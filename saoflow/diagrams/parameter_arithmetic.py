"""The arithmetic of parameters: quantities, and what operators and functions do to numbers, shapes and units."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

from saoflow.diagnosis import Diagnosis, DiagnosisError
from saoflow.diagrams.expression import Call, Expression, Slice
from saoflow.units import (
    DIMENSIONLESS,
    Unit,
    Units,
    collapse,
    conversion_hint,
    first_mismatch,
    map_units,
    per_element,
    units_text,
)
from saoflow.wires import shape_text

Numbers = NDArray[np.float64]

LARGEST = 1_000_000
"""Elements that a quantity may have."""


@dataclass(frozen=True, slots=True, eq=False)
class Quantity:
    """Numbers with their unit: the value of a parameter."""

    array: Numbers
    """Shape () for a scalar."""
    unit: Units = None
    """None: not stated; one unit for all elements; or one per element in row-major order."""
    text: str | None = None
    """A word instead of numbers (an option such as ``matrix``); ``array`` is then empty."""
    literal: bool = False
    """Made of plain numbers alone: takes any unit in a sum and none in a product."""


def word(text: str) -> Quantity:
    """A word as a quantity."""
    return Quantity(np.zeros(0), None, text)


def _up(x: Numbers) -> Numbers:
    """Halves away from zero, as one rounds by hand (numpy rounds them to even)."""
    return np.copysign(np.floor(np.abs(x) + 0.5), x)


_KEEP_UNIT: dict[str, Callable[[Numbers], Numbers]] = {
    "abs": np.abs,
    "floor": np.floor,
    "ceil": np.ceil,
    "round": _up,
}
_PLAIN: dict[str, Callable[[Numbers], Numbers]] = {
    "exp": np.exp,
    "log": np.log,
    "sin": np.sin,
    "cos": np.cos,
    "tan": np.tan,
    "asin": np.arcsin,
    "acos": np.arccos,
    "atan": np.arctan,
}
_DOMAINS = {
    "sqrt": "numbers from 0 on",
    "log": "numbers above 0",
    "asin": "numbers from -1 to 1",
    "acos": "numbers from -1 to 1",
}
FUNCTIONS = ("sqrt", *_KEEP_UNIT, *_PLAIN, "min", "max", "zeros", "ones", "eye", "diag")
CONSTANTS: dict[str, Quantity] = {"pi": Quantity(np.array(math.pi), literal=True)}

_OPERATIONS: dict[str, Callable[[Numbers, Numbers], Numbers]] = {
    "+": np.add,
    "-": np.subtract,
    "*": np.multiply,
    "/": np.divide,
    "^": np.power,
    "min": lambda a, b: np.where(a < b, a, b),
    "max": lambda a, b: np.where(a > b, a, b),
}


class Arithmetic:
    """Operators and functions on quantities. What has no value raises DiagnosisError at the node it stands for;
    ``lines`` is the text of the file, to be shown in messages."""

    def __init__(self, lines: Sequence[str]) -> None:
        self.lines = lines

    def error(self, code: str, node: Expression | Slice, message: str, cause: str, remedy: str) -> DiagnosisError:
        """A diagnosis at a node, to be raised."""
        position = node.position
        line = self.lines[position.line - 1] if 0 < position.line <= len(self.lines) else None
        return DiagnosisError([Diagnosis(code, message, position, cause=cause, remedy=remedy, source_line=line)])

    # ------------------------------------------------------------ arithmetic

    def binary(self, node: Expression, operator: str, a: Quantity, b: Quantity) -> Quantity:
        """Element by element; ``min`` and ``max`` of two as well. Raises E209 for shapes, domain and overflow."""
        if a.array.shape and b.array.shape and a.array.shape != b.array.shape:
            raise self.error(
                "E209",
                node,
                "the shapes do not fit",
                f"{shape_text(a.array.shape)} meets {shape_text(b.array.shape)}",
                "both must have one shape, or one of them must be a scalar",
            )
        if operator == "/" and np.any(b.array == 0):
            raise self.error("E209", node, "division by zero", "the divisor is, or contains, 0", "correct it")
        result = np.asarray(_OPERATIONS[operator](a.array, b.array))
        if operator == "^" and np.any((a.array == 0) & (b.array < 0)):
            raise self.error("E209", node, "division by zero", "0 has no negative power", "correct it")
        self.check_finite(node, result, "a negative number has no such power" if operator == "^" else "")
        if operator == "^":
            unit = self.power_unit(node, a, b)
        elif operator in "*/":
            unit = _product_unit(operator, a, b, result.size)
        else:
            unit = self.sum_unit(node, operator, a, b, result.size)
        return Quantity(result, unit, literal=a.literal and b.literal)

    def check_finite(self, node: Expression, result: Numbers, cause: str) -> None:
        """Raise E209 if anything is infinite or no number."""
        if np.all(np.isfinite(result)):
            return
        if np.any(np.isnan(result)):
            raise self.error("E209", node, "the result is not a number", cause or "it is not defined", "correct it")
        raise self.error(
            "E209", node, "the result is too large", "it exceeds 1.8e308, the largest of binary64", "correct it"
        )

    def sum_unit(self, node: Expression, operator: str, a: Quantity, b: Quantity, size: int) -> Units:
        """The unit of a sum, a difference or a comparison. Raises E211 where two stated units differ."""
        clash = first_mismatch(a.unit, b.unit)
        if clash is not None:
            _, x, y = clash
            verb = {"+": "add", "-": "subtract"}.get(operator, "compare")
            raise self.error(
                "E211",
                node,
                f"units do not {verb}",
                f"{x} meets {y}: {conversion_hint(x, y)}",
                f"convert one of them by a factor of unit {x / y} or {y / x}",
            )
        if isinstance(a.unit, tuple) or isinstance(b.unit, tuple):
            pairs = zip(per_element(a.unit, size), per_element(b.unit, size), strict=True)
            return collapse(y if x is None else x for x, y in pairs)
        return b.unit if a.unit is None else a.unit

    def power_unit(self, node: Expression, a: Quantity, b: Quantity) -> Units:
        """The unit of a power: exponents are plain, and simple fractions if the base has a unit."""
        if b.unit is not None and b.unit is not DIMENSIONLESS:
            raise self.error(
                "E211", node, "an exponent has a unit", f"it is in {units_text(b.unit)}", "exponents are plain numbers"
            )
        if a.unit is None or a.unit is DIMENSIONLESS:
            return a.unit
        exponent = float(b.array) if b.array.shape == () else None
        rational = None if exponent is None else Fraction(exponent).limit_denominator(12)
        if rational is None or exponent is None or abs(float(rational) - exponent) > 1e-12 or abs(rational) > 99:
            raise self.error(
                "E211",
                node,
                "the result has no unit",
                f"{units_text(a.unit)} is raised to a power that is no simple fraction",
                "raise plain numbers to such a power",
            )
        return map_units(lambda unit: unit.power(rational), a.unit)

    # ------------------------------------------------------------ functions

    def elementwise(self, node: Call, name: str, x: Quantity) -> Quantity:
        """A function of one argument."""
        unit = x.unit
        if name == "sqrt":
            result = np.sqrt(x.array)
            unit = map_units(lambda u: u.power(Fraction(1, 2)), x.unit)
        elif name in _KEEP_UNIT:
            result = _KEEP_UNIT[name](x.array)
        else:
            clash = first_mismatch(x.unit, DIMENSIONLESS)
            if clash is not None:
                raise self.error(
                    "E211",
                    node,
                    f"`{name}` takes plain numbers",
                    f"its argument is in {clash[1]}: {conversion_hint(clash[1], DIMENSIONLESS)}",
                    f"convert it by a factor of unit {DIMENSIONLESS / clash[1]}",
                )
            result = _PLAIN[name](x.array)
        cause = f"{name} is defined for {_DOMAINS[name]}" if name in _DOMAINS else ""
        if name == "log" and np.any(x.array == 0):
            raise self.error("E209", node, "the result is not a number", cause, "correct it")
        self.check_finite(node, result, cause)
        return Quantity(np.asarray(result), unit, literal=x.literal)

    def extreme(self, node: Call, name: str, arguments: list[Quantity]) -> Quantity:
        """``min`` or ``max`` of several, or of the elements of one."""
        if len(arguments) > 1:
            result = arguments[0]
            for other in arguments[1:]:
                result = self.binary(node, name, result, other)
            return result
        x = arguments[0]
        first: Unit | None = None
        for unit in per_element(x.unit, x.array.size) if isinstance(x.unit, tuple) else (x.unit,):
            if unit is not None and first is not None and unit is not first:
                raise self.error(
                    "E211", node, "units do not compare", f"{first} meets {unit}", "compare values of one unit"
                )
            first = first or unit
        best = x.array.min() if name == "min" else x.array.max()
        return Quantity(np.asarray(best), first, literal=x.literal)

    def diagonal(self, node: Call, x: Quantity) -> Quantity:
        """A vector as a diagonal matrix; the zeros beside it have the unit of the vector if it has one for all."""
        if x.array.ndim != 1:
            raise self.error(
                "E209",
                node,
                "`diag` takes a vector",
                f"its argument is {shape_text(x.array.shape)}",
                "write the elements of the diagonal as a list",
            )
        size = x.array.size
        self.check_size(node, (size, size))
        unit = x.unit
        if isinstance(unit, tuple):
            beside: list[Unit | None] = [None] * (size * size)
            beside[:: size + 1] = unit
            unit = tuple(beside)
        return Quantity(np.diag(x.array), unit, literal=x.literal)

    def check_size(self, node: Expression, shape: tuple[int, ...]) -> None:
        """Raise E209 for more than LARGEST elements."""
        if math.prod(shape) > LARGEST:
            raise self.error(
                "E209",
                node,
                "the result is too large",
                f"{shape_text(shape)} has more than {LARGEST} elements",
                "make it smaller",
            )


def argument_counts(name: str) -> tuple[int, int]:
    """The least and the largest number of arguments of a function."""
    if name in ("min", "max"):
        return 1, 1000
    return (1, 3) if name in ("zeros", "ones") else (1, 1)


def _product_unit(operator: str, a: Quantity, b: Quantity, size: int) -> Units:
    """Plain numbers leave the other's unit; a unit that is not stated makes the product's not stated."""
    a_plain, b_plain = a.literal and a.unit is None, b.literal and b.unit is None
    if a_plain and b_plain:
        return None
    left: Units = DIMENSIONLESS if a_plain else a.unit
    right: Units = DIMENSIONLESS if b_plain else b.unit

    def combine(x: Unit | None, y: Unit | None) -> Unit | None:
        if x is None or y is None:
            return None
        return x * y if operator == "*" else x / y

    if isinstance(left, tuple) or isinstance(right, tuple):
        pairs = zip(per_element(left, size), per_element(right, size), strict=True)
        return collapse(combine(x, y) for x, y in pairs)
    return combine(left, right)
