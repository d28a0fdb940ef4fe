"""Formulas: evaluation against the mathematics library, same bits alone and in arrays, enclosures."""

from __future__ import annotations

import ast
import math
import subprocess
import sys
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from saoflow.enclosure import ball_arithmetic, enclose, enclose_2d, enclose_mixed
from saoflow.formula import (
    FUNCTIONS,
    NAMED,
    Formula,
    FormulaError,
    X,
    Y,
    apply,
    as_formula,
    compile_array,
    compile_scalar,
    evaluate,
    power,
    variables,
)

RHO = apply("sqrt", X**2 + (1 - X) ** 2)
PRESSURE = (1 + X) ** 3.5 - 1
SAMPLES = [NAMED[name] for name in sorted(NAMED)] + [
    RHO,
    PRESSURE,
    power(1 + X, as_formula(1) / 3.5) - 1,
    -X * 2 / (X - 3),
    X**-3,
]

numbers = st.floats(-6.0, 6.0)
leaves = st.one_of(st.just(X), st.just(Y), numbers.map(as_formula))


def _grow(children: st.SearchStrategy[Formula]) -> st.SearchStrategy[Formula]:
    pairs = st.tuples(children, children)
    return st.one_of(
        st.tuples(st.sampled_from(["add", "subtract", "multiply", "divide"]), pairs).map(lambda t: Formula(*t)),
        st.tuples(st.sampled_from(FUNCTIONS), children).map(lambda t: apply(*t)),
        st.tuples(children, st.sampled_from([2.0, 3.0, -1.0, 0.5, 3.5])).map(lambda t: power(*t)),
        children.map(lambda a: -a),
    )


formulas = st.recursive(leaves, _grow, max_leaves=8)


def _same_bits(a: np.ndarray, b: np.ndarray) -> bool:
    return bool(np.all((a.view(np.int64) == b.view(np.int64)) | (np.isnan(a) & np.isnan(b))))


@pytest.mark.parametrize("formula", SAMPLES, ids=str)
def test_one_number_and_an_array_give_the_same_bits(formula: Formula) -> None:
    special = [0.0, -0.0, 1.0, -1.0, math.inf, -math.inf, math.nan, 5e-324, -5e-324, 1e308, -1e308, 710.0, -746.0]
    x = np.concatenate((special, np.random.default_rng(7).uniform(-4.0, 4.0, 997)))
    scalar, array = compile_scalar(formula), compile_array(formula)
    one_by_one = np.array([scalar(float(v)) for v in x])
    whole = array(x)
    assert _same_bits(one_by_one, whole)
    # Neither the length nor the alignment nor the stride of an array may matter.
    for start, step in ((1, 1), (3, 2), (0, 7)):
        assert _same_bits(array(x[start::step]), whole[start::step])


@pytest.mark.parametrize("name", FUNCTIONS)
def test_functions_agree_with_the_mathematics_library(name: str) -> None:
    x = np.random.default_rng(3).uniform(0.01, 0.99, 500)
    expected = np.array([getattr(math, name)(v) for v in x])
    assert np.all(np.abs(evaluate(NAMED[name], x) - expected) <= 2 * np.spacing(np.abs(expected)))


def test_arithmetic_against_python() -> None:
    assert evaluate(PRESSURE, 0.25) == pytest.approx(1.25**3.5 - 1, rel=1e-15)
    assert evaluate(RHO, 0.25) == math.sqrt(0.0625 + 0.5625)
    assert evaluate(X / Y - Y, 3.0, 4.0) == 3.0 / 4.0 - 4.0
    assert evaluate(power(X, as_formula(1) / 3.5), 2.0) == pytest.approx(2 ** (1 / 3.5), rel=1e-15)


@pytest.mark.parametrize(
    ("formula", "x", "expected"),
    [
        (1 / X, 0.0, math.inf),
        (1 / X, -0.0, -math.inf),
        (X / X, 0.0, math.nan),
        (X / X, math.nan, math.nan),
        (NAMED["log"], 0.0, -math.inf),
        (NAMED["log"], -1.0, math.nan),
        (NAMED["sqrt"], -1.0, math.nan),
        (NAMED["sin"], math.inf, math.nan),
        (NAMED["exp"], 1e6, math.inf),
        (NAMED["asin"], 1.5, math.nan),
        (X**3.5, -1.0, math.nan),
        (X**-2, 0.0, math.inf),
        (X * 1e300 * 1e300, 1.0, math.inf),
    ],
)
@pytest.mark.filterwarnings("error")
def test_outside_the_domain_is_nan_or_infinite_silently(formula: Formula, x: float, expected: float) -> None:
    for got in (evaluate(formula, x), evaluate(formula, np.array([x]))[0]):
        assert got == expected or (math.isnan(got) and math.isnan(expected))


@settings(max_examples=200, deadline=None)
@given(formulas, numbers, numbers)
def test_any_formula_evaluates_without_raising_and_to_the_same_bits(formula: Formula, x: float, y: float) -> None:
    alone = evaluate(formula, x, y)
    assert isinstance(alone, float)
    assert _same_bits(np.array([alone]), evaluate(formula, np.array([x]), np.array([y])))
    assert hash(formula) == hash(formula) and variables(formula) <= {"x", "y"}


_SIGNS = {ast.Add: "add", ast.Sub: "subtract", ast.Mult: "multiply", ast.Div: "divide", ast.Pow: "power"}


