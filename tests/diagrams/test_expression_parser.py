"""The expression language: precedence against Python's own, places, and what is refused."""

from __future__ import annotations

import ast

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from saoflow.diagnosis import DiagnosisError, Position
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
from saoflow.diagrams.expression_parser import (
    DEEPEST,
    LONGEST,
    LONGEST_NAME,
    NESTED,
    children,
    height,
    parse_expression,
)

AT = Position("sheet.yaml", 4, 11)


def parse(text: str) -> Expression:
    return parse_expression(text, AT, " " * 10 + text)


def shown(node: Expression | Slice) -> str:
    """The tree with every operation in parentheses."""
    match node:
        case Number():
            return f"{node.value!r}"
        case Name() | Text():
            return node.text
        case Member():
            return f"{shown(node.base)}.{node.name}"
        case Slice():
            return f"{shown(node.start) if node.start else ''}:{shown(node.stop) if node.stop else ''}"
        case Index():
            return f"{shown(node.base)}[{', '.join(map(shown, node.indices))}]"
        case Call():
            return f"{node.function.text}({', '.join(map(shown, node.arguments))})"
        case Unary():
            return f"({node.operator}{shown(node.operand)})"
        case Binary():
            return f"({shown(node.left)} {node.operator} {shown(node.right)})"
        case Array():
            return f"[{', '.join(map(shown, node.items))}]"


def python_shown(node: ast.expr) -> str:
    """The same of Python's tree, for the part of the language that Python shares."""
    operators = {ast.Add: "+", ast.Sub: "-", ast.Mult: "*", ast.Div: "/", ast.Pow: "^", ast.USub: "-", ast.UAdd: "+"}
    match node:
        case ast.Constant():
            return repr(float(str(node.value)))
        case ast.Name():
            return node.id
        case ast.Attribute():
            return f"{python_shown(node.value)}.{node.attr}"
        case ast.UnaryOp():
            return f"({operators[type(node.op)]}{python_shown(node.operand)})"
        case ast.BinOp():
            return f"({python_shown(node.left)} {operators[type(node.op)]} {python_shown(node.right)})"
        case ast.Call():
            return f"{python_shown(node.func)}({', '.join(map(python_shown, node.args))})"
        case ast.List():
            return f"[{', '.join(map(python_shown, node.elts))}]"
        case _:
            raise TypeError(type(node))


atoms = st.sampled_from(["a", "P_hat", "x1", "2", "0.5", "1e-3", "3.", ".25", "stages.P", "C.T", "f()", "[a, 2]"])
texts = st.recursive(
    atoms,
    lambda inner: st.one_of(
        st.tuples(inner, st.sampled_from(["+", "-", "*", "/", "**", " - ", " * "]), inner).map("".join),
        st.tuples(st.sampled_from(["-", "+", "- "]), inner).map("".join),
        inner.map(lambda t: f"({t})"),
        st.tuples(inner, inner).map(lambda p: f"min({p[0]}, {p[1]})"),
    ),
    max_leaves=12,
)


@given(texts)
@settings(max_examples=400, deadline=None)
def test_precedence_is_that_of_python(text: str) -> None:
    tree = parse(text)
    plain = shown(tree)
    # a lone negative number is read as a number
    expected = python_shown(ast.parse(text, mode="eval").body)
    assert expected == plain or (isinstance(tree, Number) and expected == f"({plain})")


@pytest.mark.parametrize(
    ("text", "tree"),
    [
        ("2^-3^2*4", "((2.0 ^ (-(3.0 ^ 2.0))) * 4.0)"),
        ("-x^2", "(-(x ^ 2.0))"),
        ("a-b-c", "((a - b) - c)"),
        ("stages.P_f[:-1]", "stages.P_f[:(-1.0)]"),
        ("P[0, 1:, :n-1]", "P[0.0, 1.0:, :(n - 1.0)]"),
        ("P[:]", "P[:]"),
        ("a[0][1].T", "a[0.0][1.0].T"),
        ("[[1, 2], [3, x]]", "[[1.0, 2.0], [3.0, x]]"),
        ("[]", "[]"),
        ("-5", "-5.0"),
        ("012", "12.0"),
        ("no", "no"),
        ("on", "on"),
        ("σ + Ω_1", "(σ + Ω_1)"),
        ("_", "_"),
    ],
)
def test_trees(text: str, tree: str) -> None:
    assert shown(parse(text)) == tree


