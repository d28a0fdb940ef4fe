"""Rigorous enclosures of a formula and its derivatives over intervals: the ground of a table's proved error.

Taylor arithmetic with the balls of Arb (F. Johansson, IEEE Trans. Computers 66, 2017), through python-flint.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

from saoflow.formula import Formula

PRECISION = 80
"""Bits of the ball arithmetic: its own rounding stays far below that of binary64."""

Interval = tuple[float, float]
"""A closed interval, its ends in binary64; infinite where nothing could be enclosed."""

UNBOUNDED: Interval = (-math.inf, math.inf)


@dataclass(frozen=True, slots=True)
class Jet:
    """Enclosures of f and its derivatives over an interval of x (for two variables: along x)."""

    value: Interval
    first: Interval
    second: Interval
    third: Interval
    second_at_middle: Interval
    """Of the second derivative at the middle of the interval alone."""


@dataclass(frozen=True, slots=True)
class Jet2:
    """Enclosures of f and its partial derivatives over a rectangle."""

    value: Interval
    first_x: Interval
    first_y: Interval
    second_xx: Interval
    second_yy: Interval


@lru_cache(maxsize=1)
def flint() -> Any:
    """python-flint, imported when a table is first proved; an import inside the loops costs more than what they do."""
    import flint as library

    return library


@contextmanager
def ball_arithmetic(terms: int = 4) -> Iterator[None]:
    """Set python-flint's working precision and number of Taylor terms, and restore them afterwards."""
    ctx = flint().ctx

    precision, cap = ctx.prec, ctx.cap
    ctx.prec, ctx.cap = PRECISION, terms
    try:
        yield
    finally:
        ctx.prec, ctx.cap = precision, cap


def enclose(formula: Formula, x: Interval, y: Interval | None = None) -> Jet:
    """Rigorous enclosures of f and its derivatives (along x) for every x in the interval, every y in its interval.

    Each is intersected with its mean-value form (Moore, Kearfott, Cloud, Introduction to Interval Analysis,
    2009), which loses little over a short interval. An enclosure is (-inf, inf) where the formula
    is singular or leaves its domain. Call it inside :func:`ball_arithmetic`.
    """
    return Jet(*_along(formula, x, y, 1, 0))


def enclose_2d(formula: Formula, x: Interval, y: Interval) -> Jet2:
    """As :func:`enclose`, along both axes, over a rectangle."""
    value_x, first_x, second_x, _, _ = _along(formula, x, y, 1, 0)
    value_y, first_y, second_y, _, _ = _along(formula, x, y, 0, 1)
    value = (max(value_x[0], value_y[0]), min(value_x[1], value_y[1]))
    return Jet2(value, first_x, first_y, second_x, second_y)


def enclose_mixed(formula: Formula, x: Interval, y: Interval) -> Interval:
    """A rigorous enclosure of f_xy over a rectangle, by polarisation: 4 f_xy = f_(1,1) - f_(1,-1)."""
    plus, minus = _along(formula, x, y, 1, 1)[2], _along(formula, x, y, 1, -1)[2]
    return _outward(0.25 * (plus[0] - minus[1]), 0.25 * (plus[1] - minus[0]))


def value_ball(formula: Formula, x: float, y: float = 0.0) -> Any:
    """The value at a point as a ball of python-flint; not finite where the formula is singular."""
    arb, arb_series = flint().arb, flint().arb_series

    try:
        return _series(formula, arb_series([arb(x)]), arb_series([arb(y)]))[0]
    except (ValueError, ZeroDivisionError):
        return arb.nan()


def _along(formula: Formula, x: Interval, y: Interval | None, dx: int, dy: int) -> tuple[Interval, ...]:
    """Enclosures along the direction (dx, dy): of f and its first three derivatives, and of f'' at the middle."""
    arb, arb_series = flint().arb, flint().arb_series

    box_x, box_y = arb(x[0]).union(arb(x[1])), arb(0) if y is None else arb(y[0]).union(arb(y[1]))
    # The mean-value form goes along one axis: the other variable stays a ball in both.
    mid_x, mid_y = (box_x.mid() if dx else box_x), (box_y.mid() if dy else box_y)
    try:
        wide = _series(formula, arb_series([box_x, dx]), arb_series([box_y, dy]))
    except (ValueError, ZeroDivisionError):
        return (UNBOUNDED,) * 5
    found = [_interval(wide[i] * _FACTORIAL[i]) for i in range(4)]
    if dx and dy:
        return (*found, UNBOUNDED)
    try:
        centre = _series(formula, arb_series([mid_x, dx]), arb_series([mid_y, dy]))
    except (ValueError, ZeroDivisionError):
        return (*found, UNBOUNDED)
    offset = box_x - mid_x if dx else box_y - mid_y
    for i in range(3):
        mean = _interval((centre[i] + (i + 1) * wide[i + 1] * offset) * _FACTORIAL[i])
        found[i] = (max(found[i][0], mean[0]), min(found[i][1], mean[1]))
    return (*found, _interval(centre[2] * 2))


_FACTORIAL = (1, 1, 2, 6)


def _interval(ball: Any) -> Interval:
    """The ends of a ball, rounded outward."""
    return _outward(float(ball.lower()), float(ball.upper())) if ball.is_finite() else UNBOUNDED


def _outward(low: float, high: float) -> Interval:
    if not (math.isfinite(low) and math.isfinite(high)):
        return UNBOUNDED
    return math.nextafter(low, -math.inf), math.nextafter(high, math.inf)


def _series(formula: Formula, x: Any, y: Any) -> Any:
    """The formula's Taylor series, given those of its variables. Raises ValueError at a division by zero."""
    arb = flint().arb

    operator, operands = formula.operator, formula.operands
    if operator == "x":
        return x
    if operator == "y":
        return y
    if formula.value is not None:
        return x * 0 + arb(formula.value)
    a = _series(operands[0], x, y)
    if operator == "negate":
        return -a
    if operator == "power":
        exponent = operands[1].value
        assert exponent is not None
        return _series_power(a, exponent)
    if len(operands) == 1:
        return getattr(a, operator)()
    b = _series(operands[1], x, y)
    if operator == "add":
        return a + b
    if operator == "subtract":
        return a - b
    return a * b if operator == "multiply" else a / b


def _series_power(a: Any, exponent: float) -> Any:
    arb = flint().arb

    if exponent.is_integer() and abs(exponent) <= 64:
        whole = a ** abs(int(exponent))
        return whole if exponent >= 0 else 1 / whole
    return a ** arb(exponent)
