"""Units: what is one unit, what is another, and that the arithmetic agrees with pint's."""

from __future__ import annotations

import copy
import pickle
import re
import subprocess
import sys
from fractions import Fraction

import pint
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from saoflow.diagnosis import DiagnosisError, Position
from saoflow.units import (
    DIMENSIONLESS,
    Unit,
    collapse,
    conversion_hint,
    first_mismatch,
    map_units,
    per_element,
    units_text,
)

NAMES = {"m": "meter", "s": "second", "kt": "knot", "ft": "foot", "kg": "kilogram", "deg": "degree", "Pa": "pascal"}


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        ("kt", "kt"),
        ("knots", "kt"),
        ("kt/s", "kt/s"),
        ("kt/s^2", "kt/s^2"),
        ("kt/s**2", "kt/s^2"),
        ("m/(s*kt)", "m/kt/s"),
        ("m/s/kt", "m/kt/s"),
        ("1/s", "1/s"),
        ("s^-1", "1/s"),
        ("Pa^(1/2)", "Pa^(1/2)"),
        ("Pa^0.5", "Pa^(1/2)"),
        ("kg*m^2/s^2", "kg*m^2/s^2"),
        ("m²/s³", "m^2/s^3"),
        ("rad", "1"),
        ("1", "1"),
        ("rad/s", "1/s"),
        ("m/m", "1"),
        ("(m)", "m"),
        ("%", "%"),
        ("°", "deg"),
        (" kt / s ", "kt/s"),
        ("lbs", "lb"),
        ("furlong", "fur"),
        ("m^0", "1"),
    ],
)
def test_reading_and_showing(text: str, shown: str) -> None:
    assert str(Unit.parse(text)) == shown
    assert Unit.parse(shown) is Unit.parse(text)


@pytest.mark.parametrize("pair", [("kt", "m/s"), ("deg", "rad"), ("ms", "s"), ("ft", "m"), ("%", "1"), ("h", "min")])
def test_units_of_one_dimension_stay_different(pair: tuple[str, str]) -> None:
    assert Unit.parse(pair[0]) is not Unit.parse(pair[1])


@pytest.mark.parametrize(
    ("text", "column", "words"),
    [
        ("", 1, "the end was found"),
        ("m/", 3, "the end was found"),
        ("2*m", 1, "`2` was found"),
        ("m s", 3, "`*` or `/` was expected"),
        ("m^x", 3, "an exponent was expected"),
        ("m^(1/0)", 6, "divides by zero"),
        ("m^100", 3, "too large"),
        ("kt)", 3, "`)` was found"),
        ("((((", 5, "the end was found"),
        ("m/wibble", 3, "unknown unit `wibble`"),
        ("knotz", 1, "did you mean `knot`?"),
        ("m" * 300, 1, "at most 200"),
    ],
)
def test_no_unit(text: str, column: int, words: str) -> None:
    with pytest.raises(DiagnosisError) as caught:
        Unit.parse(text, Position("f.yaml", 7, 1))
    (diagnosis,) = caught.value.diagnoses
    assert diagnosis.code == "E113"
    assert words in diagnosis.render()
    assert diagnosis.position is not None
    assert (diagnosis.position.line, diagnosis.position.column) == (7, column)


units = st.dictionaries(
    st.sampled_from(sorted(NAMES)),
    st.fractions(min_value=-3, max_value=3, max_denominator=2).filter(bool),
    max_size=4,
).map(lambda powers: Unit(tuple(sorted(powers.items()))))


def in_pint(unit: Unit) -> dict[str, float]:
    return {NAMES[name]: float(power) for name, power in unit.powers}


@given(units, units, st.fractions(min_value=-2, max_value=2, max_denominator=3))
@settings(max_examples=100, deadline=None)
def test_arithmetic_agrees_with_pint(a: Unit, b: Unit, power: Fraction) -> None:
    def pints(unit: Unit) -> pint.util.UnitsContainer:
        return pint.util.UnitsContainer(in_pint(unit))

    def same(mine: Unit, other: pint.util.UnitsContainer) -> bool:
        keys = {*in_pint(mine), *other}
        return all(in_pint(mine).get(k, 0) == pytest.approx(other.get(k, 0)) for k in keys)

    assert same(a * b, pints(a) * pints(b))
    assert same(a / b, pints(a) / pints(b))
    assert same(a.power(power), pints(a) ** float(power))
    assert a * b is b * a
    assert (a / b) * b is a
    assert Unit.parse(str(a)) is a


def test_units_are_interned_and_do_not_change() -> None:
    unit = Unit.parse("kt/s")
    assert pickle.loads(pickle.dumps(unit)) is unit
    assert copy.deepcopy(unit) is unit
    assert len({unit, Unit.parse("knot/second")}) == 1
    with pytest.raises(AttributeError):
        unit.powers = ()


@pytest.mark.parametrize(
    ("a", "b", "factor", "right"),
    [
        ("kt", "m/s", 1852 / 3600, "m/s"),
        ("m/s", "kt", 3600 / 1852, "kt"),
        ("deg", "rad", 0.0174533, "rad"),
        ("kt/s", "m/s^2", 1852 / 3600, "m/s^2"),
        ("ms", "s", 0.001, "s"),
        ("lb", "kg", 0.45359237, "kg"),
        ("g0", "m/s^2", 9.80665, "m/s^2"),
        ("hPa", "Pa", 100, "Pa"),
        ("%", "1", 0.01, "(a plain number)"),
    ],
)
def test_conversion_hint(a: str, b: str, factor: float, right: str) -> None:
    hint = conversion_hint(Unit.parse(a), Unit.parse(b))
    found = re.fullmatch(r"1 (.*) = ([\d.e+-]+) (.*)", hint)
    assert found is not None, hint
    assert (found[1], found[3]) == (a, right)
    assert float(found[2]) == pytest.approx(factor, rel=1e-5)


def test_no_conversion_between_different_things() -> None:
    assert conversion_hint(Unit.parse("kt"), Unit.parse("deg")) == "kt and deg measure different things"


def test_units_per_element() -> None:
    kt, deg = Unit.parse("kt"), Unit.parse("deg")
    assert per_element(kt, 3) == (kt, kt, kt)
    assert per_element((kt, None), 2) == (kt, None)
    assert collapse([kt, kt]) is kt
    assert collapse([kt, None]) == (kt, None)
    assert collapse([None, None]) is None
    assert map_units(lambda u: u * u, (kt, None)) == (kt * kt, None)
    assert units_text((kt, None, deg)) == "[kt, ?, deg]"
    assert units_text((kt, deg) * 10, limit=3) == "[kt, deg, kt, ...]"
    assert units_text(None) == "not stated"
    assert first_mismatch((kt, None, deg), kt) == (2, deg, kt)
    assert first_mismatch((kt, None), (None, deg)) is None
    assert first_mismatch(None, deg) is None
    assert first_mismatch(DIMENSIONLESS, deg) == (0, DIMENSIONLESS, deg)


def test_pint_is_imported_only_for_unusual_names() -> None:
    code = (
        "import sys; from saoflow.units import Unit\n"
        "for t in ('kt/s^2', 'rad', 'degrees', 'Pa*m^2', '%', 'g0', 'km/h'): Unit.parse(t)\n"
        "assert 'pint' not in sys.modules\n"
        "Unit.parse('furlong')\n"
        "assert 'pint' in sys.modules\n"
    )
    subprocess.run([sys.executable, "-c", code], check=True)
