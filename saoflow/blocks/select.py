"""``select``: elements, slices and rows of a wire. Wiring: costs nothing."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from saoflow.blocks.symbol import Arguments, Parameter, Port, Symbol, SymbolProblem, connected, present
from saoflow.operations import Expander, Tensor
from saoflow.units import collapse
from saoflow.wires import WireType, shape_text


@dataclass(frozen=True, slots=True)
class Span:
    """``start:stop`` of one axis; None: from the end that is left out."""

    start: int | None
    stop: int | None


@dataclass(frozen=True, slots=True)
class Selection:
    """One index or span per leading axis; axes that are not named are kept whole."""

    indices: tuple[int | Span, ...]
    leading: int | None = None
    """How many slices the first axis must have (a fold that takes one slice per instance)."""


class Select(Symbol[Selection]):
    """In an operand it is written with brackets: ``P[0, 1]``, ``P_f[:-1]``."""

    name: ClassVar[str] = "select"
    summary: ClassVar[str] = (
        "elements of a wire, counted from 0, negative from the end; as an operand: x[i], P[i, j], s[:-1]"
    )
    equation: ClassVar[str] = "y = u[i, ...]"
    glyph: ClassVar[str] = '<path class="stroke" d="M-10-14H-14V14H-10M10-14H14V14H10"/><circle class="dot" r="3"/>'
    examples: ClassVar[tuple[str, ...]] = (
        "{select: v, index: 2}",
        "{select: A, index: [0, 1]}",
    )
    ports: ClassVar[tuple[Port, ...]] = (Port("u", "a vector, a matrix or a stack"),)
    parameters: ClassVar[tuple[Parameter, ...]] = (
        Parameter("index", "array", "one whole number per leading axis: index: 2, index: [0, 1]"),
    )

    def configure(self, arguments: Arguments, signs: tuple[int, ...]) -> Selection:
        """Raises SymbolProblem E216."""
        given = arguments["index"].array if "index" in arguments else None
        if given is None:
            return Selection(())
        indices = np.atleast_1d(given)
        if indices.ndim != 1 or not all(np.isfinite(i) and i == int(i) for i in indices):
            raise SymbolProblem(
                "E216",
                "`index` must be whole numbers",
                "one number per leading axis is needed",
                "write index: [0, 1]",
                parameter="index",
            )
        return Selection(tuple(int(i) for i in indices))

    def output_type(self, inputs: tuple[WireType | None, ...], configuration: Selection) -> WireType:
        """Axes with an index disappear, axes with a span shrink. Raises SymbolProblem E217."""
        (wire,) = present(inputs)
        if configuration.leading is not None and wire.shape[:1] != (configuration.leading,):
            raise SymbolProblem(
                "E204",
                "the stack does not have one slice per instance",
                f"the wire is {shape_text(wire.shape)}, and there are {configuration.leading} instances",
                "stack as many slices as there are instances, or connect it under `in` for all of them",
                operand=0,
            )
        chosen = _choose(wire.shape, configuration)
        units = wire.units
        if isinstance(units, tuple):
            units = collapse([units[int(i)] for i in chosen.ravel()])
        return WireType(chosen.shape, wire.boolean, units)

    def expand(
        self, inputs: tuple[Tensor | None, ...], output: WireType, configuration: Selection, emit: Expander
    ) -> Tensor:
        """Picks atoms."""
        (u,) = connected(inputs)
        return Tensor(output.shape, tuple(u.atoms[int(i)] for i in _choose(u.shape, configuration).ravel()))


def _choose(shape: tuple[int, ...], selection: Selection) -> np.ndarray:
    """The row-major numbers of the chosen elements, in their shape."""
    if len(selection.indices) > len(shape):
        raise SymbolProblem(
            "E217",
            "more indices than axes",
            f"the wire is {shape_text(shape)}, and {_many(len(selection.indices))} given",
            "leave out the indices that are too many",
            operand=0,
        )
    picks: list[int | slice] = []
    for axis, index in enumerate(selection.indices):
        size = shape[axis]
        if isinstance(index, int):
            if not -size <= index < size:
                raise SymbolProblem(
                    "E217",
                    f"index {index} is out of range",
                    f"axis {axis} of the wire has {size} elements, counted from 0",
                    f"use {-size} to {size - 1}",
                    operand=0,
                )
            picks.append(index)
        else:
            picks.append(slice(index.start, index.stop))
    chosen = np.arange(int(np.prod(shape, dtype=int))).reshape(shape)[tuple(picks)]
    if chosen.size == 0:
        raise SymbolProblem(
            "E217",
            "the slice is empty",
            f"nothing of {shape_text(shape)} is left",
            "widen the slice",
            operand=0,
        )
    return np.asarray(chosen)


def _many(count: int) -> str:
    return "1 index is" if count == 1 else f"{count} indices are"
