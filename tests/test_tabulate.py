"""Tables: the proof against dense sampling, the count of points against theory, the bits against a plain reading."""

from __future__ import annotations

import math
import timeit
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from saoflow.formula import NAMED, Formula, X, Y, apply, as_formula, compile_array, power
from saoflow.operations import Table
from saoflow.tables.tabulate import (
    RELATIVE_FLOOR,
    TabulateError,
    error_budget,
    evaluate_table,
    prepare,
    tabulate,
)

RHO = apply("sqrt", X**2 + (1 - X) ** 2)
HALF_PI = math.pi / 2

CASES = [  # name, formula, range, error, relative
    ("rho", RHO, (0.0, 1.0), 1e-4, False),
    ("rho fine", RHO, (0.0, 1.0), 1e-7, False),
    ("dynamic pressure", (1 + X) ** 3.5 - 1, (0.0, 0.6), 1e-4, True),
    ("dynamic pressure across zero", (1 + X) ** 3.5 - 1, (-0.2, 0.6), 1e-4, True),
    ("airspeed", power(1 + X, as_formula(1) / 3.5) - 1, (0.0, 3.0), 1e-4, True),
    ("reciprocal", 1 / X, (50.0, 350.0), 1e-4, True),
    ("sin", NAMED["sin"], (-HALF_PI, HALF_PI), 1e-4, False),
    ("sin relative", NAMED["sin"], (-0.7, 0.7), 1e-4, True),
    ("cos", NAMED["cos"], (-HALF_PI, HALF_PI), 1e-4, False),
    ("straight", 2 * X + 1, (0.0, 1.0), 1e-9, False),
    ("constant", as_formula(3), (0.0, 1.0), 1e-9, True),
    ("double zero", X**2, (-1.0, 1.0), 1e-3, True),
]


def _largest_error(table: Table, samples: int = 100_003) -> float:
    """By dense sampling, independent of the breakpoints."""
    (x,) = table.breakpoints
    u = np.concatenate((np.linspace(x[0], x[-1], samples), x, np.nextafter(x[1:], -np.inf)))
    assert table.function is not None
    exact = compile_array(table.function)(u)
    error = np.abs(evaluate_table(table, u) - exact)
    if table.relative:
        error /= np.maximum(np.abs(exact), RELATIVE_FLOOR * np.abs(table.values).max())
    # The comparison itself rounds, by an ulp or two of the function.
    return float(error.max()) - 4 * float(np.spacing(1.0 if table.relative else np.abs(exact).max()))


@pytest.mark.parametrize(("name", "formula", "ends", "error", "relative"), CASES, ids=[c[0] for c in CASES])
@pytest.mark.parametrize("linear", [True, False])
def test_the_proved_error_holds(
    name: str, formula: Formula, ends: tuple[float, float], error: float, relative: bool, linear: bool
) -> None:
    error = error if linear else max(200 * error, 1e-3)
    table = tabulate(name, formula, (ends,), error, relative=relative, linear=linear)
    budget = error_budget(table)
    assert table.breakpoints[0][0] == ends[0] and table.breakpoints[0][-1] == ends[1]
    assert np.all(np.diff(table.breakpoints[0]) > 0)
    assert _largest_error(table) <= budget.proved <= table.error * (1 + 1e-12) <= error * (1 + 1e-12)
    assert budget.sampled <= budget.proved + 1e-15 * max(1.0, np.abs(table.values).max())
    assert budget.points == len(table.values)


@pytest.mark.parametrize(
    ("name", "formula", "ends", "relative", "density"),
    [  # density: sqrt(|f''|) over sqrt(|f|) where relative
        ("sin", NAMED["sin"], (-HALF_PI, HALF_PI), False, lambda x: np.sqrt(np.abs(np.sin(x)))),
        ("cos", NAMED["cos"], (-0.7, 0.7), True, lambda x: np.ones_like(x)),
        ("sin relative", NAMED["sin"], (-0.7, 0.7), True, lambda x: np.ones_like(x)),
        ("1/V_g", 1 / X, (50.0, 350.0), True, lambda x: math.sqrt(2) / x),
        ("pbar", (1 - X * (0.0065 / 288.15)) ** 5.2559, (-500.0, 13000.0), True,
         lambda x: math.sqrt(5.2559 * 4.2559) * 0.0065 / (288.15 - 0.0065 * x)),
    ],
)  # fmt: skip
@pytest.mark.parametrize("error", [1e-4, 1e-5])
def test_the_number_of_points_is_near_the_least(
    name: str, formula: Formula, ends: tuple[float, float], relative: bool, density: object, error: float
) -> None:
    x = np.linspace(*ends, 20_001)
    least = np.trapezoid(density(x), x) / math.sqrt(8 * error)  # type: ignore[operator]
    table = tabulate(name, formula, (ends,), error, relative=relative)
    assert least < len(table.values) <= 1.06 * least + 3


