"""Arithmetic on parameters: from an expression and named quantities to a quantity, with units and never with ``eval``.

Everything is element by element; a scalar goes with any shape. Every result is finite, or there is a diagnosis. A
plain number (``2``, ``pi``, ``zeros(n)``) takes the unit of what it is added to and leaves that of what it multiplies;
a quantity whose unit is not stated makes the unit of a product not stated.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

from saoflow.diagnosis import Diagnosis, DiagnosisError, did_you_mean
from saoflow.diagrams.expression import (
    Array,
    Binary,
    Call,
    Expression,
    Index,
    Member,
    Name,
    Number,
    Slice,
    Text,
    Unary,
)
from saoflow.diagrams.expression_parser import children
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


def evaluate(expression: Expression, names: Mapping[str, Quantity], lines: Sequence[str] = ()) -> Quantity:
    """The value of an expression.

    ``names`` gives the parameters in sight; ``lines`` the text of the file that the expression stands in, to be shown
    in messages. Raises DiagnosisError: E206 unknown name, E209 what has no value, E211 units, E217 indices.
    """
    with np.errstate(all="ignore"):
        return _Evaluator(names, lines).value(expression)


def names_in(expression: Expression) -> Iterator[Name]:
    """Every name in an expression from left to right, without the names of functions and members."""
    stack: list[Expression | Slice] = [expression]
    while stack:
        node = stack.pop()
        if isinstance(node, Name):
            yield node
        else:
            stack.extend(reversed(children(node)))


# ---------------------------------------------------------------- functions


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


def shape_text(shape: tuple[int, ...]) -> str:
    """``[4, 3]``, or ``a scalar``."""
    return f"[{', '.join(map(str, shape))}]" if shape else "a scalar"


class _Evaluator:
    def __init__(self, names: Mapping[str, Quantity], lines: Sequence[str]) -> None:
        self.names = names
        self.lines = lines

    def error(self, code: str, node: Expression | Slice, message: str, cause: str, remedy: str) -> DiagnosisError:
        position = node.position
        line = self.lines[position.line - 1] if 0 < position.line <= len(self.lines) else None
        return DiagnosisError([Diagnosis(code, message, position, cause=cause, remedy=remedy, source_line=line)])

    # ------------------------------------------------------------ nodes

    def value(self, node: Expression) -> Quantity:
        match node:
            case Number():
                return Quantity(np.array(node.value), literal=True)
            case Name():
                return self.name(node)
            case Unary():
                inner = self.number(node.operand)
                return inner if node.operator == "+" else replace(inner, array=np.negative(inner.array))
            case Binary():
                return self.binary(node, node.operator, self.number(node.left), self.number(node.right))
            case Call():
                return self.call(node)
            case Array():
                return self.array(node)
            case Index():
                return self.index(node)
            case Member():
                return self.member(node)
            case Text():
                return word(node.text)

    def number(self, node: Expression) -> Quantity:
        """The value of a part that must not be a word."""
        value = self.value(node)
        if value.text is not None:
            raise self.error(
                "E209", node, f"`{value.text}` is a word, not a number", "arithmetic needs numbers", "give it a number"
            )
        return value

    def name(self, node: Name) -> Quantity:
        found = self.names.get(node.text) or CONSTANTS.get(node.text)
        if found is None:
            known = [*self.names, *CONSTANTS]
            remedy = did_you_mean(node.text, known)
            if node.text in FUNCTIONS:
                remedy = f"`{node.text}` is a function: write {node.text}(...)"
            raise self.error(
                "E206",
                node,
                f"unknown parameter `{node.text}`",
                "the names known here are " + ", ".join(known[:20]) + (", ..." if len(known) > 20 else ""),
                remedy or f"declare it under `parameters:`, or give `{node.text}` a value",
            )
        return found

    def array(self, node: Array) -> Quantity:
        """Items of one shape, stacked along a new leading axis."""
        if not node.items:
            raise self.error("E209", node, "an empty list has no value", "a wire has at least one element", "fill it")
        if all(type(item) is Number for item in node.items):  # the long lists: tables
            numbers = np.array([item.value for item in node.items if type(item) is Number])
            return Quantity(numbers, literal=True)
        items = [self.number(item) for item in node.items]
        shape = items[0].array.shape
        for item, source in zip(items, node.items, strict=True):
            if item.array.shape != shape:
                raise self.error(
                    "E209",
                    source,
                    "the rows of a list differ in shape",
                    f"the first is {shape_text(shape)}, this one {shape_text(item.array.shape)}",
                    "make all of one shape",
                )
        stacked = np.stack([item.array for item in items])
        self.check_size(node, stacked.shape)
        units = collapse(unit for item in items for unit in per_element(item.unit, item.array.size))
        return Quantity(stacked, units, literal=all(item.literal for item in items))

    def member(self, node: Member) -> Quantity:
        base = self.number(node.base)
        if node.name != "T":
            raise self.error(
                "E209",
                node,
                f"`.{node.name}` has no meaning for a parameter",
                "parameters have no outputs; only `.T`, the transpose, may follow them",
                "remove it",
            )
        if base.array.ndim < 2:
            return base
        if base.array.ndim > 2:
            raise self.error(
                "E209",
                node,
                "only a matrix has a transpose",
                f"this is {shape_text(base.array.shape)}",
                "select one matrix",
            )
        return self.taken(base, np.arange(base.array.size).reshape(base.array.shape).T)

    def taken(self, base: Quantity, flat: NDArray[np.intp]) -> Quantity:
        """The elements of ``base`` whose row-major numbers are ``flat``, in its shape."""
        unit = base.unit
        if isinstance(unit, tuple):
            unit = collapse(unit[i] for i in flat.ravel())
        return replace(base, array=base.array.ravel()[flat], unit=unit)

    # ------------------------------------------------------------ brackets

    def index(self, node: Index) -> Quantity:
        base = self.number(node.base)
        shape = base.array.shape
        if len(node.indices) > len(shape):
            raise self.error(
                "E217",
                node,
                "there are more indices than axes",
                f"{len(node.indices)} stand in the brackets; the value is {shape_text(shape)}",
                "remove some",
            )
        picks = tuple(self.pick(part, size) for part, size in zip(node.indices, shape, strict=False))
        return self.taken(base, np.asarray(np.arange(base.array.size).reshape(shape)[picks]))

    def pick(self, part: Expression | Slice, size: int) -> int | slice:
        """One index or slice of an axis, checked against its size."""
        if not isinstance(part, Slice):
            return self.bound(part, -size, size - 1, size)
        start = 0 if part.start is None else self.bound(part.start, -size, size, size)
        stop = size if part.stop is None else self.bound(part.stop, -size, size, size)
        start, stop = (start + size if start < 0 else start), (stop + size if stop < 0 else stop)
        if start >= stop:
            raise self.error(
                "E217",
                part,
                "the slice is empty",
                f"it runs from {start} up to {stop}, not included",
                "correct its ends",
            )
        return slice(start, stop)

    def bound(self, node: Expression, low: int, high: int, size: int) -> int:
        number = self.whole(node, "an index")
        if not low <= number <= high:
            raise self.error(
                "E217",
                node,
                f"the index {number} is out of range",
                f"the axis has {size} elements, numbered from 0; negative numbers count from the end",
                f"write a number from {low} to {high}",
            )
        return number

    def whole(self, node: Expression, what: str) -> int:
        value = self.number(node)
        if value.array.shape != () or value.array != np.floor(value.array):
            shown = shape_text(value.array.shape) if value.array.shape else f"{float(value.array):g}"
            raise self.error("E209", node, f"{what} must be a whole number", f"it is {shown}", "correct it")
        return int(value.array)

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
        self.check_finite(node, result, "a negative number has no such power" if operator == "^" else "")
        if operator == "^":
            unit = self.power_unit(node, a, b)
        elif operator in "*/":
            unit = _product_unit(operator, a, b, result.size)
        else:
            unit = self.sum_unit(node, operator, a, b, result.size)
        return Quantity(result, unit, literal=a.literal and b.literal)

    def check_finite(self, node: Expression, result: Numbers, cause: str) -> None:
        if np.all(np.isfinite(result)):
            return
        if np.any(np.isnan(result)):
            raise self.error("E209", node, "the result is not a number", cause or "it is not defined", "correct it")
        raise self.error(
            "E209", node, "the result is too large", "it exceeds 1.8e308, the largest of binary64", "correct it"
        )

    def sum_unit(self, node: Expression, operator: str, a: Quantity, b: Quantity, size: int) -> Units:
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

    def call(self, node: Call) -> Quantity:
        name = node.function.text
        if name not in FUNCTIONS:
            raise self.error(
                "E209",
                node.function,
                f"unknown function `{name}`",
                "the functions are " + ", ".join(FUNCTIONS),
                did_you_mean(name, FUNCTIONS) or "use one of them",
            )
        least, most = _argument_counts(name)
        if not least <= len(node.arguments) <= most:
            wanted = f"{least}" if least == most else f"{least} or more" if most > 9 else f"{least} or {most}"
            raise self.error(
                "E209",
                node,
                f"wrong number of arguments for `{name}`",
                f"it takes {wanted}, {len(node.arguments)} are given",
                "correct the arguments",
            )
        if name in ("zeros", "ones", "eye"):
            return self.filled(node, name)
        arguments = [self.number(argument) for argument in node.arguments]
        if name == "diag":
            return self.diagonal(node, arguments[0])
        if name in ("min", "max"):
            return self.extreme(node, name, arguments)
        return self.elementwise(node, name, arguments[0])

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

    def filled(self, node: Call, name: str) -> Quantity:
        """``zeros(n[, m])``, ``ones(n[, m])``, ``eye(n)``."""
        sizes = tuple(self.whole(argument, "a size") for argument in node.arguments)
        for size, argument in zip(sizes, node.arguments, strict=True):
            if size < 1:
                raise self.error("E209", argument, "a size must be positive", f"it is {size}", "correct it")
        if name == "eye":
            sizes *= 2
        self.check_size(node, sizes)
        array = np.eye(sizes[0]) if name == "eye" else np.full(sizes, 0.0 if name == "zeros" else 1.0)
        return Quantity(array, literal=True)

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
        if math.prod(shape) > LARGEST:
            raise self.error(
                "E209",
                node,
                "the result is too large",
                f"{shape_text(shape)} has more than {LARGEST} elements",
                "make it smaller",
            )


def _argument_counts(name: str) -> tuple[int, int]:
    if name in ("min", "max"):
        return 1, 1000
    return (1, 3) if name in ("zeros", "ones") else (1, 1)


def _product_unit(operator: str, a: Quantity, b: Quantity, size: int) -> Units:
    """Plain numbers leave the other's unit; a unit that is not stated makes the product's not stated."""
    left: Units = DIMENSIONLESS if a.literal else a.unit
    right: Units = DIMENSIONLESS if b.literal else b.unit
    if a.literal and b.literal:
        return None

    def combine(x: Unit | None, y: Unit | None) -> Unit | None:
        if x is None or y is None:
            return None
        return x * y if operator == "*" else x / y

    if isinstance(left, tuple) or isinstance(right, tuple):
        pairs = zip(per_element(left, size), per_element(right, size), strict=True)
        return collapse(combine(x, y) for x, y in pairs)
    return combine(left, right)
