"""The proof of a table's error: a bound that holds at every input of the range, not at sampled ones.

Linear interpolation between exact values errs by at most max|f''| h^2 / 8 on an interval of width h (de Boor, A
Practical Guide to Splines, chapter III, (2)); bilinear by the sum of that along both axes; holding the left value by
max|f'| h. The derivatives are enclosed with ball arithmetic (``enclosure.py``). To this come the rounding of the
tabulated values, measured, and of the evaluation in binary64, bounded from the formula of ``table_evaluation.py``.

A relative error is relative to max(\\|f(u)\\|, floor), floor = :data:`RELATIVE_FLOOR` times the largest tabulated
value: at a zero of f no binary64 evaluation keeps a purely relative error.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from saoflow.enclosure import Interval, ball_arithmetic, enclose, enclose_2d, value_ball
from saoflow.formula import Formula, evaluate
from saoflow.operations import Table
from saoflow.table_evaluation import evaluate_table

RELATIVE_FLOOR = 1e-6
"""Where a relative error is asked for: the part of the largest value below which it is absolute."""

_UNIT = 2.0**-53
_UNDERFLOW = 2.0**-1070
_UP = 1.0 + 2.0**-48
"""Covers the few roundings of a bound's own arithmetic."""


@dataclass(frozen=True, slots=True)
class TableError:
    """The error budget of one table. Errors are relative where the table says so."""

    name: str
    proved: float
    """No input of the range gives a larger error (0 for data, which approximate nothing)."""
    where: tuple[Interval, ...]
    """The interval (the cell) with the largest bound."""
    points: int
    """How many values are stored."""
    sampled: float
    """The largest error found by sampling every interval: how sharp the proof is."""
    sampled_at: tuple[float, ...]
    relative: bool


def magnitude(interval: Interval) -> float:
    """The largest absolute value in an interval."""
    return max(abs(interval[0]), abs(interval[1]))


def mignitude(interval: Interval) -> float:
    """The smallest absolute value in an interval."""
    low, high = interval
    return 0.0 if low <= 0.0 <= high else min(abs(low), abs(high))


def nearest_value(formula: Formula, x: float, y: float = 0.0) -> tuple[float, float]:
    """The formula's value at a point in binary64 and a bound of its rounding error; (NaN, inf) if not finite."""
    from flint import arb

    ball = value_ball(formula, x, y)
    value = float(ball.mid()) if ball.is_finite() else math.nan
    if not math.isfinite(value):
        return math.nan, math.inf
    return value, deviation(ball - arb(value))


def deviation(ball: object) -> float:
    """An upper bound of a ball's absolute value."""
    return math.nextafter(float(ball.abs_upper()), math.inf)  # type: ignore[attr-defined]


def interval_error(
    formula: Formula,
    x: Interval,
    values: tuple[float, float],
    rounding: float,
    linear: bool,
    floor: float | None,
) -> float:
    """A bound of the error on one interval between breakpoints; infinite if there is none.

    ``values`` stand at its ends and differ from the formula's by at most ``rounding``. With a ``floor``, the error is
    relative to max(|f|, floor). Call it inside ``ball_arithmetic``.
    """
    jet = enclose(formula, x)
    h = (x[1] - x[0]) * _UP
    if linear:
        step = abs(values[1] - values[0])
        # (1 + unit)^5 on the increment (two differences, quotient, difference, product), once more on the sum.
        rounding += 6.0 * _UNIT * step + 1.5 * _UNIT * max(map(abs, values)) + _UNDERFLOW * (1.0 + h)
        method = magnitude(jet.second) * h * h / 8.0
    else:
        method = magnitude(jet.first) * h
    if floor is None:
        return _finite((method + rounding) * _UP)
    scale = max(mignitude(jet.value), floor)
    if scale == 0.0:
        return 0.0 if method + rounding <= 2.0 * _UNDERFLOW * (1.0 + h) else math.inf
    relative = method / scale
    if linear and floor > 0.0:
        relative = min(relative, _near_zero(jet.second, jet.first, values, rounding, h, floor))
    return _finite((relative + rounding / scale) * _UP)


def _near_zero(
    second: Interval, first: Interval, values: tuple[float, float], rounding: float, h: float, floor: float
) -> float:
    """A bound of the relative error of interpolation where |f| grows from one end of the interval to the other.

    With t the distance from the small end, g0 = |f| there and m <= |f'|: the error is at most max|f''| t (h - t) / 2
    and |f| at least g0 + m t; the quotient is largest at max|f''| h^2 / (2 (sqrt(g0) + sqrt(g0 + m h))^2). If the sign
    changes just beside that end (f is -d there), the floor makes good for it: max(m t - d, floor) >= m t floor /
    (floor + d).
    """
    near, far = sorted(range(2), key=lambda i: abs(values[i]))
    sign = math.copysign(1.0, values[far])
    outward = sign if near == 0 else -sign
    slope = min(outward * first[0], outward * first[1])
    if not slope > 0.0:
        return math.inf
    start = sign * values[near]
    low = max(start - rounding, 0.0)
    below = max(rounding - start, 0.0)
    root = math.sqrt(low) + math.sqrt(low + slope * h)
    return magnitude(second) * h * h / (2.0 * root * root) * ((floor + below) / floor) * _UP if root else math.inf