def test_hold_left_needs_the_points_of_the_first_derivative() -> None:
    table = tabulate("exp", NAMED["exp"], ((0.0, 1.0),), 1e-3, linear=False)
    assert math.e - 1 < 1e-3 * (len(table.values) - 1) <= 1.03 * (math.e - 1)
    assert not table.linear and evaluate_table(table, table.breakpoints[0][1] * 0.999) == table.values[0]


def test_the_budget_proves_the_table_itself_not_its_claim() -> None:
    table = tabulate("cos", NAMED["cos"], ((-1.0, 1.0),), 1e-4)
    values = table.values.copy()
    values[7] += 1e-3
    broken = error_budget(replace(table, values=values))
    assert 1e-3 <= broken.sampled <= broken.proved <= 1.2e-3
    assert broken.where[0][0] in table.breakpoints[0][6:8]
    thinned = replace(table, breakpoints=(table.breakpoints[0][::2],), values=table.values[::2])
    assert 3.8e-4 < error_budget(thinned).sampled <= error_budget(thinned).proved < 4.2e-4


def test_two_dimensions() -> None:
    formula = X * Y / apply("sqrt", X + Y)
    table = tabulate("product", formula, ((1.0, 4.0), (2.0, 5.0)), 1e-3)
    u, v = np.meshgrid(np.linspace(1, 4, 701), np.linspace(2, 5, 701))
    worst = np.abs(evaluate_table(table, u, v) - u * v / np.sqrt(u + v)).max()
    budget = error_budget(table)
    assert 0.5e-3 < worst <= budget.proved <= table.error <= 1e-3
    assert table.values.shape == tuple(map(len, table.breakpoints)) and table.values.size < 600


def test_two_dimensions_relative_and_straight_along_one_axis() -> None:
    table = tabulate("projection", X * apply("cos", Y), ((50.0, 350.0), (-0.7, 0.7)), 1e-3, relative=True)
    assert table.values.shape[0] == 2
    u, v = np.meshgrid(np.linspace(50, 350, 301), np.linspace(-0.7, 0.7, 1201))
    exact = u * np.cos(v)
    worst = (np.abs(evaluate_table(table, u, v) - exact) / exact).max()
    assert worst <= error_budget(table).proved <= table.error <= 1e-3


def test_two_dimensions_hold() -> None:
    table = tabulate("sum", X + Y**2, ((0.0, 1.0), (0.0, 1.0)), 0.1, linear=False)
    u, v = np.meshgrid(np.linspace(0, 1, 501), np.linspace(0, 1, 501))
    assert 0.05 < np.abs(evaluate_table(table, u, v) - (u + v**2)).max() <= error_budget(table).proved <= 0.1


REFUSED = [
    (1 / X, ((-1.0, 1.0),), 1e-3, "E223", "1 / x is infinite near x = 0"),
    (NAMED["sqrt"], ((0.0, 1.0),), 1e-3, "E223", "sqrt(x) has no bounded second derivative near x = 0"),
    (NAMED["tan"], ((1.0, 2.0),), 1e-3, "E223", "tan(x) has no bounded second derivative near x = 1.5708"),
    (NAMED["log"], ((-2.0, 1.0),), 1e-3, "E223", "log(x) is not defined near x = -2"),
    (NAMED["acos"], ((0.5, 1.0),), 1e-3, "E223", "acos(x) has no bounded second derivative near x = 1"),
    (X / Y, ((0.0, 1.0), (-1.0, 2.0)), 1e-3, "E223", "near x = 0, y = 0"),
    (
        X + apply("sqrt", Y),
        ((0.0, 1.0), (0.0, 1.0)),
        1e-3,
        "E223",
        "has no bounded second derivative near x = 0, y = 0",
    ),
    (X * X * Y * Y, ((0.0, 1.0), (0.0, 1.0)), 1e-6, "E223", "values would be needed"),
    (NAMED["sin"], ((0.0, 1.0),), 1e-12, "E223", "about 2.27e+05 values would be needed"),
    (X * 1e10, ((0.0, 1.0),), 1e-7, "E223", "rounding in binary64 alone exceeds an error of 1e-07"),
    (NAMED["sin"], ((1.0, 1.0),), 1e-3, "E208", "it goes from 1 to 1"),
    (NAMED["sin"], ((1.0, 0.0),), 1e-3, "E208", "it goes from 1 to 0"),
    (NAMED["sin"], ((0.0, math.inf),), 1e-3, "E208", "it goes from 0 to inf"),
    (NAMED["sin"], ((0.0, math.nan),), 1e-3, "E208", "it goes from 0 to nan"),
    (NAMED["sin"], ((0.0, 1.0),), 0.0, "E208", "it is 0"),
    (NAMED["sin"], ((0.0, 1.0),), math.nan, "E208", "it is nan"),
    (NAMED["sin"], ((0.0, 1.0), (0.0, 1.0)), 1e-3, "E208", "the formula is sin(x)"),
    (X + Y, ((0.0, 1.0),), 1e-3, "E208", "the formula is x + y"),
]


