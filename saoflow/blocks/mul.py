"""``mul``: the element-wise product, and the matrix product."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import reduce
from typing import ClassVar

from saoflow.blocks.elementwise import common_shape, element
from saoflow.blocks.summation import signed_product, signed_sum
from saoflow.blocks.symbol import (
    Arguments,
    Parameter,
    Port,
    Symbol,
    SymbolProblem,
    connected,
    need_real,
    need_room,
    present,
    word_of,
)
from saoflow.operations import Atom, Expander, Tensor
from saoflow.units import Unit, Units, collapse, conversion_hint
from saoflow.wires import WireType, shape_text

PRODUCT = Parameter("product", "word", "element-wise, or the matrix product", ("elements", "matrix"))
SYMMETRIC = Parameter(
    "symmetric",
    "flag",
    "the matrix product is symmetric by construction: only its upper triangle is computed",
    ("false", "true"),
)


@dataclass(frozen=True, slots=True)
class Product:
    """Which product, and whether its result is declared symmetric."""

    matrix: bool
    symmetric: bool


class Mul(Symbol[Product]):
    """Configured by the kind of product."""

    name: ClassVar[str] = "mul"
    summary: ClassVar[str] = "product of the operands, left to right: element by element, or of matrices and vectors"
    equation: ClassVar[str] = "y = u1 · u2 · ...;  product: matrix: y_ij = sum_k a_ik b_kj, k increasing"
    glyph: ClassVar[str] = '<text class="sign">×</text>'
    examples: ClassVar[tuple[str, ...]] = (
        "{mul: [x, y]}",
        "{mul: [A, B], product: matrix}",
        "{mul: [A, D, A.T], product: matrix, symmetric: true}",
    )
    ports: ClassVar[tuple[Port, ...]] = (Port("u", "an operand; a scalar multiplies every element"),)
    variadic: ClassVar[bool] = True
    parameters: ClassVar[tuple[Parameter, ...]] = (PRODUCT, SYMMETRIC)

    def configure(self, arguments: Arguments, signs: tuple[int, ...]) -> Product:
        """Read ``product`` and ``symmetric``. Raises SymbolProblem E208."""
        matrix = word_of(arguments, PRODUCT) == "matrix"
        symmetric = word_of(arguments, SYMMETRIC) == "true"
        if symmetric and not matrix:
            raise SymbolProblem(
                "E208",
                "`symmetric` is about matrix products",
                "this product is element by element",
                "add product: matrix, or leave out symmetric",
                parameter="symmetric",
            )
        return Product(matrix, symmetric)

    def glyph_of(self, configuration: Product) -> str:
        """The element-wise product, or the matrix product."""
        return '<text class="sign">×</text>' if not configuration.matrix else '<text class="sign">[×]</text>'

    def output_type(self, inputs: tuple[WireType | None, ...], configuration: Product) -> WireType:
        """Element-wise: the common shape. Matrix: rows of the first by columns of the last. Units multiply."""
        need_real(inputs, self.name)
        operands = present(inputs)
        if not configuration.matrix:
            shape = common_shape(inputs, self.name)
            return WireType(shape, False, _element_units(operands, shape))
        result = operands[0]
        _need_at_most_matrix(result, 0)
        for i, wire in enumerate(operands[1:], start=1):
            result = _matrix_type(result, wire, i)
        if configuration.symmetric and (len(result.shape) != 2 or result.shape[0] != result.shape[1]):
            raise SymbolProblem(
                "E204",
                "a symmetric product is a square matrix",
                f"this product is {shape_text(result.shape)}",
                "leave out symmetric: true",
                parameter="symmetric",
            )
        return result

    def expand(
        self, inputs: tuple[Tensor | None, ...], output: WireType, configuration: Product, emit: Expander
    ) -> Tensor:
        """Products left to right; matrix products sum over the inner index in increasing order."""
        operands = connected(inputs)
        if not configuration.matrix:
            atoms = (
                reduce(emit.multiply, (element(u, i) for u in operands[1:]), element(operands[0], i))
                for i in range(output.size)
            )
            return Tensor(output.shape, tuple(atoms))
        result = operands[0]
        for i, operand in enumerate(operands[1:], start=1):
            result = _matrix_product(result, operand, configuration.symmetric and i == len(operands) - 1, emit)
        return result


def _element_units(operands: tuple[WireType, ...], shape: tuple[int, ...]) -> Units:
    if all(not isinstance(w.units, tuple) for w in operands):
        return reduce(_times, (w.units for w in operands if not isinstance(w.units, tuple)))
    size = WireType(shape).size
    spread = [w.element_units() if w.shape else w.element_units() * size for w in operands]
    return collapse([reduce(_times, units) for units in zip(*spread, strict=True)])


def _times(a: Unit | None, b: Unit | None) -> Unit | None:
    return None if a is None or b is None else a * b


def _need_at_most_matrix(wire: WireType, operand: int) -> None:
    if not 1 <= len(wire.shape) <= 2:
        raise SymbolProblem(
            "E204",
            "a matrix product takes vectors and matrices",
            f"operand {operand + 1} is {shape_text(wire.shape)}",
            "use product: elements to multiply by a scalar" if not wire.shape else "select a slice of the stack",
            operand=operand,
        )


def _matrix_type(left: WireType, right: WireType, operand: int) -> WireType:
    _need_at_most_matrix(right, operand)
    if not left.shape:
        raise SymbolProblem(
            "E204",
            "a matrix product takes vectors and matrices",
            f"the product up to operand {operand} is a scalar already",
            "use product: elements to multiply by a scalar",
            operand=operand,
        )
    if left.shape[-1] != right.shape[0]:
        raise SymbolProblem(
            "E204",
            "shapes do not multiply",
            f"operand {operand} gives {shape_text(left.shape)}, operand {operand + 1} is {shape_text(right.shape)}: "
            f"{left.shape[-1]} columns meet {right.shape[0]} rows",
            "transpose one of them (write .T), or select the columns you mean",
            operand=operand,
        )
    shape = left.shape[:-1] + right.shape[1:]
    need_room(math.prod(shape) * right.shape[0], "the matrix product")
    return WireType(shape, False, _matrix_units(left, right, operand))


def _matrix_units(left: WireType, right: WireType, operand: int) -> Units:
    if left.units is None or right.units is None:
        return None
    if not isinstance(left.units, tuple) and not isinstance(right.units, tuple):
        return left.units * right.units
    rows = left.shape[0] if len(left.shape) == 2 else 1
    columns = right.shape[1] if len(right.shape) == 2 else 1
    inner = right.shape[0]
    found: list[Unit | None] = []
    for r in range(rows):
        for c in range(columns):
            unit: Unit | None = None
            for k in range(inner):
                term = _times(left.unit_at(r * inner + k), right.unit_at(k * columns + c))
                if term is None:
                    continue
                if unit is not None and unit != term:
                    raise SymbolProblem(
                        "E211",
                        "the terms of a matrix product have different units",
                        f"element ({r}, {c}) sums {unit} and {term}: {conversion_hint(unit, term)}",
                        "check the units of the rows and columns that meet",
                        operand=operand,
                    )
                unit = term
            found.append(unit)
    return collapse(found)


def _matrix_product(a: Tensor, b: Tensor, symmetric: bool, emit: Expander) -> Tensor:
    rows = a.shape[0] if len(a.shape) == 2 else 1
    columns = b.shape[1] if len(b.shape) == 2 else 1
    inner = b.shape[0]
    atoms: list[Atom] = []
    for r in range(rows):
        for c in range(columns):
            if symmetric and c < r:
                atoms.append(atoms[c * columns + r])
                continue
            terms = [signed_product(a.atoms[r * inner + k], b.atoms[k * columns + c], emit) for k in range(inner)]
            atoms.append(signed_sum(terms, emit))
    return Tensor(a.shape[:-1] + b.shape[1:], tuple(atoms))
