"""Variants of a sheet as text, for the command line.

cmhe_fte                        the sheet as it is
cmhe_fte[n_QP=1..4]             four of them
cmhe_fte[n_QP=1..3, N=2|4]      six: every one of the first with every one of the second
mine/lag.yaml[k=0.1|pi/8]       values are numbers or expressions
"""

from __future__ import annotations

import itertools
import re
from collections.abc import Sequence

from saoflow.diagnosis import Diagnosis, DiagnosisError
from verification.campaigns.plan import Variant

SYNTAX = "SHEET[NAME=VALUE, NAME=FROM..TO, NAME=VALUE|VALUE]"
MOST_VARIANTS = 64
_RANGE = re.compile(r"\s*([+-]?\d+)\s*\.\.\s*([+-]?\d+)\s*")


def parse_variants(texts: Sequence[str]) -> tuple[Variant, ...]:
    """All variants, each once, in the order of the text. Raises DiagnosisError E807 with all that is wrong."""
    found: dict[Variant, None] = {}
    wrong: list[Diagnosis] = []
    for text in texts:
        try:
            found.update(dict.fromkeys(_variants_of(text)))
        except DiagnosisError as error:
            wrong += error.diagnoses
    if not wrong and len(found) > MOST_VARIANTS:
        wrong.append(
            Diagnosis(
                "E807",
                f"{len(found)} variants are too many",
                cause=f"at most {MOST_VARIANTS} are compared at a time",
                remedy="take fewer values",
            )
        )
    if wrong:
        raise DiagnosisError(wrong)
    return tuple(found)


def _variants_of(text: str) -> list[Variant]:
    sheet, bracket, rest = text.strip().partition("[")
    if not sheet.strip():
        raise _wrong(text, "it names no sheet")
    if not bracket:
        return [Variant(sheet.strip(), (), unlimited=True)]
    if not rest.endswith("]"):
        raise _wrong(text, "the bracket is not closed" if "]" not in rest else "something follows the bracket")
    axes: dict[str, list[str]] = {}
    for part in _parts(rest[:-1]):
        name, equals, values = (piece.strip() for piece in part.partition("="))
        if not equals or not name.isidentifier() or not values:
            raise _wrong(text, f"`{part.strip()}` is no NAME=VALUE")
        if name in axes:
            raise _wrong(text, f"`{name}` is given twice")
        axes[name] = _values(text, values)
    if not axes:
        raise _wrong(text, "there is nothing in the brackets")
    return [
        Variant(sheet.strip(), tuple(zip(axes, chosen, strict=True)), unlimited=True)
        for chosen in itertools.product(*axes.values())
    ]


def _parts(text: str) -> list[str]:
    """Cut at the commas that are in no bracket of their own."""
    parts, depth = [""], 0
    for character in text:
        depth += {"(": 1, "[": 1, ")": -1, "]": -1}.get(character, 0)
        if character == "," and depth == 0:
            parts.append("")
        else:
            parts[-1] += character
    return [part for part in parts if part.strip()] if len(parts) == 1 else parts


def _values(text: str, values: str) -> list[str]:
    found: list[str] = []
    for value in values.split("|"):
        if not value.strip():
            raise _wrong(text, f"`{values}` has an empty value")
        if ".." not in value:
            found.append(value.strip())
            continue
        ends = _RANGE.fullmatch(value)
        if ends is None:
            raise _wrong(text, f"`{value.strip()}` is no range of whole numbers")
        low, high = int(ends[1]), int(ends[2])
        if high < low:
            raise _wrong(text, f"`{value.strip()}` goes down")
        if high - low >= MOST_VARIANTS:
            raise _wrong(text, f"`{value.strip()}` has {high - low + 1} values, at most {MOST_VARIANTS} are compared")
        found += [str(number) for number in range(low, high + 1)]
    return list(dict.fromkeys(found))


def _wrong(text: str, cause: str) -> DiagnosisError:
    message = f"`{text}` is not understood"
    return DiagnosisError([Diagnosis("E807", message, cause=cause, remedy=f"write {SYNTAX}, as cmhe_fte[n_QP=1..4]")])