@pytest.mark.parametrize(("formula", "ends", "error", "code", "cause"), REFUSED)
def test_refused(formula: Formula, ends: tuple[tuple[float, float], ...], error: float, code: str, cause: str) -> None:
    with pytest.raises(TabulateError) as caught:
        tabulate("t", formula, ends, error)
    assert caught.value.code == code and cause in caught.value.cause and caught.value.remedy


def test_a_relative_error_beyond_a_half_is_refused() -> None:
    with pytest.raises(TabulateError, match="E208: the relative error of table t is no approximation"):
        tabulate("t", NAMED["sin"], ((0.0, 1.0),), 0.6, relative=True)


def test_the_same_table_is_made_once() -> None:
    first = tabulate("cos", NAMED["cos"], [[-1, 1]], 1e-4)  # type: ignore[list-item]
    assert tabulate("cos", NAMED["cos"], ((-1.0, 1.0),), 1e-4) is first
    with pytest.raises(ValueError, match="read-only"):
        first.values[0] = 0.0


def test_a_table_of_a_hundred_points_is_quick() -> None:
    seconds = min(timeit.repeat(lambda: tabulate.__globals__["_tabulate"].__wrapped__(
        "1/V_g", 1 / X, ((50.0, 350.0),), 1e-4, True, True), number=1, repeat=5))  # fmt: skip
    assert seconds < 0.05  # 7 ms on the machine of the measurements; a shared one is slower


# --- evaluation ------------------------------------------------------------------------------------------------------


def _plain_1d(x: list[float], y: list[float], linear: bool, u: float) -> float:
    """The definition of a table, read word by word."""
    limited = u if u > x[0] else x[0]
    limited = limited if limited < x[-1] else x[-1]
    i = sum(1 for b in x if b <= limited) - 1
    if not linear:
        return y[i]
    slope = (y[i + 1] - y[i]) / (x[i + 1] - x[i]) if i < len(x) - 1 else 0.0
    return y[i] + (limited - x[i]) * slope


def _inputs(x: np.ndarray, seed: int = 5) -> np.ndarray:
    beyond = np.random.default_rng(seed).uniform(x[0] - 1, x[-1] + 1, 400)
    special = [math.nan, math.inf, -math.inf, 0.0, -0.0, 5e-324, 1e300, -1e300]
    return np.concatenate((special, x, np.nextafter(x, -np.inf), np.nextafter(x, np.inf), beyond))


def _bits(a: np.ndarray) -> np.ndarray:
    return np.asarray(a, dtype=np.float64).view(np.int64)


increasing = st.lists(st.floats(-1e6, 1e6), min_size=1, max_size=12, unique=True).map(sorted)


@settings(max_examples=150, deadline=None)
@given(increasing, st.data(), st.booleans())
def test_alone_in_batches_and_by_definition_the_bits_are_the_same(
    x: list[float], data: st.DataObject, linear: bool
) -> None:
    x = [b for i, b in enumerate(x) if i == 0 or b - x[i - 1] > 1e-6]
    y = data.draw(st.lists(st.floats(-1e6, 1e6), min_size=len(x), max_size=len(x)))
    table = Table("data", (np.array(x),), np.array(y), linear)
    prepared = prepare(table)
    u = _inputs(np.array(x))
    batch, one = prepared.array_function()(u), prepared.scalar_function()
    assert np.array_equal(_bits(batch), _bits(np.array([one(v) for v in u.tolist()])))
    assert np.array_equal(_bits(batch), _bits(np.array([_plain_1d(x, y, linear, v) for v in u.tolist()])))


@pytest.mark.parametrize("linear", [True, False])
@pytest.mark.filterwarnings("ignore:overflow encountered in cast")
def test_in_binary32_every_operation_rounds(linear: bool) -> None:
    table = tabulate("cos", NAMED["cos"], ((-1.0, 1.0),), 1e-2, linear=linear)
    prepared = prepare(table, np.float32)
    x, y, s = prepared.breakpoints[0], prepared.values, prepared.slopes
    assert x.dtype == y.dtype == s.dtype == np.float32
    u = _inputs(x.astype(np.float64)).astype(np.float32)
    batch, one = prepared.array_function()(u), prepared.scalar_function()
    assert batch.dtype == np.float32
    assert np.array_equal(_bits(batch), _bits(np.array([one(v) for v in u.tolist()])))
    limited = np.clip(np.where(np.isnan(u), x[0], u), x[0], x[-1])
    i = np.searchsorted(x, limited, side="right") - 1
    # Binary64 holds each exact sum and product of binary32 numbers well enough that rounding once more is harmless.
    difference = (limited.astype(float) - x[i].astype(float)).astype(np.float32).astype(float)
    product = (difference * s[i].astype(float)).astype(np.float32).astype(float)
    expected = (y[i].astype(float) + product).astype(np.float32) if linear else y[i]
    assert np.array_equal(_bits(batch), _bits(expected))


