"""Operations a frame of paper 003's estimators against the horizon N, counted on the sheets.

    python -m verification.results.horizon_operations [--longest 20]

The paper: the normal equations of MHO-wD cost O(N^3 (n_x + n_w)^3) when condensed, those of MHO-woD and MHO-PE O(n_x^3),
whatever N. Besides them every horizon has to be predicted and linearised, which is in proportion to N.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

import saoflow

OBSERVERS = ("mho_pe", "mho_wod", "mho_wd", "mho_wd_condensed")
SOLVES = {"mho_pe": "p", "mho_wod": "p", "mho_wd_condensed": "z"}
"""The block of the sheet `step` that solves the normal equations; mho_wd has none, it eliminates as it goes."""

HORIZONS = tuple(range(2, 21))
FITTED = range(10, 21)
"""The horizons that the exponents are fitted to."""


@dataclass(frozen=True)
class Cost:
    """One sheet at one horizon."""

    sheet: str
    N: int
    operations: int
    """A frame."""
    solve: int | None
    """Of them, the solution of the normal equations."""


def cost(sheet: str, N: int) -> Cost:
    """Count one sheet."""
    tree = saoflow.load(sheet, parameters={"N": N}).budget().tree
    block = SOLVES.get(sheet)
    return Cost(sheet, N, tree.total, tree.parts["step"].parts[block].total if block else None)


def filter_operations() -> int:
    """Operations a frame of the EKF, which has no horizon."""
    return saoflow.load("ekf").budget().tree.total


def costs(horizons: Sequence[int] = HORIZONS, sheets: Sequence[str] = OBSERVERS) -> tuple[Cost, ...]:
    """Count every sheet at every horizon."""
    return tuple(cost(sheet, N) for sheet in sheets for N in horizons)


def exponent(horizons: Sequence[int], operations: Sequence[int]) -> float:
    """The power of N that fits best: the slope of the logarithms."""
    return float(np.polyfit(np.log(horizons), np.log(operations), 1)[0])


@dataclass(frozen=True)
class Growth:
    """How one sheet grows with N."""

    sheet: str
    exponent: float
    """Of all operations of a frame, fitted over :data:`FITTED`."""
    solve_exponent: float | None
    """Of the solution of the normal equations."""
    per_transition: float
    """Operations that one transition more costs at the longest horizon."""


def growth(found: Sequence[Cost], sheet: str) -> Growth:
    """Fit one sheet."""
    rows = [one for one in found if one.sheet == sheet]
    fitted = [one for one in rows if one.N in FITTED] or rows
    horizons = [one.N for one in fitted]
    solves = [one.solve for one in fitted if one.solve is not None]
    last, before = rows[-1], rows[-2]
    return Growth(
        sheet,
        exponent(horizons, [one.operations for one in fitted]),
        exponent(horizons, solves) if solves else None,
        (last.operations - before.operations) / (last.N - before.N),
    )


def table(found: Sequence[Cost]) -> str:
    """Markdown: a row for each horizon, then the fitted exponents."""
    sheets = list(dict.fromkeys(one.sheet for one in found))
    horizons = sorted({one.N for one in found})
    by_key = {(one.sheet, one.N): one for one in found}
    head = ["N", *(f"`{sheet}`" for sheet in sheets), "`mho_wd_condensed`: its equations alone"]
    lines = ["| " + " | ".join(head) + " |", "|" + "---:|" * len(head)]
    for N in horizons:
        solve = by_key["mho_wd_condensed", N].solve if ("mho_wd_condensed", N) in by_key else None
        cells = [str(N), *(_number(by_key[sheet, N].operations) for sheet in sheets), _number(solve or 0)]
        lines.append("| " + " | ".join(cells) + " |")
    grown = [growth(found, sheet) for sheet in sheets]
    condensed = next((one.solve_exponent for one in grown if one.sheet == "mho_wd_condensed"), None)
    cells = ["fitted exponent", *(f"{one.exponent:.2f}" for one in grown), f"{condensed:.2f}" if condensed else ""]
    lines.append("| " + " | ".join(cells) + " |")
    cells = ["one transition more", *(_number(round(one.per_transition)) for one in grown), ""]
    lines.append("| " + " | ".join(cells) + " |")
    return "\n".join(lines) + "\n"


def _number(value: int) -> str:
    return f"{value:,}".replace(",", " ")


def main(arguments: Sequence[str] | None = None) -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(prog="python -m verification.results.horizon_operations")
    parser.add_argument("--longest", type=int, default=HORIZONS[-1], help="the largest N; at least 3")
    longest = parser.parse_args(arguments).longest
    if longest < HORIZONS[0] + 1:
        parser.error(f"--longest {longest}: no growth to be seen from N = {HORIZONS[0]} to {longest}; write at least 3")
    found = costs(range(HORIZONS[0], longest + 1))
    print(table(found), end="")
    first = FITTED[0] if longest >= FITTED[0] else HORIZONS[0]
    print(f"\nThe exponents are fitted over N = {first} to {min(longest, FITTED[-1])}. `ekf`: {filter_operations()} operations.")
    print("The equations of `mho_pe` and `mho_wod` alone: ", end="")
    print(", ".join(sorted({str(one.solve) for one in found if one.sheet in ("mho_pe", "mho_wod")})), "at every N.")


if __name__ == "__main__":
    main()
