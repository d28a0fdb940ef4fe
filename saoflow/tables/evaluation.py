"""What a look-up table computes, to the last bit: the reference that the interpreter runs and the C code repeats.

One dimension, with the input limited to the ends (``a < b ? a : b``: NaN gives the first value) and i the number of
breakpoints at or below it, less one: ``y[i] + (u - x[i]) * slope[i]``, where ``slope[i] = (y[i+1] - y[i]) / (x[i+1] -
x[i])`` and the last slope is 0. Two dimensions, with ``rx[i] = 1 / (x[i+1] - x[i])`` and ``d[i, j] = z[i, j+1] - z[i,
j]`` (0 at the last): ``p = (u - x[i]) * rx[i]``, ``q = (v - y[j]) * ry[j]``, ``a = z[i, j] + q * d[i, j]``, ``b =
z[i+1, j] + q * d[i+1, j]``, result ``a + p * (b - a)``. Hold: ``y[i]``, ``z[i, j]``.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from saoflow.operations import Table


@dataclass(frozen=True, slots=True)
class TabulateProblem:
    """What is wrong with a table: a registered code, what, why, and the way out."""

    code: str
    message: str
    cause: str
    remedy: str


class TabulateError(Exception):
    """A table cannot be made or prepared; ``problem`` says why. Whoever knows the place makes it a diagnosis."""

    def __init__(self, code: str, message: str, cause: str, remedy: str) -> None:
        self.problem = TabulateProblem(code, message, cause, remedy)
        self.code, self.message, self.cause, self.remedy = code, message, cause, remedy
        super().__init__(f"{code}: {message} ({cause}; {remedy})")


@dataclass(frozen=True, slots=True, eq=False)
class PreparedTable:
    """A table's numbers in the real type of the program, each computed in binary64 and rounded once."""

    name: str
    linear: bool
    breakpoints: tuple[np.ndarray, ...]
    """(n,), or (n,) and (m,)."""
    values: np.ndarray
    """(n,) or (n, m)."""
    slopes: np.ndarray
    """One dimension: (n,), the last 0. Two: the differences d along the second axis, (n, m), the last column 0."""
    reciprocals: tuple[np.ndarray, ...]
    """Two dimensions: 1 / width of the intervals of each axis, (n,) and (m,), the last 0. One: empty."""

    @property
    def dtype(self) -> np.dtype[Any]:
        """float64 or float32."""
        return self.values.dtype

    def scalar_function(self) -> Callable[..., float]:
        """A function of one ``float`` (of two) giving a ``float``, with the bits of :meth:`array_function`."""
        single = self.dtype == np.float32
        if len(self.breakpoints) == 1:
            return _scalar_1d(self, single)
        return _scalar_2d(self, single)

    def array_function(self) -> Callable[..., np.ndarray]:
        """A function of one array (of two of a common shape) giving an array of the table's type."""
        return self._array_1d if len(self.breakpoints) == 1 else self._array_2d

    def _array_1d(self, u: Any) -> np.ndarray:
        u, i = self._locate(u, 0)
        if not self.linear:
            return np.asarray(self.values[i])
        return np.asarray(self.values[i] + (u - self.breakpoints[0][i]) * self.slopes[i])

    def _array_2d(self, u: Any, v: Any) -> np.ndarray:
        u, i = self._locate(u, 0)
        v, j = self._locate(v, 1)
        z, d = self.values, self.slopes
        if not self.linear:
            return np.asarray(z[i, j])
        p = (u - self.breakpoints[0][i]) * self.reciprocals[0][i]
        q = (v - self.breakpoints[1][j]) * self.reciprocals[1][j]
        below = np.minimum(i + 1, len(z) - 1)
        a = z[i, j] + q * d[i, j]
        b = z[below, j] + q * d[below, j]
        return np.asarray(a + p * (b - a))

    def _locate(self, u: Any, axis: int) -> tuple[np.ndarray, np.ndarray]:
        """The limited input, and the interval that it lies in."""
        x = self.breakpoints[axis]
        u = np.asarray(u, dtype=self.dtype)
        u = np.where(u > x[0], u, x[0])
        u = np.where(u < x[-1], u, x[-1])
        return u, x.searchsorted(u, side="right") - 1


def evaluate_table(table: Table, u: Any, v: Any = None) -> np.ndarray:
    """The table at arrays of inputs in binary64 (``v`` for the second axis); see the head of this file."""
    function = prepare(table).array_function()
    return function(u) if v is None else function(u, v)


def prepare(table: Table, dtype: Any = np.float64) -> PreparedTable:
    """The numbers of a table in float64 or float32.

    Raises :class:`TabulateError` E214 if breakpoints do not increase in that type, E215 if a number is not finite in
    it or the shapes do not fit.
    """
    return _prepare(table, np.dtype(dtype))


