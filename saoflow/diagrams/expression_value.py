"""Arithmetic on parameters: from an expression and named quantities to a quantity, with units and never with ``eval``.

Everything is element by element; a scalar goes with any shape. Every result is finite, or there is a diagnosis. A
plain number (``2``, ``pi``, ``zeros(n)``) takes the unit of what it is added to and leaves that of what it multiplies;
a quantity whose unit is not stated makes the unit of a product not stated.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from saoflow.diagnosis import did_you_mean
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
from saoflow.diagrams.parameter_arithmetic import (
    CONSTANTS,
    FUNCTIONS,
    Arithmetic,
    Quantity,
    argument_counts,
    word,
)
from saoflow.units import collapse, per_element
from saoflow.wires import shape_text

__all__ = ["CONSTANTS", "FUNCTIONS", "Quantity", "evaluate", "names_in", "word"]


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


class _Evaluator(Arithmetic):
    """Walks the tree; the arithmetic is inherited."""

    def __init__(self, names: Mapping[str, Quantity], lines: Sequence[str]) -> None:
        super().__init__(lines)
        self.names = names

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
        found = self.names.get(node.text)
        if found is not None:
            # A parameter without a unit may stand for anything; only what is written as a number is a plain number.
            return replace(found, literal=False) if found.literal else found
        found = CONSTANTS.get(node.text)
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
        least, most = argument_counts(name)
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
