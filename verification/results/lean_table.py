"""What each change on the way from `cmhe_fte` to `cmhe_fte_lean` saves, counted on sheets that run.

    python -m verification.results.lean_table
    python -m verification.results.lean_table -o docs/lean.md

With ``-o`` the table takes the place of the one in the document.
"""

from __future__ import annotations

import argparse
import re
import sys
from dataclasses import dataclass
from pathlib import Path

from saoflow import DiagnosisError
from saoflow.whole_file import write_whole
from verification.results.lean_variants import VARIANTS, Variant, loaded

TABLE = re.compile(r"^\|.*\n(?:\|.*\n)+", re.MULTILINE)
"""The first table of a Markdown document."""


@dataclass(frozen=True)
class Cost:
    """What one variant costs, in operations a frame."""

    variant: Variant
    frame: int
    step3: int
    reciprocals: int
    lookups: int


def cost(variant: Variant) -> Cost:
    """Count a variant's operations."""
    with loaded(variant) as sheet:
        tree = sheet.budget().tree
    return Cost(variant, tree.total, tree.parts["step3"].total, tree.kinds["reciprocal"], tree.kinds["lookup"])


def table(costs: tuple[Cost, ...]) -> str:
    """The costs as a Markdown table, each row against the one above."""
    lines = [
        "| each with what is above it | operations a frame | saves | Step 3 alone | reciprocals | look-ups |",
        "|---|---:|---:|---:|---:|---:|",
    ]
    before: Cost | None = None
    for row in costs:
        saved = "" if before is None else f"{before.frame - row.frame:,}".replace(",", " ")
        numbers = (f"{n:,}".replace(",", " ") for n in (row.step3, row.reciprocals, row.lookups))
        frame = f"{row.frame:,}".replace(",", " ")
        lines.append(f"| {row.variant.title} | {frame} | {saved} | {' | '.join(numbers)} |")
        before = row
    return "\n".join(lines) + "\n"


def main(arguments: list[str] | None = None) -> int:
    """Print the table, or put it into a document. Returns the exit code: 2 if the document cannot be used."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("-o", "--output", type=Path, help="a Markdown document whose first table is replaced")
    output: Path | None = parser.parse_args(arguments).output
    try:
        text = table(tuple(cost(variant) for variant in VARIANTS))
    except DiagnosisError as error:
        print(error, file=sys.stderr)
        return 2
    if output is None:
        print(text, end="")
        return 0
    try:
        document, found = TABLE.subn(lambda _: text, output.read_text(encoding="utf-8"), count=1)
        if not found:
            print(f"{output} has no table to replace", file=sys.stderr)
            return 2
        write_whole(output, document.encode("utf-8"))
    except OSError as error:
        print(f"{output}: {error.strerror}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