def _finite(bound: float) -> float:
    return bound if math.isfinite(bound) else math.inf


def cell_rounding(largest: float) -> float:
    """A bound of the rounding in a bilinear evaluation between values of at most that size.

    With Z the largest and unit u: the weights err by 4 u, a and b by 13 u Z, p (b - a) by 38 u Z, the sum by 52 u Z.
    """
    return 64.0 * _UNIT * largest + _UNDERFLOW * 8.0


def cell_method_errors(
    formula: Formula, x: Interval, y: Interval, linear: bool, floor: float | None
) -> tuple[float, float]:
    """Bounds of the error along x and along y on a rectangle; their sum bounds the error of its interpolation."""
    jet = enclose_2d(formula, x, y)
    hx, hy = (x[1] - x[0]) * _UP, (y[1] - y[0]) * _UP
    scale = 1.0 if floor is None else max(mignitude(jet.value), floor)
    if linear:
        along_x, along_y = magnitude(jet.second_xx) * hx * hx / 8.0, magnitude(jet.second_yy) * hy * hy / 8.0
    else:
        along_x, along_y = magnitude(jet.first_x) * hx, magnitude(jet.first_y) * hy
    if scale == 0.0:
        return (0.0, 0.0) if along_x + along_y <= _UNDERFLOW else (math.inf, math.inf)
    return _finite(along_x / scale * _UP), _finite(along_y / scale * _UP)


def relative_floor(table: Table) -> float | None:
    """The floor of a table whose error is relative; None for an absolute error."""
    return RELATIVE_FLOOR * float(np.max(np.abs(table.values))) if table.relative else None


@lru_cache(maxsize=512)
def error_budget(table: Table) -> TableError:
    """Prove the error of a table anew, from its breakpoints and values alone, and sample it for comparison."""
    dimensions = len(table.breakpoints)
    if table.function is None:
        ends = tuple((float(x[0]), float(x[-1])) for x in table.breakpoints)
        return TableError(table.name, 0.0, ends, table.values.size, 0.0, (), table.relative)
    with ball_arithmetic():
        proved, where = (_prove_1d if dimensions == 1 else _prove_2d)(table, table.function)
    sampled, sampled_at = _sample(table, table.function)
    return TableError(table.name, proved, where, table.values.size, sampled, sampled_at, table.relative)


def _prove_1d(table: Table, formula: Formula) -> tuple[float, tuple[Interval, ...]]:
    from flint import arb

    x, y = table.breakpoints[0].tolist(), table.values.tolist()
    floor = relative_floor(table)
    away = [deviation(value_ball(formula, a) - arb(b)) for a, b in zip(x, y, strict=True)]
    worst, where = -1.0, (x[0], x[0])
    for i in range(len(x) - 1):
        ends, rounding = (x[i], x[i + 1]), max(away[i], away[i + 1])
        bound = interval_error(formula, ends, (y[i], y[i + 1]), rounding, table.linear, floor)
        if bound > worst:
            worst, where = bound, ends
    return worst, (where,)


def _prove_2d(table: Table, formula: Formula) -> tuple[float, tuple[Interval, ...]]:
    from flint import arb

    x, y = (axis.tolist() for axis in table.breakpoints)
    z, floor = table.values, relative_floor(table)
    away = np.array([[deviation(value_ball(formula, a, b) - arb(float(z[i, j]))) for j, b in enumerate(y)]
                     for i, a in enumerate(x)])  # fmt: skip
    worst, where = -1.0, ((x[0], x[0]), (y[0], y[0]))
    for i in range(len(x) - 1):
        for j in range(len(y) - 1):
            cell = (x[i], x[i + 1]), (y[j], y[j + 1])
            corners = slice(i, i + 2), slice(j, j + 2)
            rounding = float(away[corners].max())
            if table.linear:
                rounding += cell_rounding(float(np.abs(z[corners]).max()))
            along_x, along_y = cell_method_errors(formula, *cell, table.linear, floor)
            least = 1.0 if floor is None else max(mignitude(enclose_2d(formula, *cell).value), floor)
            bound = (along_x + along_y + (rounding / least if least else 0.0)) * _UP
            if bound > worst:
                worst, where = bound, cell
    return worst, where


def _sample(table: Table, formula: Formula, inside: int = 7) -> tuple[float, tuple[float, ...]]:
    """The largest error at the breakpoints, just left of them, and at some points inside each interval."""
    grids = []
    for axis in table.breakpoints:
        between = axis[:-1, None] + np.diff(axis)[:, None] * (np.arange(1, inside + 1) / (inside + 1.0))
        grids.append(np.concatenate((axis, between.ravel(), np.nextafter(axis[1:], -np.inf))))
    points = [g.ravel() for g in np.meshgrid(*grids, indexing="ij")]
    exact = evaluate(formula, *points)
    error = np.abs(evaluate_table(table, *points) - exact)
    floor = relative_floor(table)
    if floor:
        error /= np.maximum(np.abs(exact), floor)
    worst = int(np.argmax(error))
    return float(error[worst]), tuple(float(p[worst]) for p in points)
