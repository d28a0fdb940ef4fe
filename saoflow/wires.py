"""The type of a wire: real or boolean, its shape, and the unit of its elements."""

from __future__ import annotations

import math
from dataclasses import dataclass

from saoflow.units import Unit, Units, per_element

MOST_ELEMENTS = 1_000_000
"""Bound on the elements of one wire, on what one delay remembers, and on the products of one matrix product."""


@dataclass(frozen=True, slots=True)
class WireType:
    """What travels on a wire. Shape () is a scalar, (n,) a vector, (n, m) a matrix; stacks of folds may have more axes."""

    shape: tuple[int, ...] = ()
    boolean: bool = False
    units: Units = None

    @property
    def size(self) -> int:
        """How many scalars."""
        return math.prod(self.shape)

    def unit_at(self, flat: int) -> Unit | None:
        """The unit of one element by its row-major number."""
        return self.units[flat] if isinstance(self.units, tuple) else self.units

    def element_units(self) -> tuple[Unit | None, ...]:
        """The unit of every element."""
        return per_element(self.units, self.size)

    def __str__(self) -> str:
        kind = "boolean" if self.boolean else "real"
        shape = "scalar" if not self.shape else "[" + ", ".join(map(str, self.shape)) + "]"
        return f"{kind} {shape}{unit_suffix(self.units)}"


def wrong_unit_count(units: Units, shape: tuple[int, ...]) -> str:
    """Why per-element units do not fit a shape: ``3 units for 4 elements``; empty if they do."""
    size = math.prod(shape)
    if not isinstance(units, tuple) or len(units) == size:
        return ""
    return f"{len(units)} units for {size} element{'' if size == 1 else 's'}"


def unit_suffix(units: Units) -> str:
    """The unit for display, with a leading space: `` kt``, `` (rad, m/s, m/s)``, or nothing."""
    if units is None:
        return ""
    if isinstance(units, tuple):
        return " (" + ", ".join("?" if u is None else str(u) for u in units) + ")"
    return f" {units}"


def shape_text(shape: tuple[int, ...]) -> str:
    """A shape as messages show it: ``[4, 3]``, or ``a scalar``."""
    return "[" + ", ".join(map(str, shape)) + "]" if shape else "a scalar"
