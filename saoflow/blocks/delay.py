"""``delay``: the value of n frames ago, with an initial value; the only symbol with state, and what breaks loops."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from saoflow.blocks.symbol import Arguments, Parameter, Port, Symbol, SymbolProblem, count_of, need_room, word_of
from saoflow.operations import Expander, Tensor
from saoflow.units import Units, collapse, conversion_hint
from saoflow.wires import MOST_ELEMENTS, WireType, shape_text

LONGEST = 10_000


@dataclass(frozen=True, slots=True)
class Memory:
    """Initial value (scalar: for every element), frames of delay, and what is declared of the shape and unit."""

    initial: np.ndarray
    frames: int
    shape: tuple[int, ...] | None
    units: Units
    boolean: bool | None
    """None: not stated."""


TYPE = Parameter("type", "word", "real or boolean wire, where a loop hides it", ("real", "boolean"))


class Delay(Symbol[Memory]):
    """Its output type comes from ``shape``, else from an initial value that is no scalar, else from its input."""

    name: ClassVar[str] = "delay"
    summary: ClassVar[str] = "the value of n frames ago; before that, the initial value"
    equation: ClassVar[str] = "y_k = u_{k-n};  y_k = initial for k < n"
    glyph: ClassVar[str] = '<text class="sign">z<tspan class="up" dy="-7">−1</tspan></text>'
    examples: ClassVar[tuple[str, ...]] = (
        "{delay: x, initial: 0}",
        "{delay: v, frames: 2}",
    )
    ports: ClassVar[tuple[Port, ...]] = (Port("u", "what is remembered"),)
    parameters: ClassVar[tuple[Parameter, ...]] = (
        Parameter("initial", "array", "value before the first frame (default 0); a scalar serves every element"),
        Parameter("frames", "count", "how many frames (default 1)"),
        Parameter("shape", "array", "shape of the wire, where a loop hides it: shape: [3, 4]"),
        Parameter("unit", "unit", "unit of the wire, where a loop hides it"),
        TYPE,
    )
    feeds_through: ClassVar[bool] = False

    def configure(self, arguments: Arguments, signs: tuple[int, ...]) -> Memory:
        """Raises SymbolProblem E208, E216."""
        initial = arguments["initial"].array if "initial" in arguments else None
        initial = np.zeros(()) if initial is None else initial
        if not np.all(np.isfinite(initial)):
            raise SymbolProblem(
                "E208",
                "the initial value must be finite",
                "it contains NaN or infinity",
                "give a finite start value",
                parameter="initial",
            )
        units = arguments["unit"].unit if "unit" in arguments else None
        if units is None and "initial" in arguments:
            units = arguments["initial"].unit
        boolean = word_of(arguments, TYPE) == "boolean" if "type" in arguments else None
        return Memory(
            initial,
            count_of(arguments, "frames", 1, 1, LONGEST),
            self._shape(arguments, initial),
            units,
            boolean,
        )

    def _shape(self, arguments: Arguments, initial: np.ndarray) -> tuple[int, ...] | None:
        if "shape" not in arguments:
            return initial.shape if initial.ndim else None
        given = arguments["shape"].array
        sizes = np.atleast_1d(given) if given is not None else np.zeros(0)
        if sizes.ndim != 1 or any(n != int(n) or not 1 <= n <= MOST_ELEMENTS for n in sizes):
            raise SymbolProblem(
                "E216",
                "`shape` must be whole numbers",
                f"each axis has 1 to {MOST_ELEMENTS} elements",
                "write shape: [3] or shape: [3, 4]; [] is a scalar",
                parameter="shape",
            )
        shape = tuple(int(n) for n in sizes)
        if initial.ndim and initial.shape != shape:
            raise SymbolProblem(
                "E204",
                "`initial` and `shape` disagree",
                f"initial is {shape_text(initial.shape)}, shape says {shape_text(shape)}",
                "leave one of them out",
                parameter="initial",
            )
        return shape

    def glyph_of(self, configuration: Memory) -> str:
        """z to the power of minus the number of frames."""
        return f'<text class="sign">z<tspan class="up" dy="-7">−{configuration.frames}</tspan></text>'

    def output_type(self, inputs: tuple[WireType | None, ...], configuration: Memory) -> WireType:
        """The input may still be unknown (None) while a loop is being typed: then what is declared counts."""
        wire = inputs[0] if inputs else None
        shape = configuration.shape
        if shape is None:
            shape = wire.shape if wire is not None else ()
        units = configuration.units if configuration.units is not None or wire is None else wire.units
        need_room(math.prod(shape) * configuration.frames, "what the delay remembers")
        boolean = configuration.boolean
        if boolean is None:
            boolean = wire is not None and wire.boolean
        return WireType(shape, boolean, units)

    def check_input(self, wire: WireType, output: WireType) -> None:
        """Does what arrives fit what is remembered? Raises SymbolProblem E220."""
        if wire.shape != output.shape:
            raise SymbolProblem(
                "E220",
                "the delay's shape does not match its input",
                f"the delay holds {shape_text(output.shape)}, the input is {shape_text(wire.shape)}",
                f"give the delay shape: {list(wire.shape)}, or an initial value of that shape",
                operand=0,
            )
        if wire.boolean != output.boolean:
            kind = "boolean" if wire.boolean else "real"
            raise SymbolProblem(
                "E220",
                f"the delay's input is {kind}, its output is not",
                "its type is stated, or a loop through the delay hides that of its wire",
                f"give the delay type: {kind}",
                operand=0,
            )
        pairs = zip(wire.element_units(), output.element_units(), strict=True)
        for a, b in pairs:
            if a is not None and b is not None and a != b:
                raise SymbolProblem(
                    "E220",
                    "the delay's unit does not match its input",
                    f"the delay holds {b}, the input is in {a}: {conversion_hint(a, b)}",
                    f"give the delay unit: {a}, or convert the input",
                    operand=0,
                )

    def expand(
        self, inputs: tuple[Tensor | None, ...], output: WireType, configuration: Memory, emit: Expander
    ) -> Tensor:
        """A delay expands into state reads and writes, which the lowering makes itself."""
        raise AssertionError("the lowering reads and writes state itself")

    def initial_elements(self, configuration: Memory, output: WireType) -> tuple[float, ...]:
        """The initial value of every element, row-major."""
        spread = np.broadcast_to(configuration.initial, output.shape) if output.shape else configuration.initial
        return tuple(float(v) for v in np.ravel(spread))


def merge_units(known: Units, found: Units, size: int) -> Units:
    """Fill the elements whose unit is not stated from another knowledge of the same wire."""
    if known is None or found is None:
        return found if known is None else known
    a = WireType((size,), False, known).element_units()
    b = WireType((size,), False, found).element_units()
    return collapse([y if x is None else x for x, y in zip(a, b, strict=True)])
