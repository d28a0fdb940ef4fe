"""Names of units: the small set that sheets use, their spellings, and what pint knows beyond them.

pint is imported when it is first asked.
"""

from __future__ import annotations

from functools import lru_cache
from typing import Any

KNOWN = {
    "m": "meter",
    "km": "kilometer",
    "cm": "centimeter",
    "mm": "millimeter",
    "ft": "foot",
    "inch": "inch",
    "NM": "nautical_mile",
    "s": "second",
    "ms": "millisecond",
    "us": "microsecond",
    "min": "minute",
    "h": "hour",
    "kg": "kilogram",
    "lb": "pound",
    "slug": "slug",
    "K": "kelvin",
    "degC": "delta_degree_Celsius",
    "degF": "delta_degree_Fahrenheit",
    "Pa": "pascal",
    "hPa": "hectopascal",
    "kPa": "kilopascal",
    "mbar": "millibar",
    "bar": "bar",
    "psi": "pound_force_per_square_inch",
    "N": "newton",
    "kN": "kilonewton",
    "lbf": "pound_force",
    "J": "joule",
    "W": "watt",
    "A": "ampere",
    "V": "volt",
    "Hz": "hertz",
    "kt": "knot",
    "deg": "degree",
    "%": "percent",
    "g0": "standard_gravity",
}
"""Name here: name in pint."""
DIMENSIONLESS_NAMES = frozenset({"rad", "radian", "radians"})
"""What measures nothing."""
SYNONYMS = {
    **{name: name for name in KNOWN},
    "meter": "m", "meters": "m", "metre": "m", "metres": "m", "kilometer": "km", "kilometre": "km",
    "foot": "ft", "feet": "ft", "inches": "inch", "nmi": "NM", "nautical_mile": "NM",
    "second": "s", "seconds": "s", "sec": "s", "millisecond": "ms", "milliseconds": "ms", "microsecond": "us",
    "minute": "min", "minutes": "min", "hour": "h", "hours": "h",
    "kilogram": "kg", "kilograms": "kg", "pound": "lb", "kelvin": "K",
    "celsius": "degC", "degree_Celsius": "degC", "degree_Fahrenheit": "degF",
    "pascal": "Pa", "pascals": "Pa", "millibar": "mbar", "newton": "N", "newtons": "N", "pound_force": "lbf",
    "joule": "J", "watt": "W", "ampere": "A", "volt": "V", "hertz": "Hz",
    "knot": "kt", "knots": "kt", "kts": "kt", "kn": "kt", "degree": "deg", "degrees": "deg", "°": "deg",
    "percent": "%", "standard_gravity": "g0", "g_0": "g0",
}  # fmt: skip
"""Spelling: name here."""


@lru_cache(maxsize=1)
def registry() -> Any:
    """pint's units, read once."""
    import pint

    return pint.UnitRegistry()


def pint_name(word: str) -> str | None:
    """The canonical name of a unit that pint knows (``lbs`` is ``lb``), or None."""
    known = registry()
    try:
        if word not in known:
            return None
        unit = known.Unit(word)
        long = str(unit)
        short = f"{unit:~}"
    except Exception:  # pint raises many kinds for words that are no units; to us they mean the same
        return None
    for name in (long, short):
        if name in DIMENSIONLESS_NAMES:
            return name
        if name in SYNONYMS and known.Unit(KNOWN[SYNONYMS[name]]) == unit:
            return SYNONYMS[name]
    if short.isidentifier() and short not in SYNONYMS and known.Unit(short) == unit:
        return short
    return long if long.isidentifier() else None
