"""Look-up tables of formulas: breakpoints computed from a range and a largest error, and the error proved.

The breakpoints follow the formula: each interval is as long as its proved error allows, so that the error is nearly
the same on all of them and their number near the least (for linear interpolation the integral of sqrt(|f''| / (8
error)); de Boor, A Practical Guide to Splines, chapter III). The tabulated values are the formula's, rounded to
nearest: at breakpoints a table is exact, at both ends too.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import lru_cache
from itertools import pairwise

import numpy as np

from saoflow.enclosure import Interval, ball_arithmetic, enclose, enclose_2d
from saoflow.formula import Formula, evaluate, variables
from saoflow.operations import Table
from saoflow.tables import kept
from saoflow.tables.evaluation import PreparedTable, TabulateError, TabulateProblem, evaluate_table, prepare
from saoflow.tables.proof import (
    RELATIVE_FLOOR,
    TableError,
    cell_method_errors,
    cell_rounding,
    error_budget,
    interval_error,
    magnitude,
    mignitude,
    nearest_value,
)

__all__ = [
    "MOST_POINTS",
    "RELATIVE_FLOOR",
    "PreparedTable",
    "TableError",
    "TabulateError",
    "TabulateProblem",
    "error_budget",
    "evaluate_table",
    "prepare",
    "tabulate",
]

MOST_POINTS = 20_000
"""The most values that a computed table may have."""

_DEEPEST = 120
"""How often the range is halved in search of a singularity."""


def tabulate(
    name: str,
    formula: Formula,
    range: Sequence[Interval],
    error: float,
    relative: bool = False,
    linear: bool = True,
) -> Table:
    """The table of a formula over a range, with its error proved; the same arguments give the same object.

    ``range`` holds (low, high) of x, and of y if the formula has two variables. ``error`` bounds |table - formula| at
    every input of the range, evaluated in binary64; if ``relative``, it is relative to max(|formula|, 1e-6 times the
    largest tabulated value). ``linear`` interpolates; otherwise the value at the left breakpoint is held.

    Raises :class:`TabulateError`: E208 for a range or an error that is none; E223 if the error cannot be proved: a
    singularity, more than :data:`MOST_POINTS` values, or an error below the rounding of binary64.
    """
    ends = tuple((float(low), float(high)) for low, high in range)
    _check_arguments(name, formula, ends, float(error), relative)
    return _tabulate(name, formula, ends, float(error), bool(relative), bool(linear))


@lru_cache(maxsize=512)
def _tabulate(
    name: str, formula: Formula, ends: tuple[Interval, ...], error: float, relative: bool, linear: bool
) -> Table:
    key = kept.key_of(formula, ends, error, relative, linear)
    numbers = kept.read(key)
    if numbers is None:
        numbers = _found(name, formula, ends, error, relative, linear)
        kept.write(key, numbers)
    axes, values, proved = numbers
    for array in (*axes, values):
        array.flags.writeable = False
    return Table(name, axes, values, linear, formula, proved, relative)


def _found(
    name: str, formula: Formula, ends: tuple[Interval, ...], error: float, relative: bool, linear: bool
) -> kept.Numbers:
    """Breakpoints and values, and the proof of their error."""
    with ball_arithmetic():
        _check_regular(name, formula, ends, linear)
        scale = _scale(formula, ends) if relative else None
        # Half of the sampled scale, so that the floor stays below the one that the finished table defines.
        floor = None if scale is None else 0.5 * RELATIVE_FLOOR * scale
        if len(ends) == 1:
            return _tabulate_1d(name, formula, ends[0], error, floor, linear)
        return _tabulate_2d(name, formula, ends, error, floor, linear)


def _check_arguments(name: str, formula: Formula, ends: tuple[Interval, ...], error: float, relative: bool) -> None:
    names = sorted(variables(formula) | {"x"})
    if len(ends) != len(names):
        raise TabulateError(
            "E208",
            f"table {name} has {len(ends)} range{'s' * (len(ends) != 1)} for {len(names)} variable"
            f"{'s' * (len(names) != 1)}",
            f"the formula is {formula}",
            f"give one range (low, high) for each of {', '.join(names)}",
        )
    for variable, (low, high) in zip(names, ends, strict=True):
        if not (math.isfinite(low) and math.isfinite(high) and low < high and math.isfinite(high - low)):
            raise TabulateError(
                "E208",
                f"the range of {variable} in table {name} is not one",
                f"it goes from {low:g} to {high:g}",
                "give two finite numbers, the lower first",
            )
    if not (math.isfinite(error) and error > 0.0):
        raise TabulateError(
            "E208",
            f"the error of table {name} is not a positive number",
            f"it is {error:g}",
            "give the largest error that the table may have, such as 1e-4",
        )
    if relative and error > 0.5:
        # Below that the largest tabulated value is at least half of the largest value: see the floor in _tabulate.
        raise TabulateError(
            "E208",
            f"the relative error of table {name} is no approximation",
            f"it is {error:g}",
            "give at most 0.5, such as 1e-4, or an absolute error",
        )


def _check_regular(name: str, formula: Formula, ends: tuple[Interval, ...], linear: bool) -> None:
    """Refuse a formula whose derivative is not bounded on the range: cover the range with finite enclosures."""
    boxes = [(ends, 0)]
    while boxes:
        box, depth = boxes.pop()
        if all(math.isfinite(magnitude(d)) for d in _derivatives(formula, box, linear)):
            continue
        axis = depth % len(box)
        low, high = box[axis]
        middle = 0.5 * low + 0.5 * high
        if depth >= _DEEPEST * len(box) or not low < middle < high:
            raise _singular(name, formula, tuple(map(_simplest, box, ends)), linear)
        for half in ((middle, high), (low, middle)):
            boxes.append(((half, *box[1:]) if axis == 0 else (box[0], half), depth + 1))


def _derivatives(formula: Formula, box: tuple[Interval, ...], linear: bool) -> tuple[Interval, ...]:
    """Enclosures of the derivative that the error goes with, along each axis."""
    if len(box) == 1:
        jet = enclose(formula, box[0])
        return (jet.second,) if linear else (jet.first,)
    both = enclose_2d(formula, *box)
    return (both.second_xx, both.second_yy) if linear else (both.first_x, both.first_y)


def _simplest(box: Interval, ends: Interval) -> float:
    """The most telling point of a tiny interval: zero, an end of the range, or its middle."""
    for point in (0.0, *ends):
        if box[0] <= point <= box[1]:
            return point
    return 0.5 * box[0] + 0.5 * box[1]


def _singular(name: str, formula: Formula, point: tuple[float, ...], linear: bool) -> TabulateError:
    value = evaluate(formula, *point)
    what = f"has no bounded {'second' if linear else 'first'} derivative"
    if not math.isfinite(value):
        what = "is not defined" if math.isnan(value) else "is infinite"
    place = ", ".join(f"{v} = {a:.6g}" for v, a in zip("xy", point, strict=False))
    return TabulateError(
        "E223",
        f"the error of table {name} cannot be proved",
        f"{formula} {what} near {place}",
        "keep the range away from there, or tabulate a smoother formula",
    )


def _scale(formula: Formula, ends: tuple[Interval, ...], samples: int = 65) -> float:
    """About the largest absolute value on the range."""
    axes = [np.linspace(low, high, samples) for low, high in ends]
    return float(np.max(np.abs(evaluate(formula, *np.meshgrid(*axes, indexing="ij")))))


def _tabulate_1d(
    name: str, formula: Formula, ends: Interval, error: float, floor: float | None, linear: bool
) -> tuple[tuple[np.ndarray, ...], np.ndarray, float]:
    _check_estimate(name, formula, ends, error, floor, linear)
    value_at = lru_cache(maxsize=8)(lambda x: nearest_value(formula, x))

    def bound(a: float, b: float) -> float:
        (left, left_error), (right, right_error) = value_at(a), value_at(b)
        rounding = max(left_error, right_error)
        return interval_error(formula, (a, b), (left, right), rounding, linear, floor)

    # At a zero of f a relative error is kept only by a breakpoint there.
    stops = [*(_zeros(formula, ends) if floor is not None else ()), ends[1]]
    march = _March(name, bound, error, 2 if linear else 1, MOST_POINTS)
    points, proved = march.run(ends[0], stops)
    values = np.array([nearest_value(formula, x)[0] for x in points])
    return (np.array(points),), values, proved


def _check_estimate(
    name: str, formula: Formula, ends: Interval, error: float, floor: float | None, linear: bool, samples: int = 64
) -> None:
    """Refuse at once what would need far too many points (a guess from sampled derivatives, generous by half)."""
    edges = np.linspace(*ends, samples + 1)
    needed = 0.0
    for a, b in pairwise(edges.tolist()):
        middle = 0.5 * a + 0.5 * b
        jet = enclose(formula, (middle, middle))
        local = error * (1.0 if floor is None else max(mignitude(jet.value), floor))
        if linear:
            needed += (b - a) * math.sqrt(mignitude(jet.second) / 8.0 / local) if local else 0.0
        else:
            needed += (b - a) * mignitude(jet.first) / local if local else 0.0
    if needed > 1.5 * MOST_POINTS:
        raise _too_many(name, f"about {needed:.3g} values would be needed")


def _too_many(name: str, cause: str) -> TabulateError:
    return TabulateError(
        "E223",
        f"table {name} would exceed {MOST_POINTS} values",
        cause,
        "allow a larger error, or a smaller range",
    )


def _zeros(formula: Formula, ends: Interval, samples: int = 257) -> list[float]:
    """The zeros inside the range where sampled signs change (a missed one costs points, never the proof)."""
    x = np.linspace(*ends, samples)
    signs = np.sign(evaluate(formula, x))
    zeros = {float(x[i]) for i in range(1, samples - 1) if signs[i] == 0.0}
    for i in np.flatnonzero(signs[1:] * signs[:-1] < 0.0):
        low, high = float(x[i]), float(x[i + 1])
        if low < 0.0 < high and evaluate(formula, 0.0) == 0.0:
            zeros.add(0.0)
            continue
        for _ in range(80):
            middle = 0.5 * low + 0.5 * high
            if np.sign(evaluate(formula, middle)) == signs[i]:
                low = middle
            else:
                high = middle
        zeros.add(high)
    return sorted(z for z in zeros if ends[0] < z < ends[1])


class _March:
    """Walks along one axis from breakpoint to breakpoint, each as far as the proved error of its interval allows."""

    def __init__(self, name: str, bound: Callable[[float, float], float], error: float, order: int, most: int) -> None:
        self.name = name
        self.bound = bound
        self.error = error
        self.order = order
        self.most = most

    def run(self, start: float, stops: Sequence[float]) -> tuple[list[float], float]:
        """The breakpoints from ``start`` through all the stops, and the largest bound of an interval."""
        points, worst = [start], 0.0
        step, growth = (stops[-1] - start) / 16.0, 1.0
        for stop in stops:
            while points[-1] < stop:
                end, bound = self._interval(points[-1], stop, step * growth)
                taken = end - points[-1]
                # A stop cuts an interval short; the next step is then guessed from the last whole one.
                if end < stop:
                    growth = min(max(taken / step, 0.5), 2.0) if len(points) > 2 else 1.0
                    step = taken
                points.append(end)
                worst = max(worst, bound)
                if len(points) > self.most:
                    raise _too_many(self.name, f"after {self.most} values only {end:.6g} is reached")
        return points, worst

    def _interval(self, a: float, stop: float, step: float) -> tuple[float, float]:
        """The end of the interval that starts at ``a``, and its bound: just below the error if it can be."""
        best: tuple[float, float] | None = None
        bound = 0.0
        for attempt in range(100):
            b = min(a + step, stop)
            if not b > a or not (math.isfinite(b)):
                break
            bound = self.bound(a, b)
            if bound <= self.error:
                best = (b, bound) if best is None or b > best[0] else best
                if b == stop or bound >= 0.975 * self.error or attempt >= 5:
                    return best
            elif best is not None:
                return best
            ratio = 0.992 * self.error / bound if bound > 0.0 else math.inf
            step = (b - a) * min(max(ratio ** (1.0 / self.order), 0.05), 4.0)
        if best is not None:
            return best
        raise _unproved(self.name, f"near {a:.6g}", self.error, math.isfinite(bound))


def _unproved(name: str, where: str, error: float, bounded: bool) -> TabulateError:
    cause = f"{where}, rounding in binary64 alone exceeds an error of {error:g}"
    return TabulateError(
        "E223",
        f"the error of table {name} cannot be proved",
        cause if bounded else f"{where}, no bound of the formula's derivatives was found",
        "allow a larger error" if bounded else "take a smaller range, or a formula in which each variable occurs once",
    )


def _tabulate_2d(
    name: str, formula: Formula, ends: tuple[Interval, ...], error: float, floor: float | None, linear: bool
) -> tuple[tuple[np.ndarray, ...], np.ndarray, float]:
    """A grid: half of the error to each axis, best for the number of values (each count goes as error^-1/2).

    An axis along which the formula is straight leaves its half to the other.
    """
    largest = 1.01 * _scale(formula, ends)
    rounding = 2.0**-52 * largest + (cell_rounding(largest) if linear else 0.0)
    spare = error - (rounding if floor is None else rounding / floor)
    if not spare > 0.0:
        raise _unproved(name, "everywhere", error, True)

    def strip(axis: int, other: Sequence[float]) -> Callable[[float, float], float]:
        def bound(a: float, b: float) -> float:
            boxes = (((a, b), piece) if axis == 0 else (piece, (a, b)) for piece in pairwise(other))
            return max(cell_method_errors(formula, *box, linear, floor)[axis] for box in boxes)

        return bound

    _check_estimate_2d(name, formula, ends, spare, floor, linear)
    order = 2 if linear else 1
    cuts_x, cuts_y = (np.linspace(*end, 33).tolist() for end in ends)
    whole_y = strip(1, cuts_x)(*ends[1])
    share = spare - whole_y if whole_y <= 0.1 * spare else 0.5 * spare
    x, bound_x = _March(name, strip(0, cuts_y), share, order, MOST_POINTS).run(ends[0][0], [ends[0][1]])
    share = spare - bound_x
    y, bound_y = _March(name, strip(1, x), share, order, MOST_POINTS // len(x)).run(ends[1][0], [ends[1][1]])
    values = np.array([[nearest_value(formula, a, b)[0] for b in y] for a in x])
    return (np.array(x), np.array(y)), values, bound_x + bound_y + (error - spare)


def _check_estimate_2d(
    name: str,
    formula: Formula,
    ends: tuple[Interval, ...],
    error: float,
    floor: float | None,
    linear: bool,
    samples: int = 9,
) -> None:
    """As :func:`_check_estimate`, from the derivatives on a coarse grid: along each axis the largest across it."""
    rates = np.zeros((2, samples, samples))
    for i, a in enumerate(np.linspace(*ends[0], samples).tolist()):
        for j, b in enumerate(np.linspace(*ends[1], samples).tolist()):
            box = ((a, a), (b, b))
            value = enclose_2d(formula, *box).value
            local = error * (1.0 if floor is None else max(mignitude(value), floor))
            for axis, derivative in enumerate(_derivatives(formula, box, linear)):
                least = mignitude(derivative)
                rates[axis, i, j] = (math.sqrt(least / 8.0 / local) if linear else least / local) if local else 0.0
    needed = 1.0
    for axis, (low, high) in enumerate(ends):
        needed *= 1.0 + (high - low) * float(rates[axis].max(axis=1 - axis).mean())
    if needed > 1.5 * MOST_POINTS:
        raise _too_many(name, f"about {needed:.3g} values would be needed")
