"""Formulas of one or two variables: what a look-up table approximates.

A small closed tree, so that a formula can be evaluated exactly (exact mode), enclosed rigorously with its
derivatives (``enclosure.py``: the proof of a table's error), and printed. Built by the reader from the text
of a sheet, never by ``eval``.

Evaluation is in IEEE-754 binary64 through numpy's own loops, for one number as for an array, so that both
give the same bits; library functions are then within about 1 ulp (4 ulp by numpy's contract). It never raises
and never warns: outside its domain a formula is NaN, at a pole infinite.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

FUNCTIONS: tuple[str, ...] = ("sqrt", "sin", "cos", "tan", "exp", "log", "asin", "acos", "atan")
"""The functions of one operand, as they are written."""

_BINARY = {"add": ("+", 1), "subtract": ("-", 1), "multiply": ("*", 2), "divide": ("/", 2), "power": ("^", 4)}
_LEAVES = ("x", "y", "constant")
_ARITY = {
    **dict.fromkeys(_LEAVES, 0),
    "negate": 1,
    **dict.fromkeys(FUNCTIONS, 1),
    **dict.fromkeys(_BINARY, 2),
}

OPERATORS: tuple[str, ...] = tuple(_ARITY)
"""The closed set of node kinds."""


class FormulaError(ValueError):
    """The tree is not a formula: unknown operator, wrong number of operands, exponent not constant."""


@dataclass(frozen=True, slots=True)
class Formula:
    """A node of the tree: an operator of :data:`OPERATORS`, its operands, and the number of a ``constant``.

    ``power`` takes a constant as its second operand. Raises :class:`FormulaError` if the node is malformed.
    """

    operator: str
    operands: tuple[Formula, ...] = ()
    value: float | None = None

    def __post_init__(self) -> None:
        arity = _ARITY.get(self.operator)
        if arity is None:
            raise FormulaError(f"`{self.operator}` is not an operator of formulas ({', '.join(OPERATORS)})")
        if len(self.operands) != arity:
            raise FormulaError(f"`{self.operator}` takes {arity} operands, not {len(self.operands)}")
        if (self.operator == "constant") != (self.value is not None):
            raise FormulaError("a constant has a value, and nothing else has")
        if self.value is not None:
            object.__setattr__(self, "value", float(self.value))
            if not math.isfinite(self.value):
                raise FormulaError(f"a constant must be finite, not {self.value}")
        if self.operator == "power" and self.operands[1].operator != "constant":
            raise FormulaError("an exponent must be a constant")

    def __str__(self) -> str:
        return _written(self, 0)

    def __add__(self, other: Formula | float) -> Formula:
        return Formula("add", (self, as_formula(other)))

    def __radd__(self, other: float) -> Formula:
        return Formula("add", (as_formula(other), self))

    def __sub__(self, other: Formula | float) -> Formula:
        return Formula("subtract", (self, as_formula(other)))

    def __rsub__(self, other: float) -> Formula:
        return Formula("subtract", (as_formula(other), self))

    def __mul__(self, other: Formula | float) -> Formula:
        return Formula("multiply", (self, as_formula(other)))

    def __rmul__(self, other: float) -> Formula:
        return Formula("multiply", (as_formula(other), self))

    def __truediv__(self, other: Formula | float) -> Formula:
        return Formula("divide", (self, as_formula(other)))

    def __rtruediv__(self, other: float) -> Formula:
        return Formula("divide", (as_formula(other), self))

    def __neg__(self) -> Formula:
        return Formula("negate", (self,))

    def __pow__(self, exponent: Formula | float) -> Formula:
        return power(self, exponent)


X = Formula("x")
Y = Formula("y")


def as_formula(a: Formula | float) -> Formula:
    """A number as a constant; a formula as it is."""
    return a if isinstance(a, Formula) else Formula("constant", value=a)


def apply(function: str, operand: Formula | float) -> Formula:
    """``function(operand)`` for a name of :data:`FUNCTIONS`; :class:`FormulaError` for any other name."""
    if function not in FUNCTIONS:
        raise FormulaError(f"`{function}` is not a function of formulas ({', '.join(FUNCTIONS)})")
    return Formula(function, (as_formula(operand),))


def power(base: Formula, exponent: Formula | float) -> Formula:
    """``base ^ exponent``; a constant expression (``1/3.5``) is evaluated once, in binary64.

    Raises :class:`FormulaError` if the exponent contains a variable or is not finite.
    """
    exponent = as_formula(exponent)
    if variables(exponent):
        raise FormulaError(f"the exponent {exponent} contains a variable; write exp(exponent * log(base))")
    return Formula("power", (base, as_formula(evaluate(exponent, 0.0))))


def variables(formula: Formula) -> frozenset[str]:
    """The names of the variables that occur: of ``x`` and ``y``."""
    if formula.operator in ("x", "y"):
        return frozenset((formula.operator,))
    return frozenset().union(*(variables(operand) for operand in formula.operands))


NAMED: dict[str, Formula] = {
    **{name: apply(name, X) for name in FUNCTIONS},
    "reciprocal": 1.0 / X,
    "square": Formula("power", (X, as_formula(2.0))),
    "cube": Formula("power", (X, as_formula(3.0))),
    "reciprocal_sqrt": 1.0 / apply("sqrt", X),
}
"""Formulas of one variable that a sheet may call by name (``function: sin``)."""


def _written(formula: Formula, outer: int) -> str:
    """The text, in parentheses where it binds more loosely than ``outer``."""
    operator, operands = formula.operator, formula.operands
    if formula.value is not None:
        text, binds = _number(formula.value), 3 if math.copysign(1.0, formula.value) < 0 else 9
    elif not operands:
        text, binds = operator, 9
    elif operator == "negate":
        text, binds = "-" + _written(operands[0], 3), 3
    elif operator in _BINARY:
        sign, binds = _BINARY[operator]
        # Left-associative but for ^: what stands on the other side needs parentheses at equal binding.
        left, right = (binds + 1, binds) if operator == "power" else (binds, binds + 1)
        gap = "" if operator == "power" else " "
        text = f"{_written(operands[0], left)}{gap}{sign}{gap}{_written(operands[1], right)}"
    else:
        text, binds = f"{operator}({_written(operands[0], 0)})", 9
    return f"({text})" if binds < outer else text


def _number(value: float) -> str:
    return str(int(value)) if value.is_integer() and 0 < abs(value) < 1e15 else repr(value)


_UFUNC: dict[str, np.ufunc] = {
    "add": np.add, "subtract": np.subtract, "multiply": np.multiply, "divide": np.divide, "power": np.power,
    "negate": np.negative, "sqrt": np.sqrt, "sin": np.sin, "cos": np.cos, "tan": np.tan, "exp": np.exp,
    "log": np.log, "asin": np.arcsin, "acos": np.arccos, "atan": np.arctan,
}  # fmt: skip

_QUIET_RANGE: dict[str, tuple[float, float]] = {
    "sqrt": (0.0, math.inf), "sin": (-1e300, 1e300), "cos": (-1e300, 1e300), "tan": (-1e300, 1e300),
    "exp": (-700.0, 700.0), "log": (1e-300, 1e300), "asin": (-1.0, 1.0), "acos": (-1.0, 1.0),
    "atan": (-1e300, 1e300),
}  # fmt: skip
"""Where numpy has nothing to warn about, so that one number needs no (slow) ``errstate``."""

_Scalar = Callable[[float, float], float]
_Array = Callable[[Any, Any], Any]


def evaluate(formula: Formula, x: Any, y: Any = None) -> Any:
    """The formula at a number (gives a ``float``) or at an array (float64, broadcast over x and y).

    A caller that evaluates often compiles once: :func:`compile_scalar`, :func:`compile_array`.
    Raises :class:`FormulaError` if the formula contains ``y`` and none is given.
    """
    if y is None and "y" in variables(formula):
        raise FormulaError(f"{formula} has two variables; y is missing")
    if isinstance(x, np.ndarray) or isinstance(y, np.ndarray):
        return _evaluate_array(_array_node(formula), x, 0.0 if y is None else y)
    return _scalar_node(formula)(float(x), 0.0 if y is None else float(y))


def compile_scalar(formula: Formula) -> Callable[..., float]:
    """A function of one ``float`` (of two if ``y`` occurs); same bits as :func:`compile_array`."""
    node = _scalar_node(formula)
    if "y" in variables(formula):
        return node
    return lambda x: node(x, 0.0)


def compile_array(formula: Formula) -> Callable[..., np.ndarray]:
    """A function of one array (of two if ``y`` occurs), giving float64 of the (broadcast) shape."""
    node = _array_node(formula)
    if "y" in variables(formula):
        return lambda x, y: _evaluate_array(node, x, y)
    return lambda x: _evaluate_array(node, x, 0.0)


def _evaluate_array(node: _Array, x: Any, y: Any) -> np.ndarray:
    x, y = np.asarray(x, dtype=np.float64, order="C"), np.asarray(y, dtype=np.float64, order="C")
    with np.errstate(all="ignore"):
        result = np.asarray(node(x, y), dtype=np.float64)
    shape = np.broadcast_shapes(x.shape, y.shape)
    if result is x or result is y or result.shape != shape:
        # A bare variable must not hand out the caller's own array, nor a constant one number for many.
        return np.array(np.broadcast_to(result, shape))
    return result


def _array_node(formula: Formula) -> _Array:
    operator, value = formula.operator, formula.value
    if operator == "x":
        return lambda x, y: x
    if operator == "y":
        return lambda x, y: y
    if value is not None:
        return lambda x, y: value
    ufunc = _UFUNC[operator]
    a = _array_node(formula.operands[0])
    if len(formula.operands) == 1:
        return lambda x, y: ufunc(a(x, y))
    if operator == "power" and formula.operands[1].value == 2.0:
        return lambda x, y: np.square(a(x, y))
    b = _array_node(formula.operands[1])
    return lambda x, y: ufunc(a(x, y), b(x, y))


def _scalar_node(formula: Formula) -> _Scalar:
    operator, value = formula.operator, formula.value
    if operator == "x":
        return lambda x, y: x
    if operator == "y":
        return lambda x, y: y
    if value is not None:
        return lambda x, y: value
    a = _scalar_node(formula.operands[0])
    if operator == "negate":
        return lambda x, y: -a(x, y)
    if operator == "power":
        exponent = formula.operands[1].value
        assert exponent is not None
        return _scalar_power(a, exponent)
    if len(formula.operands) == 1:
        return _scalar_function(operator, a)
    b = _scalar_node(formula.operands[1])
    if operator == "add":
        return lambda x, y: a(x, y) + b(x, y)
    if operator == "subtract":
        return lambda x, y: a(x, y) - b(x, y)
    if operator == "multiply":
        return lambda x, y: a(x, y) * b(x, y)
    return lambda x, y: _divide(a(x, y), b(x, y))


def _divide(a: float, b: float) -> float:
    """IEEE-754 division, where Python would raise."""
    if b:
        return a / b
    return math.nan if a != a or a == 0.0 else math.copysign(math.inf, a) * math.copysign(1.0, b)


def _scalar_function(operator: str, a: _Scalar) -> _Scalar:
    # Both square roots round correctly; the one in math is faster.
    ufunc = math.sqrt if operator == "sqrt" else _UFUNC[operator]
    low, high = _QUIET_RANGE[operator]

    def call(x: float, y: float) -> float:
        u = a(x, y)
        if low <= u <= high:
            return float(ufunc(u))
        with np.errstate(all="ignore"):
            return float(_UFUNC[operator](u))

    return call


def _scalar_power(a: _Scalar, exponent: float) -> _Scalar:
    if exponent == 2.0:

        def square(x: float, y: float) -> float:
            u = a(x, y)
            return u * u

        return square
    reach = 2.0 ** (900.0 / max(abs(exponent), 1.0))
    low = 1.0 / reach

    def call(x: float, y: float) -> float:
        u = a(x, y)
        if low <= u <= reach:
            return float(np.power(u, exponent))
        with np.errstate(all="ignore"):
            return float(np.power(u, exponent))

    return call