def places(node: Expression | Slice) -> list[tuple[str, int, int]]:
    """Kind, offset and length of every node."""
    where = node.position
    assert (where.file, where.line) == ("sheet.yaml", 4)
    found = [(type(node).__name__, where.column - AT.column, where.length)]
    for child in children(node):
        found += places(child)
    return found


def test_every_part_knows_its_place() -> None:
    text = "2*sqrt(kappa) - stages.P_f[:-1]"
    assert places(parse(text)) == [
        ("Binary", 0, 31),
        ("Binary", 0, 13),
        ("Number", 0, 1),
        ("Call", 2, 11),
        ("Name", 7, 5),
        ("Index", 16, 15),
        ("Member", 23, 3),
        ("Name", 16, 6),
        ("Slice", 27, 3),
        ("Unary", 28, 2),
        ("Number", 29, 1),
    ]


@given(texts)
@settings(max_examples=200, deadline=None)
def test_the_place_of_a_name_holds_the_name(text: str) -> None:
    stack: list[Expression | Slice] = [parse(text)]
    while stack:
        node = stack.pop()
        start = node.position.column - AT.column
        part = text[start : start + node.position.length]
        if isinstance(node, Name):
            assert part == node.text
        elif isinstance(node, Member):
            assert part == node.name
        elif isinstance(node, Number):
            assert float(part) == node.value
        stack.extend(children(node))


@pytest.mark.parametrize(
    ("text", "offset", "length", "message"),
    [
        ("", 0, 1, "an expression is empty"),
        ("2n", 1, 1, "`n` is not expected here"),
        ("a b", 2, 1, "`b` is not expected here"),
        ("a +", 3, 1, "an expression ends too early"),
        ("a[", 2, 1, "an expression ends too early"),
        ("a[]", 2, 1, "`]` is not expected here"),
        ("a[1", 3, 1, "an expression ends too early"),
        ("f(a,)", 4, 1, "`)` is not expected here"),
        ("(a.b)(c)", 5, 1, "`(` is not expected here"),
        ("a.5", 1, 2, "`.5` is not expected here"),
        ("a:b", 1, 1, "`:` is not expected here"),
        ("a < b", 2, 1, "`<` is not expected here"),
        ("x²", 0, 2, "`x²` is not expected here"),
        ("1e999", 0, 5, "a number is too large"),
        ("2 + 1e999", 4, 5, "a number is too large"),
        ("__import__('os')", 11, 1, "`'` is not expected here"),
        ("lambda: 0", 6, 1, "`:` is not expected here"),
    ],
)
def test_refused(text: str, offset: int, length: int, message: str) -> None:
    with pytest.raises(DiagnosisError) as caught:
        parse(text)
    (diagnosis,) = caught.value.diagnoses
    assert (diagnosis.code, diagnosis.message) == ("E111", message)
    assert diagnosis.position == Position("sheet.yaml", 4, AT.column + offset, length)
    assert diagnosis.cause
    assert diagnosis.remedy


def test_a_product_without_its_sign_is_explained() -> None:
    with pytest.raises(DiagnosisError, match=r"write 2\*n for a product"):
        parse("2n")


@pytest.mark.parametrize(
    "text",
    [
        "(" * 5000,
        "-" * 5000,
        "f(" * 3000,
        "[" * 5000,
        "a[" * 3000,
        "2^" * 3000,
        "(" * (NESTED + 1) + "1" + ")" * (NESTED + 1),
        "+".join("a" * (DEEPEST + 2)),
        "a" + ".b" * (DEEPEST + 2),
        "a" + "[0]" * (DEEPEST + 2),
        "1" * (LONGEST + 1),
        "a" * (LONGEST_NAME + 1),
        "-" + "a" * (LONGEST_NAME + 1),
    ],
)
def test_bounds(text: str) -> None:
    with pytest.raises(DiagnosisError) as caught:
        parse(text)
    assert caught.value.diagnoses[0].code == "E111"


def test_just_inside_the_bounds() -> None:
    assert height(parse("+".join("a" * DEEPEST))) == DEEPEST
    assert height(parse("(" * (NESTED - 1) + "1" + ")" * (NESTED - 1))) == 1
    assert len(parse("[" + ", ".join(["1"] * 2000) + "]").items) == 2000  # type: ignore[union-attr]
