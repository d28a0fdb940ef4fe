"""Operations against the horizon: counted, against hand formulas, and fitted."""

from __future__ import annotations

import pytest

from verification.results.horizon_operations import cost, costs, exponent, growth, table


def eliminations(n: int) -> int:
    """L D L' by hand: of m equations left, 1 reciprocal, m-1 factors, m(m-1)/2 products and differences of the symmetric
    rest, twice m-1 on the right side, 1 for the first, 2 (m-1) back; and one quotient at the end."""
    return sum(1 + (m - 1) + m * (m - 1) + 2 * (m - 1) + 1 + 2 * (m - 1) for m in range(2, n + 1)) + 2


@pytest.mark.parametrize("N", [2, 4])
def test_the_equations_cost_what_elimination_by_hand_does(N: int) -> None:
    assert cost("mho_wd_condensed", N).solve == eliminations(3 + 3 * N)
    assert cost("mho_pe", N).solve == cost("mho_wod", N).solve == eliminations(3)


def test_exponents_of_known_powers() -> None:
    horizons = range(5, 12)
    assert exponent(horizons, [7 * N**3 for N in horizons]) == pytest.approx(3.0)
    assert exponent(horizons, [100 for _ in horizons]) == pytest.approx(0.0, abs=1e-12)


def test_the_shortened_table() -> None:
    found = costs((2, 3, 4), ("mho_pe", "mho_wd_condensed"))
    assert growth(found, "mho_pe").per_transition == 265
    assert growth(found, "mho_pe").solve_exponent == pytest.approx(0.0, abs=1e-9)
    assert growth(found, "mho_wd_condensed").exponent > 1.6
    lines = table(found).splitlines()
    assert len(lines) == 2 + 3 + 2
    assert len({line.count("|") for line in lines}) == 1
