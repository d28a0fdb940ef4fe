"""Units as FMI defines them: exponents of the SI base units and rad, and the factor to them.

Units of saoflow are products of powers of names; a plain number and a radian are the same there. FMI tells them apart,
so a unit is shown as the sheet writes it (``rad/s``) where it writes it, and an angle counts as ``rad``.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from functools import lru_cache

from saoflow.diagnosis import DiagnosisError
from saoflow.units import Unit, pint_unit

_ANGLES = re.compile(r"\b(rad|radian|radians)\b")
_SI = {
    "kilogram": "kg",
    "meter": "m",
    "second": "s",
    "ampere": "A",
    "kelvin": "K",
    "mole": "mol",
    "candela": "cd",
    "radian": "rad",
}
"""Base units: pint's name and FMI's."""
BASE = ("kg", "m", "s", "A", "K", "mol", "cd", "rad")
"""The base units of FMI, in the order of its schema."""


@dataclass(frozen=True, slots=True)
class UnitDefinition:
    """A unit by the name under which variables use it."""

    name: str
    unit: Unit


@dataclass(frozen=True, slots=True)
class BaseUnit:
    """``1 unit = factor * kg^a m^b s^c ...``; only exponents that are not zero are listed."""

    factor: float
    exponents: tuple[tuple[str, int], ...]


@lru_cache(maxsize=1024)
def shown_unit(unit: Unit, written: str | None) -> UnitDefinition:
    """The definition of a unit, named as the sheet writes it, if what it writes is this unit."""
    text = " ".join((written or "").split())
    try:
        named = text if text and Unit.parse(text) is unit else str(unit)
    except DiagnosisError:
        named = str(unit)
    return UnitDefinition(named, unit)


def base_unit(definition: UnitDefinition) -> BaseUnit | None:
    """The SI form of a unit; None where FMI has none (fractional exponents, or a unit that pint does not convert)."""
    try:
        quantity = (1.0 * pint_unit(definition.unit)).to_base_units()
    except Exception:  # pint raises many kinds for what it cannot convert; to us they mean the same
        return None
    exponents = {_SI.get(name, name): float(power) for name, power in quantity.unit_items()}
    exponents["rad"] = _angle(definition)
    if any(power != int(power) or name not in BASE for name, power in exponents.items()):
        return None
    return BaseUnit(
        float(quantity.magnitude), tuple((name, int(exponents[name])) for name in BASE if exponents.get(name))
    )


def _angle(definition: UnitDefinition) -> float:
    """The exponent of an angle: radians are dimensionless in saoflow, degrees are not."""
    try:
        degrees = Unit.parse(_ANGLES.sub("deg", definition.name))
    except DiagnosisError:
        degrees = definition.unit
    return float(dict(degrees.powers).get("deg", 0))
