"""The signed sum, left to right: shared by the sum and the matrix product."""

from __future__ import annotations

from collections.abc import Iterable

from saoflow.operations import MINUS_ONE, ZERO, Atom, Expander, Literal


def signed_sum(terms: Iterable[tuple[int, Atom]], emit: Expander) -> Atom:
    """Add the terms left to right, leaving out structural zeros.

    A leading negative term costs nothing if a positive one follows: (-a) + b and b - a have the same bits.
    """
    total: Atom | None = None
    negative = False
    for sign, atom in terms:
        if isinstance(atom, Literal) and atom.is_zero:
            continue
        if total is None:
            total, negative = atom, sign < 0
        elif negative and sign > 0:
            total, negative = emit.subtract(atom, total), False
        else:
            if negative:
                total, negative = emit.multiply(MINUS_ONE, total), False
            total = emit.add(total, atom) if sign > 0 else emit.subtract(total, atom)
    if total is None:
        return ZERO
    return emit.multiply(MINUS_ONE, total) if negative else total


def signed_product(a: Atom, b: Atom, emit: Expander) -> tuple[int, Atom]:
    """``a * b`` as a sign and an atom: a structural -1 only turns the sign."""
    if a == MINUS_ONE:
        return -1, b
    if b == MINUS_ONE:
        return -1, a
    return 1, emit.multiply(a, b)
