"""Look-up tables in C: constant arrays, and a search whose steps do not depend on the data."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from saoflow.codegen.tree import (
    Assign,
    Binary,
    Conditional,
    ConstantArray,
    Declare,
    Element,
    Expression,
    Function,
    Integer,
    Item,
    Parameter,
    Real,
    Return,
    Statement,
    Variable,
)
from saoflow.operations import Table
from saoflow.tables.evaluation import PreparedTable, prepare


def table_items(name: str, table: Table, bits: int) -> tuple[Item, ...]:
    """The arrays of a table and its function ``name``, with the bits of ``tables/evaluation.py``."""
    real_type = "double" if bits == 64 else "float"
    prepared = prepare(table, np.float64 if bits == 64 else np.float32)
    what = f"Table {table.name}: {' by '.join(str(x.size) for x in prepared.breakpoints)} points"
    build = _one_axis if len(prepared.breakpoints) == 1 else _two_axes
    return build(name, prepared, real_type, bits, what)


def _array(name: str, values: np.ndarray, real_type: str, bits: int, comment: str = "") -> ConstantArray:
    return ConstantArray(real_type, name, tuple(Real(float(v), bits) for v in np.ravel(values)), comment)


def search_steps(points: int) -> Iterator[int]:
    """How far each step of the search looks ahead: the same for every input."""
    size = points
    while size > 1:
        half = size // 2
        yield half
        size -= half


def _limited(u: str, out: str, x: np.ndarray, real_type: str, bits: int) -> Iterator[Statement]:
    low, high = Real(float(x[0]), bits), Real(float(x[-1]), bits)
    above = Variable(f"{out}_above")
    yield Declare(f"const {real_type}", above.name, Conditional(Binary(">", Variable(u), low), Variable(u), low))
    yield Declare(f"const {real_type}", out, Conditional(Binary("<", above, high), above, high))


def _search(x: Variable, array: str, index: str, points: int) -> Iterator[Statement]:
    i = Variable(index)
    yield Declare("unsigned int", index, Integer(0, True))
    for half in search_steps(points):
        ahead = Binary("+", i, Integer(half, True))
        yield Assign(i, Conditional(Binary("<=", Element(Variable(array), ahead), x), ahead, i))


def _at(array: str, index: Expression) -> Element:
    return Element(Variable(array), index)


def _one_axis(name: str, table: PreparedTable, real_type: str, bits: int, what: str) -> tuple[Item, ...]:
    (breakpoints,) = table.breakpoints
    x, i = Variable("x"), Variable("i")
    body = [
        *_limited("u", "x", breakpoints, real_type, bits),
        *_search(x, f"{name}_x", "i", breakpoints.size),
    ]
    items: list[Item] = [
        _array(f"{name}_x", breakpoints, real_type, bits, what),
        _array(f"{name}_y", table.values, real_type, bits),
    ]
    if table.linear:
        items.append(_array(f"{name}_s", table.slopes, real_type, bits))
        away = Binary("-", x, _at(f"{name}_x", i))
        body.append(Return(Binary("+", _at(f"{name}_y", i), Binary("*", away, _at(f"{name}_s", i)))))
    else:
        body.append(Return(_at(f"{name}_y", i)))
    items.append(Function(real_type, name, (Parameter(f"const {real_type}", "u"),), tuple(body), True))
    return tuple(items)


def _two_axes(name: str, table: PreparedTable, real_type: str, bits: int, what: str) -> tuple[Item, ...]:
    first, second = table.breakpoints
    n, m = first.size, second.size
    x, y, i, j = Variable("x"), Variable("y"), Variable("i"), Variable("j")
    const = f"const {real_type}"
    here = Binary("+", Binary("*", i, Integer(m, True)), j)
    body: list[Statement] = [
        *_limited("u", "x", first, real_type, bits),
        *_limited("v", "y", second, real_type, bits),
        *_search(x, f"{name}_x", "i", n),
        *_search(y, f"{name}_y", "j", m),
        Declare("const unsigned int", "h", here),
    ]
    items: list[Item] = [
        _array(f"{name}_x", first, real_type, bits, what),
        _array(f"{name}_y", second, real_type, bits),
        _array(f"{name}_z", table.values, real_type, bits),
    ]
    h = Variable("h")
    if not table.linear:
        body.append(Return(_at(f"{name}_z", h)))
    else:
        rx, ry = table.reciprocals
        items += [
            _array(f"{name}_d", table.slopes, real_type, bits),
            _array(f"{name}_rx", rx, real_type, bits),
            _array(f"{name}_ry", ry, real_type, bits),
        ]
        last = Binary("<", i, Integer(n - 1, True))
        below = Conditional(last, Binary("+", h, Integer(m, True)), h)
        k, p, q, a, b = (Variable(c) for c in "kpqab")
        body += [
            Declare("const unsigned int", "k", below),
            Declare(const, "p", Binary("*", Binary("-", x, _at(f"{name}_x", i)), _at(f"{name}_rx", i))),
            Declare(const, "q", Binary("*", Binary("-", y, _at(f"{name}_y", j)), _at(f"{name}_ry", j))),
            Declare(const, "a", Binary("+", _at(f"{name}_z", h), Binary("*", q, _at(f"{name}_d", h)))),
            Declare(const, "b", Binary("+", _at(f"{name}_z", k), Binary("*", q, _at(f"{name}_d", k)))),
            Return(Binary("+", a, Binary("*", p, Binary("-", b, a)))),
        ]
    parameters = (Parameter(const, "u"), Parameter(const, "v"))
    items.append(Function(real_type, name, parameters, tuple(body), True))
    return tuple(items)
