"""Parameter arithmetic: numbers against numpy, units against the rules, and a diagnosis for what has no value."""

from __future__ import annotations

import math
import re

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from saoflow.diagnosis import DiagnosisError, Position
from saoflow.diagrams.expression_parser import parse_expression
from saoflow.diagrams.expression_value import FUNCTIONS, Quantity, evaluate, names_in, word
from saoflow.units import Unit, units_text

U = Unit.parse
A = np.arange(6.0).reshape(2, 3)
NAMES = {
    "n": Quantity(np.array(3.0)),
    "v": Quantity(np.array(3.0), U("kt")),
    "w": Quantity(np.array(2.0), U("m/s")),
    "one": Quantity(np.array(0.5), U("1")),
    "d": Quantity(np.array([1.0, 2.0]), U("deg")),
    "x": Quantity(np.array([0.25, 0.5, 0.75])),
    "A": Quantity(A, (U("kt"), U("m"), None, U("deg"), U("s"), U("1"))),
    "mode": word("matrix"),
}


def value(text: str) -> Quantity:
    return evaluate(parse_expression(text, Position("p.yaml", 1, 1)), NAMES, [text])


NUMPY = {
    "n": 3.0, "v": 3.0, "w": 2.0, "one": 0.5, "d": np.array([1.0, 2.0]), "x": NAMES["x"].array, "A": A, "pi": math.pi,
    "sqrt": np.sqrt, "abs": np.abs, "exp": np.exp, "log": np.log, "sin": np.sin, "cos": np.cos, "tan": np.tan,
    "asin": np.arcsin, "acos": np.arccos, "atan": np.arctan, "floor": np.floor, "ceil": np.ceil, "diag": np.diag,
    "zeros": lambda *n: np.zeros([int(k) for k in n]), "ones": lambda *n: np.ones([int(k) for k in n]),
    "eye": lambda n: np.eye(int(n)), "round": lambda x: np.trunc(x + np.copysign(0.5, x)),
    "min": lambda *a: np.min(a[0]) if len(a) == 1 else np.minimum.reduce(np.broadcast_arrays(*a)),
    "max": lambda *a: np.max(a[0]) if len(a) == 1 else np.maximum.reduce(np.broadcast_arrays(*a)),
}  # fmt: skip


@pytest.mark.parametrize(
    "text",
    [
        "2*n + 1", "n^2/7 - 1", "-n", "+n", "2^-1", "2^0.5", "sqrt(2*n)", "abs(-n)", "exp(x)", "log(x)", "sin(pi/6)",
        "cos(x)", "tan(x)", "asin(x)", "acos(x)", "atan(n)", "floor(n/2)", "ceil(n/2)", "round(2.5)", "round(-2.5)",
        "round(x*10)", "min(n, 2, 5)", "max(x)", "min(x)", "max(x, 0.5)", "zeros(2)", "zeros(n, 2)", "ones(n)",
        "ones(2, 2)", "eye(n)", "diag(x)", "diag([1, n])", "x*2", "2/x", "x + x", "A[1, 2]", "A[-1]", "A.T", "A.T[2]",
        "x[1:]", "x[:-1]", "A[:, 1]", "A[0, 1:]", "[1, n, 2*n]", "[[1, 2], [3, n]]", "[x, x]", "x.T", "[A, A]",
        "[1, 2, 3][1]",
    ],
)  # fmt: skip
def test_numbers_are_those_of_numpy(text: str) -> None:
    # Python's own eval is the independent judge here; saoflow never uses it
    expected = np.asarray(eval(text.replace("^", "**").replace("[x, x]", "np.array([x, x])"), {"np": np, **NUMPY}))
    got = value(text).array
    assert got.dtype == np.float64
    assert got.shape == expected.shape
    np.testing.assert_array_equal(got, expected)


numbers = st.floats(min_value=-1e3, max_value=1e3, allow_nan=False).map(lambda f: repr(round(f, 3)))
texts = st.recursive(
    st.one_of(numbers, st.sampled_from(["n", "x", "pi"])),
    lambda inner: st.one_of(
        st.tuples(inner, st.sampled_from(["+", "-", "*", "/"]), inner).map(lambda t: f"({' '.join(t)})"),
        inner.map(lambda t: f"-({t})"),
        inner.map(lambda t: f"abs({t})"),
        inner.map(lambda t: f"sqrt({t})"),
        inner.map(lambda t: f"exp({t})"),
    ),
    max_leaves=8,
)


