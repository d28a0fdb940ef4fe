"""``python -m verification.cleanliness.stack_table``: the stack of a frame as gcc tells it, and what C99 limits, as a table.

The estimators, both widths. Without gcc its columns are empty.
"""

from __future__ import annotations

import tempfile
from pathlib import Path

from verification.cleanliness.checks import stack
from verification.cleanliness.subjects import ESTIMATORS, estimators
from verification.cleanliness.tools import where

LEVELS = ("-O0", "-O2")
WIDTHS = (64, 32)


def rows(names: tuple[str, ...] = ESTIMATORS) -> list[tuple[str | int, ...]]:
    """By sheet: its name, bytes of stack by width and level, the most parameters of a function, identifiers of a block."""
    found: list[tuple[str | int, ...]] = []
    with tempfile.TemporaryDirectory() as folder:
        subjects = list(estimators(Path(folder), names, WIDTHS, 1))
        for name in names:
            members = [s for width in WIDTHS for s in subjects if s.name == name and s.real == width]
            bytes_ = [stack(level)(s).measure if where("gcc") else "" for s in members for level in LEVELS]
            limits = (max(s.parameters for s in members), max(s.identifiers for s in members))
            found.append((name, *bytes_, *limits))
    return found


def main() -> None:
    """Print the table."""
    columns = [f"binary{width} {level}" for width in WIDTHS for level in LEVELS]
    print(f"| sheet | {' | '.join(columns)} | parameters | identifiers in a block |")
    print("|---" * (len(columns) + 3) + "|")
    for row in rows():
        cells = (f"{cell:,}".replace(",", " ") if isinstance(cell, int) else cell for cell in row)
        print(f"| {' | '.join(cells)} |")


if __name__ == "__main__":
    main()
