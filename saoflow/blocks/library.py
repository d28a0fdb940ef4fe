"""The symbols by name: what a sheet may use, and which profile allows what."""

from __future__ import annotations

from typing import Any

from saoflow.blocks.add import Add
from saoflow.blocks.compare import Compare
from saoflow.blocks.concatenate import Concatenate
from saoflow.blocks.constant import Constant
from saoflow.blocks.delay import Delay
from saoflow.blocks.diagonal import Diagonal
from saoflow.blocks.inv2 import Inv2
from saoflow.blocks.logical_and import LogicalAnd
from saoflow.blocks.logical_not import LogicalNot
from saoflow.blocks.logical_or import LogicalOr
from saoflow.blocks.lookup import Lookup
from saoflow.blocks.mul import Mul
from saoflow.blocks.saturation import Saturation
from saoflow.blocks.select import Select
from saoflow.blocks.switch import Switch
from saoflow.blocks.symbol import Symbol
from saoflow.blocks.transpose import Transpose

AnySymbol = Symbol[Any]

SYMBOLS: dict[str, AnySymbol] = {
    symbol.name: symbol
    for symbol in (
        Add(), Mul(), Lookup(), Inv2(), Delay(), Saturation(), Constant(),
        Select(), Concatenate(), Transpose(), Diagonal(),
        Compare(), LogicalAnd(), LogicalOr(), LogicalNot(), Switch(),
    )
}  # fmt: skip
"""Every symbol, in the order of the documentation."""

PROFILES: dict[str, frozenset[str]] = {
    "six": frozenset(name for name, symbol in SYMBOLS.items() if symbol.profile == "six"),
    "sao": frozenset(SYMBOLS),
}
"""The symbols that each profile allows."""
