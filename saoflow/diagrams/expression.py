"""The small expression language of sheets: its syntax tree.

The same syntax serves parameter arithmetic (``2*sqrt(kappa)``) and wire operands (``stages.P_f[:-1]``, ``C.T``,
``diag(R)``, ``-KPi``). Python's ``eval`` is never used. Parsing lies in ``expression_parser.py``, arithmetic on
parameters in ``expression_value.py``.
"""

from __future__ import annotations

from dataclasses import dataclass

from saoflow.diagnosis import Position


@dataclass(frozen=True, slots=True)
class Number:
    """A literal real number."""

    value: float
    position: Position


@dataclass(frozen=True, slots=True)
class Name:
    """A name: a parameter, an input, a block."""

    text: str
    position: Position


@dataclass(frozen=True, slots=True)
class Member:
    """``base.name``: an output of a block that has several; ``base.T``: the transpose."""

    base: Expression
    name: str
    position: Position
    """Of the member's name."""


@dataclass(frozen=True, slots=True)
class Slice:
    """``start:stop`` inside brackets; either end may be left out."""

    start: Expression | None
    stop: Expression | None
    position: Position


@dataclass(frozen=True, slots=True)
class Index:
    """``base[i]``, ``base[i, j]``, ``base[:-1]``: indices from 0, negative from the end."""

    base: Expression
    indices: tuple[Expression | Slice, ...]
    position: Position


@dataclass(frozen=True, slots=True)
class Call:
    """``function(arguments)``."""

    function: Name
    arguments: tuple[Expression, ...]
    position: Position


@dataclass(frozen=True, slots=True)
class Unary:
    """``-operand`` or ``+operand``."""

    operator: str
    operand: Expression
    position: Position


@dataclass(frozen=True, slots=True)
class Binary:
    """``left operator right`` with operator one of ``+ - * / ^`` (``**`` reads as ``^``)."""

    operator: str
    left: Expression
    right: Expression
    position: Position


@dataclass(frozen=True, slots=True)
class Array:
    """``[a, b, c]``: a vector, or a matrix row by row. YAML sequences become this too."""

    items: tuple[Expression, ...]
    position: Position


@dataclass(frozen=True, slots=True)
class Text:
    """A word that is an option, not an expression (``product: matrix``, ``relation: "<"``)."""

    text: str
    position: Position


Expression = Number | Name | Member | Index | Call | Unary | Binary | Array | Text