@lru_cache(maxsize=512)
def _prepare(table: Table, dtype: np.dtype[Any]) -> PreparedTable:
    axes = tuple(np.asarray(x, dtype=np.float64) for x in table.breakpoints)
    z = np.asarray(table.values, dtype=np.float64)
    if len(axes) not in (1, 2) or z.shape != tuple(x.size for x in axes) or z.size == 0:
        raise TabulateError(
            "E215",
            f"the values of table {table.name} do not fit its breakpoints",
            f"values {list(z.shape)}, breakpoints {[x.size for x in axes]}",
            "give one value for each breakpoint (row by row in two dimensions)",
        )
    reciprocals: tuple[np.ndarray, ...] = ()
    with np.errstate(all="ignore"):
        rounded = tuple(_rounded(x, dtype) for x in axes)
        for x in rounded:
            _check_increasing(table.name, x)
        if len(axes) == 1:
            slopes = np.append(np.diff(z) / np.diff(axes[0]), 0.0)
        else:
            slopes = np.concatenate((np.diff(z, axis=1), np.zeros((z.shape[0], 1))), axis=1)
            reciprocals = tuple(_rounded(np.append(1.0 / np.diff(x), 0.0), dtype) for x in axes)
        values, slopes = _rounded(z, dtype), _rounded(slopes, dtype)
        steps = [np.diff(values, axis=axis) for axis in range(z.ndim)] if table.linear else []
    for numbers in (*rounded, values, *((slopes, *reciprocals, *steps) if table.linear else ())):
        if not np.isfinite(numbers).all():
            raise TabulateError(
                "E215",
                f"table {table.name} is not finite in {dtype.name}",
                "a breakpoint, a value or a slope is NaN, infinite or too large",
                "give finite numbers, within the range of the type",
            )
    return PreparedTable(table.name, table.linear, rounded, values, slopes, reciprocals)


def _rounded(numbers: np.ndarray, dtype: np.dtype[Any]) -> np.ndarray:
    result = np.array(numbers, dtype=dtype, order="C")
    result.flags.writeable = False
    return result


def _check_increasing(name: str, x: np.ndarray) -> None:
    bad = np.flatnonzero(~(x[1:] > x[:-1]))
    if bad.size:
        i = int(bad[0])
        raise TabulateError(
            "E214",
            f"the breakpoints of table {name} do not increase in {x.dtype.name}",
            f"breakpoint {i + 1} is {x[i + 1]}, after {x[i]} (counted from 0)",
            "give increasing breakpoints, far enough apart for the type",
        )


def _scalar_1d(table: PreparedTable, single: bool) -> Callable[[float], float]:
    x = tuple(table.breakpoints[0].tolist())
    low, high, inner = x[0], x[-1], x[1:]
    ends = table.array_function()(np.array([low, high]))
    first, last = float(ends[0]), float(ends[1])
    y = tuple(table.values) if single else tuple(table.values.tolist())
    find = bisect_right
    if not table.linear:

        def hold(u: float) -> float:
            if not u > low:
                return first
            return float(y[find(inner, u)]) if u < high else last

        return hold
    if single:
        return _scalar_1d_single(table, first, last)
    slope = tuple(table.slopes.tolist())

    def linear(u: float) -> float:
        if u > low:
            if u < high:
                i = find(inner, u)
                return y[i] + (u - x[i]) * slope[i]  # type: ignore[no-any-return]
            return last
        return first

    return linear


def _scalar_1d_single(table: PreparedTable, first: float, last: float) -> Callable[[float], float]:
    """In binary32: numpy's own numbers, so that each operation rounds."""
    numbers = tuple(table.breakpoints[0].tolist())
    low, high, inner = numbers[0], numbers[-1], numbers[1:]
    x, y, slope = tuple(table.breakpoints[0]), tuple(table.values), tuple(table.slopes)
    find, rounded = bisect_right, np.float32

    def linear(u: float) -> float:
        if not u > low:
            return first
        if not u < high:
            return last
        i = find(inner, u)
        return float(y[i] + (rounded(u) - x[i]) * slope[i])

    return linear


def _scalar_2d(table: PreparedTable, single: bool) -> Callable[[float, float], float]:
    def numbers(a: np.ndarray) -> tuple[Any, ...]:
        return tuple(a) if single else tuple(a.tolist())

    xs, ys = (tuple(axis.tolist()) for axis in table.breakpoints)
    z, last_row, rounded = tuple(numbers(row) for row in table.values), len(xs) - 1, np.float32
    find = bisect_right
    if not table.linear:
        return lambda u, v: float(z[_index(xs, u, find)[0]][_index(ys, v, find)[0]])
    x, y = (numbers(axis) for axis in table.breakpoints)
    rx, ry = (numbers(reciprocal) for reciprocal in table.reciprocals)
    d = tuple(numbers(row) for row in table.slopes)

    def linear(u: float, v: float) -> float:
        i, u = _index(xs, u, find)
        j, v = _index(ys, v, find)
        if single:
            u, v = rounded(u), rounded(v)  # type: ignore[assignment]
        p, q = (u - x[i]) * rx[i], (v - y[j]) * ry[j]
        below = i + 1 if i < last_row else i
        a = z[i][j] + q * d[i][j]
        b = z[below][j] + q * d[below][j]
        return float(a + p * (b - a))

    return linear


def _index(x: tuple[float, ...], u: float, find: Callable[..., int]) -> tuple[int, float]:
    """The interval of the limited input, and the limited input."""
    if not u > x[0]:
        return 0, x[0]
    if not u < x[-1]:
        return len(x) - 1, x[-1]
    return find(x, u) - 1, u
