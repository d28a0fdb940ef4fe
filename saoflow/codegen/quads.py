"""Rows of four numbers at places of their own for every lane: loaded whole, then turned so that each column is a vector.

A load of a row takes the place of one for each number; needs ``__builtin_shufflevector`` (clang, gcc 12).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from saoflow.codegen.tree import (
    AddressOf,
    Binary,
    Call,
    Cast,
    Declare,
    Directive,
    Element,
    Expression,
    Integer,
    Item,
    Statement,
    TypeAlias,
    Variable,
)


def quads_fit(lanes: int) -> bool:
    """Whether this many lanes are made of whole quads."""
    return lanes in (4, 8, 16)


def quad_items(bits: int) -> tuple[Item, ...]:
    """The type of a row; it may lie at any number of the array."""
    element, size = ("double", 32) if bits == 64 else ("float", 16)
    return (TypeAlias("quads", element, f"vector_size({size}), aligned({size // 4}), may_alias"),)


def turned(
    array: str, places: Sequence[Variable], further: int, columns: Mapping[int, str], bits: int
) -> list[Statement]:
    """``const reals``, a name for each of ``columns``: of the rows that begin ``further`` behind ``places``, lane by lane."""
    lanes, mark = len(places), f"{further}_" if further else ""
    body: list[Statement] = []
    for lane, place in enumerate(places):
        start = Binary("+", place, Integer(further, True)) if further else place
        row = Cast("const quads *", AddressOf(Element(Variable(array), start)))
        body.append(Declare("const quads", f"q{mark}{lane}", Element(row, Integer(0))))
    # Rows k, k + 4, k + 8, ... side by side.
    for k in range(4):
        rows: list[Expression] = [Variable(f"q{mark}{lane}") for lane in range(k, lanes, 4)]
        while len(rows) > 1:
            width = 8 * (lanes // 4) // len(rows)
            rows = [_mixed(a, b, range(width)) for a, b in zip(rows[::2], rows[1::2], strict=True)]
        body.append(Declare("const reals", f"a{mark}{k}", rows[0]))
    # Within each four: two columns of two rows, then one column of four rows. Which two: what one instruction does.
    for part, pair in enumerate(((0, 1), (2, 3)) if bits == 32 else ((0, 2), (1, 3))):
        wanted = [column for column in pair if column in columns]
        halves = [Variable(f"h{mark}{part}{k}") for k in (0, 2)]
        picks = [4 * g + row * lanes + c for g in range(lanes // 4) for c in pair for row in (0, 1)]
        for k, half in zip((0, 2), halves, strict=True) if wanted else ():
            a, b = Variable(f"a{mark}{k}"), Variable(f"a{mark}{k + 1}")
            body.append(Declare("const reals", half.name, _mixed(a, b, picks)))
        for column in wanted:
            at = 2 * pair.index(column)
            picks = [4 * g + row * lanes + at + k for g in range(lanes // 4) for row in (0, 1) for k in (0, 1)]
            body.append(Declare("const reals", columns[column], _mixed(halves[0], halves[1], picks)))
    return body


def _mixed(a: Expression, b: Expression, picks: Sequence[int]) -> Expression:
    return Call("__builtin_shufflevector", (a, b, *(Integer(i) for i in picks)))


def guarded(fast: Sequence[Item], plain: Sequence[Item]) -> tuple[Item, ...]:
    """The first items where the compiler has the shuffle, else the others."""
    have = Directive("if defined(__clang__) || (defined(__GNUC__) && __GNUC__ >= 12)")
    return (have, *fast, Directive("else"), *plain, Directive("endif"))