@given(texts)
@settings(max_examples=300, deadline=None)
def test_random_arithmetic(text: str) -> None:
    """Bit for bit what numpy gives where that is finite; a diagnosis, and nothing else, where it is not."""
    judge = {name: np.float64(f) if isinstance(f, float) else f for name, f in NUMPY.items()}
    wrapped = re.sub(r"\d+\.\d+", lambda m: f"float64({m.group()})", text)
    with np.errstate(all="ignore"):
        plain = np.asarray(eval(wrapped, {"float64": np.float64, **judge}))
    try:
        got = value(text).array
    except DiagnosisError as error:
        assert {d.code for d in error.diagnoses} == {"E209"}
        # an intermediate result may be infinite where the whole is finite, as in 1/exp(1000)
        assert not np.all(np.isfinite(plain)) or "/" in text or "exp" in text
        return
    np.testing.assert_array_equal(got, plain)
    assert np.all(np.isfinite(got))


@pytest.mark.parametrize(
    ("text", "unit"),
    [
        ("2*v", "kt"),
        ("v + 1", "kt"),
        ("v*w", "kt*m/s"),
        ("v/w", "kt*s/m"),
        ("v/v", "1"),
        ("v*n", "not stated"),
        ("n", "not stated"),
        ("n + v", "kt"),
        ("1/v", "1/kt"),
        ("sqrt(v*v)", "kt"),
        ("sqrt(v)", "kt^(1/2)"),
        ("v^2", "kt^2"),
        ("v^(1/3)", "kt^(1/3)"),
        ("v^one", "kt^(1/2)"),
        ("-v", "kt"),
        ("abs(v)", "kt"),
        ("min(v, 4)", "kt"),
        ("max(d)", "deg"),
        ("eye(2)*v", "kt"),
        ("diag(d)", "deg"),
        ("[v, w, 1]", "[kt, m/s, ?]"),
        ("[v, v]", "kt"),
        ("A.T", "[kt, deg, m, s, ?, 1]"),
        ("A[1]", "[deg, s, 1]"),
        ("A[:, 0]", "[kt, deg]"),
        ("A[0, 0]", "kt"),
        ("A*v", "[kt^2, kt*m, ?, deg*kt, kt*s, kt]"),
        ("diag([v, w])", "[kt, ?, ?, m/s]"),
        ("exp(one)", "1"),
        ("atan(one)", "1"),
        ("d*one", "deg"),
    ],
)
def test_units_flow_through(text: str, unit: str) -> None:
    assert units_text(value(text).unit) == unit


