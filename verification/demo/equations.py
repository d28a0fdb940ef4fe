"""Which sheet holds which equations of the paper: ``python -m verification.demo.equations [SHEET]``.

The table follows the sheets as one uses the other, and says what each sheet's own ``equations:`` says.
"""

from __future__ import annotations

import sys
from pathlib import Path

import saoflow
from saoflow.diagrams.sheet import IterationDeclaration, Sheet


def reading_order(name: str) -> list[Sheet]:
    """The sheet and those of its folder that it uses, each once, in the order in which they are met."""
    found: dict[str, Sheet] = {}

    def visit(path: str) -> None:
        sheet = saoflow.load(path).sheet
        found[sheet.name.text] = sheet
        for block in sheet.blocks:
            used = block.sheet if isinstance(block, IterationDeclaration) else block.symbol
            beside = Path(sheet.file).parent / f"{used.text}.yaml"
            if used.text not in found and beside.is_file():
                visit(str(beside))

    visit(name)
    return list(found.values())


def table(name: str) -> str:
    """The table in Markdown."""
    lines = ["| sheet | equations | what it does |", "|---|---|---|"]
    for sheet in reading_order(name):
        text = sheet.equations.removeprefix("Paper 004").lstrip(", ") or "none"
        what = " ".join(sheet.doc.split()).split(". ")[0].rstrip(".").replace("|", "\\|")
        lines.append(f"| `{sheet.name.text}` | {text} | {what} |")
    return "\n".join(lines)


if __name__ == "__main__":
    print(table(sys.argv[1] if len(sys.argv) > 1 else "cmhe_fte"))
