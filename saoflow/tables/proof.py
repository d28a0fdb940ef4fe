"""The proof of a table's error: a bound that holds at every input of the range, not at sampled ones.

Linear interpolation between exact values errs by f[a, u, b] (u - a) (b - u), at most max|f''| h^2 / 8 on an interval of
width h (de Boor, A Practical Guide to Splines, chapter III); bilinear by the sum of that along both axes; holding the
left value by max|f'| h. The derivatives are enclosed with ball arithmetic (``enclosure.py``). To this come the rounding
of the tabulated values, measured, and of the evaluation in binary64, bounded from the formula of
``tables/evaluation.py``.

A relative error is relative to max(\\|f(u)\\|, floor), floor = :data:`RELATIVE_FLOOR` times the largest tabulated
value: at a zero of f no binary64 evaluation keeps a purely relative error.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise

import numpy as np

from saoflow.enclosure import Interval, Jet, ball_arithmetic, enclose, enclose_2d, flint, value_ball
from saoflow.formula import Formula, evaluate
from saoflow.operations import Table
from saoflow.tables.evaluation import evaluate_table

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
    """The largest error found by sampling every interval: how sharp the proof is. The comparison rounds, by an ulp of f."""
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
    arb = flint().arb

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
    if not math.isfinite(rounding):
        return math.inf
    scale = 1.0 if floor is None else max(mignitude(jet.value), floor)
    if scale == 0.0:
        steepest = magnitude(jet.first) * h
        return 0.0 if steepest + rounding <= 2.0 * _UNDERFLOW * (1.0 + h) else math.inf
    if linear:
        growth = _growth(jet, values, rounding, floor) if floor else None
        method = _interpolation_error(jet, h, scale, growth)
    else:
        method = magnitude(jet.first) * h / scale
    return _finite((method + rounding / scale) * _UP)


@dataclass(frozen=True, slots=True)
class _Growth:
    """|f| grows across the interval: at distance t from its small end it is at least ``start + slope t``.

    If the sign changes just beside that end (f is -d there), the floor makes good for it: max(m t - d, floor) >= m t
    floor / (floor + d), hence the ``excess`` (floor + d) / floor.
    """

    start: float
    slope: float
    excess: float
    from_left: bool


def _growth(jet: Jet, values: tuple[float, float], rounding: float, floor: float) -> _Growth | None:
    near, far = sorted(range(2), key=lambda i: abs(values[i]))
    sign = math.copysign(1.0, values[far])
    outward = sign if near == 0 else -sign
    slope = min(outward * jet.first[0], outward * jet.first[1])
    if not slope > 0.0:
        return None
    start = sign * values[near]
    excess = (floor + max(rounding - start, 0.0)) / floor * _UP
    return _Growth(max(start - rounding, 0.0), slope, excess, near == 0)


def _interpolation_error(jet: Jet, h: float, scale: float, growth: _Growth | None) -> float:
    """A bound of the chord's error over the scale, the largest over pieces of the interval.

    The error at distance t from the left end is t (h - t) / 2 times a mean of f'' with the second-order B-spline of
    the three nodes as weight; the mean of its argument lies t / 3 - h / 6 from the middle. With the third derivative
    in c +- r, that mean of f'' is f''(middle) + c (t / 3 - h / 6) +- r h / 2.
    """
    most = magnitude(jet.second)
    if not math.isfinite(most):
        return math.inf
    low, high = jet.third
    tilt, spread = 0.5 * (low + high), 0.5 * (high - low)
    ends = [h * (k / _PIECES) for k in range(_PIECES + 1)]
    if math.isfinite(spread) and math.isfinite(magnitude(jet.second_at_middle)):
        below, above = jet.second_at_middle
        leans = [tilt * (t / 3.0 - h / 6.0) for t in ends]
        sizes = [max(abs(below + lean), abs(above + lean)) for lean in leans]
        # The roundings of these lines themselves.
        small = 2.0**-48 * (magnitude(jet.second_at_middle) + abs(tilt) * h)
        wide = spread * h * 0.5 * _UP
        curvatures = [min(most, max(pair) + wide + small) for pair in pairwise(sizes)]
    else:
        curvatures = [most] * _PIECES
    worst = 0.0
    for (t0, t1), curvature in zip(pairwise(ends), curvatures, strict=True):
        t = min(max(0.5 * h, t0), t1)
        weight = t * (h - t) / scale
        if growth is not None:
            piece = (t0, t1) if growth.from_left else (h - t1, h - t0)
            weight = min(weight, _growing_weight(growth, h, *piece) * growth.excess)
        worst = max(worst, 0.5 * curvature * weight * _UP)
    return worst


_PIECES = 6


def _growing_weight(growth: _Growth, h: float, t0: float, t1: float) -> float:
    """The largest t (h - t) / (start + slope t) between t0 and t1: at one t inside, or at the end next to it."""
    root = math.sqrt(growth.start)
    t = min(max(h * root / (root + math.sqrt(growth.start + growth.slope * h)), t0), t1)
    below = growth.start + growth.slope * t
    return t * (h - t) / below if below > 0.0 and t > 0.0 else (h - t) / growth.slope


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


def _cell_error(table: Table, formula: Formula, x: Interval, y: Interval, rounding: float) -> float:
    """A bound of the error on one cell; the derivatives are enclosed piece by piece until the claim is met."""
    floor = relative_floor(table)
    scale = 1.0 if floor is None else max(mignitude(enclose_2d(formula, x, y).value), floor)
    if scale == 0.0:
        return math.inf if rounding > _UNDERFLOW * 16.0 else 0.0
    bound = math.inf
    for pieces in (1, 2, 4, 8):
        # Along one axis the width is the cell's; only the other may be cut.
        cut_x, cut_y = np.linspace(*x, pieces + 1).tolist(), np.linspace(*y, pieces + 1).tolist()
        along_x = max(cell_method_errors(formula, x, c, table.linear, floor)[0] for c in pairwise(cut_y))
        along_y = max(cell_method_errors(formula, c, y, table.linear, floor)[1] for c in pairwise(cut_x))
        bound = min(bound, (along_x + along_y + rounding / scale) * _UP)
        if bound <= table.error:
            break
    return bound


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
    arb = flint().arb

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
    arb = flint().arb

    x, y = (axis.tolist() for axis in table.breakpoints)
    z = table.values
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
            bound = _cell_error(table, formula, *cell, rounding)
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
