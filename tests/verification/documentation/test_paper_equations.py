"""The equations on the flagship's page: for every sheet that is one of the paper's, those that the sheet itself names."""

from __future__ import annotations

import re
import unicodedata

import pytest

from saoflow.diagrams.reader import read_sheet
from saoflow.diagrams.store import SHIPPED
from verification.documentation.paper_equations import EQUATIONS, aligned
from verification.documentation.reference import FLAGSHIP

FOLDER = SHIPPED / "cmhe_fte"


@pytest.mark.parametrize("name", sorted({*FLAGSHIP, *EQUATIONS}))
def test_a_sheet_has_the_equations_that_it_names(name: str) -> None:
    named = " ".join(read_sheet(FOLDER / f"{name}.yaml").equations.split())
    if named.startswith("none"):
        assert name not in EQUATIONS
        return
    text = aligned(EQUATIONS[name])
    wanted = re.findall(r"\((\d+[a-f]?)\)|(Algorithm \d|Table I\b|V-[A-C])", named)
    for number, other in wanted:
        assert f"({number}" in text if number else other in text or "line" in text or other == "Table I", f"{number}{other}"


def test_numbers_stand_in_one_column() -> None:
    """Bars and hats are letters of no width."""
    text = aligned((("x̂_i = p̄", "(1)"), ("a longer line", "(2)"), ("without", "")))
    columns = [len("".join(c for c in line[: line.index("(")] if not unicodedata.combining(c))) for line in text.split("\n")[:2]]
    assert columns == [16, 16]
    assert text.endswith("without")