def _read(node: ast.expr) -> Formula:
    """The formula that Python's own grammar sees in a text."""
    if isinstance(node, ast.Constant):
        return as_formula(float(node.value))  # type: ignore[arg-type]
    if isinstance(node, ast.Name):
        return Formula(node.id)
    if isinstance(node, ast.UnaryOp):
        return _signed(_read(node.operand))
    if isinstance(node, ast.BinOp):
        return Formula(_SIGNS[type(node.op)], (_read(node.left), _read(node.right)))
    assert isinstance(node, ast.Call) and isinstance(node.func, ast.Name)
    return apply(node.func.id, _read(node.args[0]))


def _signed(a: Formula) -> Formula:
    return as_formula(-a.value) if a.value is not None else -a


def _normal(formula: Formula) -> Formula:
    """A negated constant is a negative constant: the text does not tell them apart."""
    if formula.operator == "negate":
        return _signed(_normal(formula.operands[0]))
    return Formula(formula.operator, tuple(map(_normal, formula.operands)), formula.value)


@settings(max_examples=200, deadline=None)
@given(formulas)
def test_the_text_of_a_formula_reads_back_as_the_formula(formula: Formula) -> None:
    assert _read(ast.parse(str(formula).replace("^", "**"), mode="eval").body) == _normal(formula)


@pytest.mark.parametrize(
    ("formula", "text"),
    [
        (PRESSURE, "(1 + x)^3.5 - 1"),
        (RHO, "sqrt(x^2 + (1 - x)^2)"),
        (-(X**2), "-x^2"),
        ((-X) ** 2, "(-x)^2"),
        (X - (Y - 1), "x - (y - 1)"),
        (X / (Y * 2), "x / (y * 2)"),
        (as_formula(-2) ** 2, "(-2)^2"),
        (X**-0.5, "x^(-0.5)"),
    ],
)
def test_text(formula: Formula, text: str) -> None:
    assert str(formula) == text


@pytest.mark.parametrize(
    ("build", "message"),
    [
        (lambda: Formula("sinh", (X,)), "`sinh` is not an operator of formulas"),
        (lambda: Formula("sin", (X, Y)), "`sin` takes 1 operands, not 2"),
        (lambda: Formula("constant"), "a constant has a value, and nothing else has"),
        (lambda: as_formula(math.nan), "a constant must be finite, not nan"),
        (lambda: power(X, Y), "the exponent y contains a variable"),
        (lambda: apply("gamma", X), "`gamma` is not a function of formulas"),
        (lambda: evaluate(X + Y, 1.0), "has two variables; y is missing"),
        (lambda: power(X, as_formula(1) / 0), "a constant must be finite, not inf"),
    ],
)
def test_malformed_formulas_are_refused(build: object, message: str) -> None:
    with pytest.raises(FormulaError) as caught:
        build()  # type: ignore[operator]
    assert message in str(caught.value)


def test_an_array_result_is_its_own() -> None:
    x = np.arange(3.0)
    result = evaluate(X, x)
    result[0] = 9.0
    assert x[0] == 0.0
    assert evaluate(as_formula(2), np.zeros((2, 3))).shape == (2, 3)


@pytest.mark.parametrize(
    ("formula", "derivatives"),
    [
        (NAMED["sin"], (np.sin, np.cos, lambda x: -np.sin(x))),
        (PRESSURE, (lambda x: (1 + x) ** 3.5 - 1, lambda x: 3.5 * (1 + x) ** 2.5, lambda x: 8.75 * (1 + x) ** 1.5)),
        (1 / (X + 2), (lambda x: 1 / (x + 2), lambda x: -1 / (x + 2) ** 2, lambda x: 2 / (x + 2) ** 3)),
        (NAMED["tan"], (np.tan, lambda x: 1 / np.cos(x) ** 2, lambda x: 2 * np.tan(x) / np.cos(x) ** 2)),
    ],
)
def test_enclosures_contain_the_derivatives_and_are_tight(formula: Formula, derivatives: tuple[Any, ...]) -> None:
    for low, width in ((-0.3, 0.01), (0.0, 0.1), (0.4, 0.05)):
        with ball_arithmetic():
            jet = enclose(formula, (low, low + width))
        x = np.linspace(low, low + width, 201)
        for (a, b), exact in zip((jet.value, jet.first, jet.second), derivatives, strict=True):
            values = exact(x)
            assert a - 1e-14 <= values.min() and values.max() <= b + 1e-14
            assert b - a <= 1.05 * np.ptp(values) + 60.0 * width**2  # what is lost is of second order


def test_enclosures_in_two_variables() -> None:
    formula = X**3 * apply("sin", Y)
    x, y = (1.0, 1.02), (0.5, 0.52)
    with ball_arithmetic():
        jet, mixed = enclose_2d(formula, x, y), enclose_mixed(formula, x, y)
    u, v = np.meshgrid(np.linspace(*x, 21), np.linspace(*y, 21))
    for (low, high), exact in (
        (jet.second_xx, 6 * u * np.sin(v)),
        (jet.second_yy, -(u**3) * np.sin(v)),
        (jet.first_x, 3 * u**2 * np.sin(v)),
        (jet.first_y, u**3 * np.cos(v)),
        (mixed, 3 * u**2 * np.cos(v)),
    ):
        assert low <= exact.min() and exact.max() <= high
        assert high - low < 0.5 * np.abs(exact).max()


@pytest.mark.parametrize(("formula", "x"), [(1 / X, (-1.0, 1.0)), (NAMED["sqrt"], (0.0, 1.0)), (X**3.5, (-1.0, 1.0))])
def test_a_singular_formula_is_not_enclosed(formula: Formula, x: tuple[float, float]) -> None:
    with ball_arithmetic():
        assert enclose(formula, x).second == (-math.inf, math.inf)


def test_importing_does_not_load_the_ball_arithmetic() -> None:
    code = "import sys, saoflow.tables.tabulate; sys.exit('flint' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