def test_two_dimensions_by_definition() -> None:
    rng = np.random.default_rng(2)
    x, y = np.sort(rng.uniform(-1, 1, 5)), np.sort(rng.uniform(-1, 1, 4))
    z = rng.normal(size=(5, 4))

    def plain(u: float, v: float) -> float:
        def locate(axis: np.ndarray, w: float) -> tuple[int, float]:
            w = w if w > axis[0] else float(axis[0])
            w = w if w < axis[-1] else float(axis[-1])
            return int(sum(axis <= w)) - 1, w

        (i, u), (j, v) = locate(x, u), locate(y, v)
        p = (u - x[i]) * (1 / (x[i + 1] - x[i])) if i < 4 else 0.0
        q = (v - y[j]) * (1 / (y[j + 1] - y[j])) if j < 3 else 0.0
        k = min(i + 1, 4)
        d, e = (z[i, j + 1] - z[i, j], z[k, j + 1] - z[k, j]) if j < 3 else (0.0, 0.0)
        a, b = z[i, j] + q * d, z[k, j] + q * e
        return float(a + p * (b - a))

    u, v = (a.ravel() for a in np.meshgrid(_inputs(x)[:120], _inputs(y)[:110]))
    for linear in (True, False):
        for dtype in (np.float64, np.float32):
            prepared = prepare(Table("z", (x, y), z, linear), dtype)
            with np.errstate(over="ignore"):
                batch = prepared.array_function()(u, v)
                one = prepared.scalar_function()
                alone = np.array(
                    [one(*pair) for pair in zip(u.astype(dtype).tolist(), v.astype(dtype).tolist(), strict=True)]
                )
            assert batch.dtype == dtype and np.array_equal(_bits(batch), _bits(alone))
            if linear and dtype is np.float64:
                expected = np.array([plain(a, b) for a, b in zip(u.tolist(), v.tolist(), strict=True)])
                assert np.array_equal(_bits(batch), _bits(expected))


@pytest.mark.parametrize(
    ("x", "y", "dtype", "code", "cause"),
    [
        ([1.0, 1.0 + 1e-9], [0.0, 1.0], np.float32, "E214", "breakpoint 1 is 1.0, after 1.0"),
        ([0.0, 2.0, 1.0], [0.0, 1.0, 2.0], np.float64, "E214", "breakpoint 2 is 1.0, after 2.0"),
        ([0.0, math.nan], [0.0, 1.0], np.float64, "E214", "breakpoint 1 is nan"),
        ([0.0, 1.0], [0.0, 1e39], np.float32, "E215", "too large"),
        ([0.0, 1.0], [0.0, math.inf], np.float64, "E215", "infinite"),
        ([0.0, 1e-320], [0.0, 1.0], np.float64, "E215", "slope"),
        ([0.0, 1.0], [0.0, 1.0, 2.0], np.float64, "E215", "values [3], breakpoints [2]"),
        ([], [], np.float64, "E215", "values [0], breakpoints [0]"),
    ],
)
def test_tables_that_cannot_be_prepared(x: list[float], y: list[float], dtype: type, code: str, cause: str) -> None:
    with pytest.raises(TabulateError) as caught:
        prepare(Table("data", (np.array(x),), np.array(y), True), dtype)
    assert caught.value.code == code and cause in caught.value.cause


def test_data_tables_have_no_error_to_prove() -> None:
    budget = error_budget(Table("data", (np.array([0.0, 1.0]),), np.array([1.0, 3.0]), True))
    assert (budget.proved, budget.points) == (0.0, 2)


@settings(max_examples=40, deadline=None)
@given(
    st.floats(0.05, 3.0), st.floats(0.05, 3.0), st.floats(-3.0, 3.0), st.sampled_from([1e-2, 1e-3, 1e-4]), st.booleans()
)
def test_random_smooth_formulas(start: float, width: float, c: float, error: float, relative: bool) -> None:
    formula = apply("sin", c * X) + apply("log", X) * c - power(X, 1.5)
    table = tabulate("random", formula, ((start, start + width),), error, relative=relative)
    budget = error_budget(table)
    assert _largest_error(table, 5001) <= budget.proved <= error
