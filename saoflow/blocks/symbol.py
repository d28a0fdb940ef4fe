"""What a symbol is: ports, parameters, type rule, feed-through and expansion, all in one class per symbol."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar, Generic, TypeVar

import numpy as np

from saoflow.formula import Formula
from saoflow.operations import Expander, Tensor
from saoflow.units import Unit, Units
from saoflow.wires import MOST_ELEMENTS, WireType, wrong_unit_count

Configuration = TypeVar("Configuration")


class SymbolProblem(Exception):
    """A symbol refuses its operands or parameters. Elaboration adds the position and makes it a diagnosis."""

    def __init__(
        self,
        code: str,
        message: str,
        cause: str,
        remedy: str,
        *,
        operand: int | None = None,
        parameter: str | None = None,
    ) -> None:
        super().__init__(message)
        self.code = code
        self.message = message
        self.cause = cause
        self.remedy = remedy
        self.operand = operand
        self.parameter = parameter


@dataclass(frozen=True, slots=True)
class Port:
    """An input port of a symbol."""

    name: str
    doc: str
    optional: bool = False
    boolean: bool = False


@dataclass(frozen=True, slots=True)
class Parameter:
    """A parameter of a symbol. ``kind``: ``array`` (a number or array), ``count``, ``word``, ``flag``, ``unit``, ``formula``."""

    name: str
    kind: str
    doc: str
    words: tuple[str, ...] = ()
    """The words allowed, for kind ``word``; the first is the default."""


@dataclass(frozen=True, slots=True)
class Given:
    """The value given to one parameter, evaluated by its kind."""

    array: np.ndarray | None = None
    unit: Unit | tuple[Unit | None, ...] | None = None
    word: str = ""
    formula: Formula | None = None


Arguments = Mapping[str, Given]
"""The parameters given to one block, by name."""


class Symbol(ABC, Generic[Configuration]):
    """A primitive block. ``Configuration`` is what its parameters come to for one block."""

    name: ClassVar[str]
    profile: ClassVar[str] = "six"
    """The smallest profile that contains the symbol."""
    summary: ClassVar[str]
    equation: ClassVar[str]
    examples: ClassVar[tuple[str, ...]]
    """Blocks as a sheet writes them, simplest first; the documentation shows them with what they cost. Wires: scalars x, y,
    z; vectors v, w of 3; 2x2 matrices A, B and D (diagonal); booleans p, q."""
    ports: ClassVar[tuple[Port, ...]]
    variadic: ClassVar[bool] = False
    """True if the last port may be given any number of times."""
    parameters: ClassVar[tuple[Parameter, ...]] = ()
    takes_signs: ClassVar[bool] = False
    """True if ``-wire`` as an operand is the symbol's own affair (the sum); elsewhere it is a product with -1."""
    feeds_through: ClassVar[bool] = True
    """False if the output does not depend on the input within the frame."""
    glyph: ClassVar[str]
    """Its drawing: SVG inside a box of 48 by 48 about the origin, with the classes ``stroke`` and ``sign``."""

    def glyph_of(self, configuration: Configuration) -> str:
        """The drawing of one block; some show their configuration."""
        return self.glyph

    @abstractmethod
    def configure(self, arguments: Arguments, signs: tuple[int, ...]) -> Configuration:
        """Check and gather the parameters of one block. Raises SymbolProblem."""

    @abstractmethod
    def output_type(self, inputs: tuple[WireType | None, ...], configuration: Configuration) -> WireType:
        """The type of the output; an optional port left open is None. Raises SymbolProblem."""

    @abstractmethod
    def expand(
        self,
        inputs: tuple[Tensor | None, ...],
        output: WireType,
        configuration: Configuration,
        emit: Expander,
    ) -> Tensor:
        """The scalar operations of one block, in the order that the semantics fix."""


def present(inputs: tuple[WireType | None, ...]) -> tuple[WireType, ...]:
    """The inputs of a symbol without optional ports."""
    return tuple(t for t in inputs if t is not None)


def connected(inputs: tuple[Tensor | None, ...]) -> tuple[Tensor, ...]:
    """The operands of a symbol without optional ports."""
    return tuple(t for t in inputs if t is not None)


def need_real(inputs: tuple[WireType | None, ...], symbol: str) -> None:
    """Refuse boolean operands. Raises SymbolProblem E210."""
    for i, wire in enumerate(inputs):
        if wire is not None and wire.boolean:
            raise SymbolProblem(
                "E210",
                f"`{symbol}` takes real numbers, not booleans",
                f"this operand is {wire}",
                "turn it into a number with a switch: {switch: [flag, 1, 0]}",
                operand=i,
            )


def need_boolean(inputs: tuple[WireType | None, ...], symbol: str) -> None:
    """Refuse real operands. Raises SymbolProblem E210."""
    for i, wire in enumerate(inputs):
        if wire is not None and not wire.boolean:
            raise SymbolProblem(
                "E210",
                f"`{symbol}` takes booleans, not real numbers",
                f"this operand is {wire}",
                'compare it first: {compare: [x, 0.5], relation: ">"}',
                operand=i,
            )


def need_room(elements: int, what: str) -> None:
    """Refuse what could not be laid out element by element. Raises SymbolProblem E219."""
    if elements > MOST_ELEMENTS:
        raise SymbolProblem(
            "E219",
            f"{what} is too large",
            f"it has {elements} elements, and at most {MOST_ELEMENTS} can be laid out one by one",
            "make the wires smaller",
        )


def need_units(units: Units, shape: tuple[int, ...]) -> None:
    """Refuse units per element that are not one per element. Raises SymbolProblem E211."""
    wrong = wrong_unit_count(units, shape)
    if wrong:
        raise SymbolProblem(
            "E211",
            "the units do not fit the shape of the wire",
            wrong,
            "give one unit for the whole wire, or one for each element",
        )


def word_of(arguments: Arguments, parameter: Parameter) -> str:
    """The word given to a parameter, or its default. Raises SymbolProblem E208 for another word."""
    if parameter.name not in arguments:
        return parameter.words[0]
    word = arguments[parameter.name].word
    if word not in parameter.words:
        raise SymbolProblem(
            "E208",
            f"`{parameter.name}` cannot be `{word}`",
            f"it is one of: {', '.join(parameter.words)}",
            f"write {parameter.name}: {parameter.words[0]}",
            parameter=parameter.name,
        )
    return word


def count_of(arguments: Arguments, name: str, default: int, least: int, most: int) -> int:
    """A whole number in a range given to a parameter. Raises SymbolProblem E216."""
    if name not in arguments:
        return default
    array = arguments[name].array
    value = float(array) if array is not None and array.ndim == 0 else float("nan")
    if not (value == int(value) if np.isfinite(value) else False) or not least <= value <= most:
        shown = "an array" if array is not None and array.ndim else f"{value:g}"
        raise SymbolProblem(
            "E216",
            f"`{name}` must be a whole number",
            f"it is {shown}, and must lie in {least} to {most}",
            f"write {name}: {max(least, 1)}",
            parameter=name,
        )
    return int(value)
