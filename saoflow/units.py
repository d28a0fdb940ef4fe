"""Units of wires and parameters: products of powers of unit names, kept as they are written.

``kt`` and ``m/s`` measure the same thing but are different units here: adding them is an error, and converting is an
explicit multiplication by a constant whose unit is ``m/s/kt``. ``rad`` and ``1`` are the same: no unit at all.
Spellings of one unit (``knot``, ``kt``) are one unit. Names outside the small set below are looked up in pint, which
is imported only then.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Sequence
from fractions import Fraction
from functools import lru_cache
from typing import Any

from saoflow.diagnosis import Diagnosis, DiagnosisError, Position, did_you_mean
from saoflow.unit_names import DIMENSIONLESS_NAMES, KNOWN, SYNONYMS, pint_name, registry

Powers = tuple[tuple[str, Fraction], ...]

class Unit:
    """A product of powers of unit names. Interned: equal units are one object, so that comparing is ``is``.

    ``powers`` holds (name, exponent) sorted by name; empty for a dimensionless quantity.
    """

    __slots__ = ("_text", "powers")
    powers: Powers
    _text: str

    _interned: dict[Powers, Unit] = {}  # noqa: RUF012 -- the table of all units, one for the class

    def __new__(cls, powers: Powers = ()) -> Unit:
        found = cls._interned.get(powers)
        if found is None:
            found = object.__new__(cls)
            object.__setattr__(found, "powers", powers)
            object.__setattr__(found, "_text", _text_of(powers))
            cls._interned[powers] = found
        return found

    def __setattr__(self, name: str, value: object) -> None:
        raise AttributeError("a unit does not change")

    def __reduce__(self) -> tuple[type[Unit], tuple[Powers]]:
        return (Unit, (self.powers,))

    @staticmethod
    def parse(text: str, position: Position | None = None, source_line: str | None = None) -> Unit:
        """Read ``kt/s^2``, ``m/(s*kt)``, ``1/s``, ``Pa^(1/2)``.

        ``position`` is that of the text's first character. Raises DiagnosisError (E113) for what is no unit.
        """
        result = _parse(text)
        if isinstance(result, Unit):
            return result
        raise DiagnosisError([result.diagnosis(text, position, source_line)])

    @property
    def dimensionless(self) -> bool:
        """Whether it is no unit at all (``1``, ``rad``)."""
        return not self.powers

    def __mul__(self, other: Unit) -> Unit:
        return _product(self, other, 1)

    def __truediv__(self, other: Unit) -> Unit:
        return _product(self, other, -1)

    def power(self, exponent: Fraction | int) -> Unit:
        """The unit to a rational power."""
        exponent = Fraction(exponent)
        return Unit(tuple((name, p * exponent) for name, p in self.powers) if exponent else ())

    def __str__(self) -> str:
        return self._text

    def __repr__(self) -> str:
        return f"Unit({self._text!r})"


@lru_cache(maxsize=65536)
def _product(a: Unit, b: Unit, sign: int) -> Unit:
    powers = dict(a.powers)
    for name, power in b.powers:
        powers[name] = powers.get(name, Fraction(0)) + sign * power
    return Unit(tuple(sorted((n, p) for n, p in powers.items() if p)))


def _text_of(powers: Powers) -> str:
    def factor(name: str, power: Fraction) -> str:
        if power == 1:
            return name
        return f"{name}^{power}" if power.denominator == 1 else f"{name}^({power})"

    above = [factor(name, power) for name, power in powers if power > 0]
    below = [factor(name, -power) for name, power in powers if power < 0]
    return "/".join(["*".join(above) or "1", *below])


DIMENSIONLESS = Unit()

Units = Unit | tuple[Unit | None, ...] | None
"""What a wire carries: None (not stated), one unit for all elements, or one per element in row-major order."""


# ---------------------------------------------------------------- per-element units


def per_element(units: Units, size: int) -> tuple[Unit | None, ...]:
    """One unit per element; ``size`` is the number of elements."""
    return units if isinstance(units, tuple) else (units,) * size


def collapse(units: Iterable[Unit | None]) -> Units:
    """The short form: one unit if all elements have the same."""
    items = tuple(units)
    if not items:
        return None
    first = items[0]
    return first if all(unit is first for unit in items) else items


def map_units(function: Callable[[Unit], Unit], units: Units) -> Units:
    """Apply ``function`` to every unit that is stated."""
    if isinstance(units, tuple):
        return collapse(None if unit is None else function(unit) for unit in units)
    return None if units is None else function(units)


def units_text(units: Units, limit: int = 8) -> str:
    """For messages: ``kt``, ``[rad, kt]``, or ``not stated``; at most ``limit`` elements are listed."""
    if isinstance(units, tuple):
        shown = [str(unit) if unit else "?" for unit in units[:limit]]
        return f"[{', '.join(shown)}{', ...' if len(units) > limit else ''}]"
    return "not stated" if units is None else str(units)


def first_mismatch(a: Units, b: Units) -> tuple[int, Unit, Unit] | None:
    """The first element (flat index) where both state a unit and they differ; None if nothing contradicts."""
    if isinstance(a, tuple) or isinstance(b, tuple):
        size = len(a) if isinstance(a, tuple) else len(b) if isinstance(b, tuple) else 1
        pairs: Sequence[tuple[Unit | None, Unit | None]] = list(
            zip(per_element(a, size), per_element(b, size), strict=False)
        )
    else:
        pairs = [(a, b)]
    for index, (x, y) in enumerate(pairs):
        if x is not None and y is not None and x is not y:
            return index, x, y
    return None


# ---------------------------------------------------------------- reading

_TOKEN = re.compile(
    r"\s*(?:(?P<name>[^\W\d²³][^\W²³]*|%|°)|(?P<number>\d+(?:\.\d+)?)|(?P<op>\*\*|[*/^()+\-·])|(?P<other>\S))"
)
_LONGEST = 200
_SUPERSCRIPTS = {"²": "^2", "³": "^3"}


class _Failure(Exception):
    """Why a text is no unit, and where in it (offset, length)."""

    def __init__(self, message: str, offset: int, length: int, cause: str, remedy: str) -> None:
        super().__init__(message)
        self.message, self.offset, self.length, self.cause, self.remedy = (
            message,
            offset,
            length,
            cause,
            remedy,
        )

    def diagnosis(self, text: str, position: Position | None, source_line: str | None) -> Diagnosis:
        if position is not None:
            inside = Position(position.file, position.line, position.column + self.offset, max(1, self.length))
            position = inside if "\n" not in text else position
        return Diagnosis("E113", self.message, position, cause=self.cause, remedy=self.remedy, source_line=source_line)


@lru_cache(maxsize=4096)
def _parse(text: str) -> Unit | _Failure:
    try:
        return _UnitParser(text).read()
    except _Failure as failure:
        return failure.with_traceback(None)


class _UnitParser:
    """``unit = factor {(* | /) factor}``; ``factor = (name | 1 | "(" unit ")") [^ exponent]``."""

    def __init__(self, text: str) -> None:
        if len(text) > _LONGEST:
            self.fail(f"a unit of {len(text)} characters", 0, 1, f"at most {_LONGEST} are read", "shorten it")
        self.tokens: list[tuple[str, str, int]] = []
        for match in _TOKEN.finditer(text):
            kind = match.lastgroup or "other"
            word, offset = match.group(kind), match.start(kind)
            if kind == "other" and word in _SUPERSCRIPTS:
                self.tokens += [("op", "^", offset), ("number", _SUPERSCRIPTS[word][1], offset)]
            else:
                self.tokens.append((kind, {"**": "^", "·": "*"}.get(word, word), offset))
        self.tokens.append(("end", "", len(text)))
        self.next = 0

    def fail(self, message: str, offset: int, length: int, cause: str, remedy: str) -> None:
        raise _Failure(message, offset, length, cause, remedy)

    def unexpected(self, wanted: str) -> _Failure:
        _, word, offset = self.tokens[self.next]
        found = f"`{word}`" if word else "the end"
        return _Failure(
            "a unit cannot be read",
            offset,
            len(word),
            f"{wanted} was expected, {found} was found",
            "write names with `*`, `/`, `^` and parentheses, such as kt/s or m/s^2; a plain number has the unit 1",
        )

    def take(self, word: str) -> bool:
        if self.tokens[self.next][1] == word and self.tokens[self.next][0] != "end":
            self.next += 1
            return True
        return False

    def read(self) -> Unit:
        unit = self.product()
        if self.tokens[self.next][0] != "end":
            raise self.unexpected("`*` or `/`")
        return unit

    def product(self) -> Unit:
        unit = self.factor()
        while True:
            if self.take("*"):
                unit = unit * self.factor()
            elif self.take("/"):
                unit = unit / self.factor()
            else:
                return unit

    def factor(self) -> Unit:
        kind, word, offset = self.tokens[self.next]
        if kind == "name":
            self.next += 1
            unit = _named(word, offset)
        elif kind == "number" and word == "1":
            self.next += 1
            unit = DIMENSIONLESS
        elif word == "(":
            self.next += 1  # the text's length bounds the nesting
            unit = self.product()
            if not self.take(")"):
                raise self.unexpected("`)`")
        else:
            raise self.unexpected("the name of a unit")
        return unit.power(self.exponent()) if self.take("^") else unit

    def exponent(self) -> Fraction:
        if self.take("("):
            value = self.signed()
            if self.take("/"):
                offset = self.tokens[self.next][2]
                divisor = self.signed()
                if not divisor:
                    self.fail("an exponent divides by zero", offset, 1, "the exponent has no value", "correct it")
                value /= divisor
            if not self.take(")"):
                raise self.unexpected("`)`")
            return value
        return self.signed()

    def signed(self) -> Fraction:
        sign = -1 if self.take("-") else 1
        if sign > 0:
            self.take("+")
        kind, word, offset = self.tokens[self.next]
        if kind != "number":
            raise self.unexpected("an exponent")
        self.next += 1
        value = Fraction(word)
        if value > 99:
            self.fail("an exponent is too large", offset, len(word), "exponents go up to 99", "correct it")
        return sign * value


def _named(word: str, offset: int) -> Unit:
    """The unit of one name; asks pint for what is not in the small set. Raises _Failure."""
    if word in DIMENSIONLESS_NAMES:
        return DIMENSIONLESS
    name = SYNONYMS.get(word) or pint_name(word)
    if name is None:
        near = did_you_mean(word, [*SYNONYMS, "rad"])
        raise _Failure(
            f"unknown unit `{word}`",
            offset,
            len(word),
            "neither saoflow nor pint knows a unit of this name",
            near or "correct the name; a plain number has the unit 1",
        )
    return DIMENSIONLESS if name in DIMENSIONLESS_NAMES else Unit(((name, Fraction(1)),))


# ---------------------------------------------------------------- hints for messages


def conversion_hint(a: Unit, b: Unit) -> str:
    """What to tell about two units that do not fit: ``1 kt = 0.514444 m/s``, or that they measure different things."""
    if a is b:
        return f"both are {a}"
    try:
        one = registry().Quantity(1.0, pint_unit(a))
        other = pint_unit(b)
        if one.dimensionality != other.dimensionality:
            return f"{_spoken(a)} and {_spoken(b)} measure different things"
        factor = one.to(other).magnitude
    except Exception:  # the hint is an extra: a unit that pint cannot convert gets the plain sentence
        return f"{a} and {b} are different units"
    plain = "rad" if "deg" in (str(a), str(b)) else "(a plain number)"
    return f"1 {a if a.powers else plain} = {factor:.6g} {b if b.powers else plain}"


def conversion_remedy(found: Unit, wanted: Unit) -> str:
    """What to do about a wire in ``found`` where ``wanted`` is needed."""
    if "different" in conversion_hint(found, wanted):
        return "correct the unit or the wire that is wrong"
    return f"convert it with a product by a constant of unit {wanted / found}, or correct the unit that is wrong"


def _spoken(unit: Unit) -> str:
    return str(unit) if unit.powers else "a plain number (1, rad)"


def pint_unit(unit: Unit) -> Any:
    """The unit in pint, which is imported only now."""
    known = registry()
    result = known.Unit("")
    for name, power in unit.powers:
        exponent = power.numerator if power.denominator == 1 else float(power)
        result = result * known.Unit(KNOWN.get(name, name)) ** exponent
    return result
