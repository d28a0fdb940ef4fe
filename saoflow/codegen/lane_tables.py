"""Look-ups in lanes: the search starts from a guide, so that a step or two find what the plain search takes nine for.

The guide divides the range evenly: bucket(u) = (int)((u - low) * scale). Subtraction, multiplication by a positive number
and truncation never decrease with u, rounding included, so every breakpoint of an earlier bucket is below u and every one of
a later bucket above. The interval is therefore found by comparisons with breakpoints, as in the plain search, and so are
its bits; the guide only says where to begin.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from saoflow.codegen.tree import (
    Assign,
    Binary,
    Call,
    Compound,
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
    Repeat,
    Return,
    Statement,
    Variable,
)
from saoflow.operations import Table
from saoflow.table_evaluation import PreparedTable, prepare

MOST_BUCKETS = 4096


@dataclass(frozen=True, slots=True, eq=False)
class Guide:
    """``first[bucket]``: the last breakpoint of an earlier bucket (0 if there is none); ``within``: most in one bucket."""

    scale: float
    first: np.ndarray
    within: int


def guide_of(x: np.ndarray) -> Guide | None:
    """A guide to increasing breakpoints (n,), made in their own type; None where it would not help."""
    best: Guide | None = None
    buckets = 1 << max(2, int(x.size - 1).bit_length())
    while buckets <= MOST_BUCKETS and (best is None or best.within > 1):
        scale = x.dtype.type(buckets) / (x[-1] - x[0])
        if not np.isfinite(scale):
            return None
        bucket = ((x - x[0]) * scale).astype(np.int64)
        before = np.searchsorted(bucket, np.arange(bucket[-1] + 1), side="left")
        guide = Guide(float(scale), np.maximum(before - 1, 0), int(np.bincount(bucket).max()))
        if best is None or _steps(guide) < _steps(best):
            best = guide
        buckets *= 2
    return best if best is not None and _steps(best) + 2 < int(x.size).bit_length() else None


def _steps(guide: Guide) -> int:
    return int(guide.within).bit_length()


def lane_lookup(name: str, table: Table, bits: int, lanes: int) -> tuple[Item, ...]:
    """``name_lanes``: the table for every lane."""
    prepared = prepare(table, np.float64 if bits == 64 else np.float32)
    if len(prepared.breakpoints) == 1 and prepared.breakpoints[0].size < 1 << 16:
        guide = guide_of(prepared.breakpoints[0])
        if guide is not None:
            return _guided(name, prepared, guide, bits, lanes)
    given = [Variable(c) for c in "uv"[: len(prepared.breakpoints)]]
    lane, out = Variable("l"), Variable("out")
    look = Assign(Element(out, lane), Call(name, tuple(Element(u, lane) for u in given)))
    body = (Declare("reals", "out", None), Repeat("l", lanes, (look,)), Return(out))
    parameters = tuple(Parameter("const reals", u.name) for u in given)
    return (Function("reals", f"{name}_lanes", parameters, body, True),)


def _guided(name: str, table: PreparedTable, guide: Guide, bits: int, lanes: int) -> tuple[Item, ...]:
    kind = "double" if bits == 64 else "float"
    (x,) = table.breakpoints
    halves = [1 << k for k in reversed(range(_steps(guide)))]
    # A step may look beyond the last breakpoint: there nothing is at or below the input.
    padded = np.append(x, np.full(sum(halves), np.inf, dtype=x.dtype))
    low, high = Real(float(x[0]), bits), Real(float(x[-1]), bits)
    arrays = (
        ConstantArray("unsigned short", f"{name}_guide", tuple(Integer(int(i)) for i in guide.first), ""),
        ConstantArray(kind, f"{name}_px", tuple(Real(float(v), bits) for v in padded), ""),
    )
    limited, bucket = Variable("x"), Variable("b")
    away = Binary("-", limited, Call("every_real", (low,)))
    scaled = Binary("*", away, Call("every_real", (Real(guide.scale, bits),)))
    body: list[Statement] = [
        Declare("const reals", "a", Call("larger", (Variable("u"), Call("every_real", (low,))))),
        Declare("const reals", "x", Call("smaller", (Variable("a"), Call("every_real", (high,))))),
        Declare("const places", "b", Call("__builtin_convertvector", (scaled, Variable("places")))),
    ]
    places = [Variable(f"i{lane}") for lane in range(lanes)]
    for lane, place in enumerate(places):
        start = Element(Variable(f"{name}_guide"), Element(bucket, Integer(lane)))
        body.append(Declare("unsigned int", place.name, start))
    for half in halves:
        for lane, place in enumerate(places):
            ahead = Binary("+", place, Integer(half, True))
            there = Binary("<=", Element(Variable(f"{name}_px"), ahead), Element(limited, Integer(lane)))
            body.append(Assign(place, Conditional(there, ahead, place)))

    def gathered(array: str) -> Expression:
        return Compound("reals", tuple(Element(Variable(f"{name}_{array}"), place) for place in places))

    body.append(Declare("const reals", "y", gathered("y")))
    if table.linear:
        body.append(Declare("const reals", "p", gathered("px")))
        body.append(Declare("const reals", "s", gathered("s")))
        slope = Binary("*", Binary("-", limited, Variable("p")), Variable("s"))
        body.append(Return(Binary("+", Variable("y"), slope)))
    else:
        body.append(Return(Variable("y")))
    return (*arrays, Function("reals", f"{name}_lanes", (Parameter("const reals", "u"),), tuple(body), True))