@pytest.mark.parametrize(
    ("text", "code", "column", "length", "words"),
    [
        ("v + w", "E211", 1, 5, "kt meets m/s: 1 kt = 0.514444 m/s"),
        ("2*(v - d)", "E211", 4, 5, "kt and deg measure different things"),
        ("max(v, w)", "E211", 1, 9, "units do not compare"),
        ("max(A)", "E211", 1, 6, "kt meets m"),
        ("1 + sin(d)", "E211", 5, 6, "1 deg = 0.0174533 rad"),
        ("2^v", "E211", 1, 3, "an exponent has a unit"),
        ("d^[1, 2]", "E211", 1, 8, "no simple fraction"),
        ("v^pi", "E211", 1, 4, "no simple fraction"),
        ("2*nn", "E206", 3, 2, "did you mean `n`?"),
        ("qqqq", "E206", 1, 4, "unknown parameter `qqqq`"),
        ("1 + sin", "E206", 5, 3, "write sin(...)"),
        ("sqr(4)", "E209", 1, 3, "did you mean `sqrt`?"),
        ("min()", "E209", 1, 5, "it takes 1 or more, 0 are given"),
        ("sin(1, 2)", "E209", 1, 9, "it takes 1, 2 are given"),
        ("n.x", "E209", 3, 1, "parameters have no outputs"),
        ("1 + mode", "E209", 5, 4, "`matrix` is a word"),
        ("n/(n - 3)", "E209", 1, 9, "division by zero"),
        ("0^-1", "E209", 1, 4, "division by zero"),
        ("1e300*1e300", "E209", 1, 11, "too large"),
        ("exp(1000)", "E209", 1, 9, "too large"),
        ("sqrt(-1)", "E209", 1, 8, "numbers from 0 on"),
        ("log(0)", "E209", 1, 6, "numbers above 0"),
        ("acos(2)", "E209", 1, 7, "numbers from -1 to 1"),
        ("(-8)^(1/3)", "E209", 1, 10, "a negative number has no such power"),
        ("A + x", "E209", 1, 5, "[2, 3] meets [3]"),
        ("[[1, 2], [3]]", "E209", 10, 3, "the first is [2], this one [1]"),
        ("[]", "E209", 1, 2, "an empty list"),
        ("diag(A)", "E209", 1, 7, "takes a vector"),
        ("[A, A].T", "E209", 8, 1, "only a matrix"),
        ("zeros(2.5)", "E209", 7, 3, "it is 2.5"),
        ("zeros(x)", "E209", 7, 1, "it is [3]"),
        ("zeros(0)", "E209", 7, 1, "must be positive"),
        ("zeros(1e9)", "E209", 1, 10, "more than 1000000 elements"),
        ("eye(1e9)", "E209", 1, 8, "more than 1000000 elements"),
        ("x[3]", "E217", 3, 1, "write a number from -3 to 2"),
        ("x[-4]", "E217", 3, 2, "out of range"),
        ("x[0.5]", "E209", 3, 3, "a whole number"),
        ("x[2:1]", "E217", 3, 3, "the slice is empty"),
        ("x[:5]", "E217", 4, 1, "out of range"),
        ("x[0, 0]", "E217", 1, 7, "more indices than axes"),
        ("n[0]", "E217", 1, 4, "more indices than axes"),
    ],
)
def test_what_has_no_value(text: str, code: str, column: int, length: int, words: str) -> None:
    with pytest.raises(DiagnosisError) as caught:
        value(text)
    (diagnosis,) = caught.value.diagnoses
    assert diagnosis.code == code
    assert diagnosis.position == Position("p.yaml", 1, column, length)
    assert words in diagnosis.render()
    assert diagnosis.source_line == text


def test_every_function_is_known_to_the_judge_and_runs() -> None:
    assert set(FUNCTIONS) <= set(NUMPY)
    for name in FUNCTIONS:
        argument = "[0.5, 1]" if name == "diag" else "1"
        assert np.all(np.isfinite(value(f"{name}({argument})").array)), name


def test_a_parameter_without_a_unit_is_not_a_plain_number() -> None:
    """Its default may be a plain number, but ``dt: 0.048`` is in s, said or not."""
    at = Position("p.yaml", 1, 1)
    dt = evaluate(parse_expression("0.048", at), {})
    rate = Quantity(np.array(2.0), U("kt/s"))
    names = {"dt": dt, "rate": rate, "v": NAMES["v"], "k": Quantity(np.array(2.0), U("s"), literal=True)}
    assert dt.literal
    assert evaluate(parse_expression("dt*rate", at), names).unit is None
    assert evaluate(parse_expression("v + dt*rate", at), names).unit is U("kt")
    assert evaluate(parse_expression("0.048*rate", at), names).unit is U("kt/s")
    assert evaluate(parse_expression("k*rate", at), names).unit is U("kt")
    with pytest.raises(DiagnosisError, match="E211"):
        evaluate(parse_expression("v + 0.048*rate", at), names)


def test_words() -> None:
    assert value("mode").text == "matrix"


def test_long_tables_are_fast_and_right() -> None:
    numbers = [math.sin(k) for k in range(20_000)]
    node = parse_expression("[0]", Position("p.yaml", 1, 1))
    from saoflow.diagrams.expression import Array, Number

    array = Array(tuple(Number(x, node.position) for x in numbers), node.position)
    np.testing.assert_array_equal(evaluate(array, {}).array, numbers)


def test_names_in_order() -> None:
    tree = parse_expression("a.b + f(c)[d:e] - [g, -h, 1]", Position("p.yaml", 1, 1))
    assert [name.text for name in names_in(tree)] == ["a", "c", "d", "e", "g", "h"]
