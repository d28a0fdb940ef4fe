"""The equations on the flagship's page: for every sheet that is one of the paper's, those that the sheet itself names."""

from __future__ import annotations

import re

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
        assert f"({number}" in text if number else other in text or "line" in text or other in ("Table I", "Algorithm 1"), f"{number}{other}"


def test_numbers_stand_before_and_long_lines_go_on_below() -> None:
    """Bars and hats are letters of no width."""
    long = "x̂_i = " + "p̄" * 50
    text = aligned(((f"{long},  {long}", "(1)"), ("short,  shorter", "(20)")))
    assert text.split("\n") == [f"(1)    {long},", f"       {long}", "(20)   short,  shorter"]
