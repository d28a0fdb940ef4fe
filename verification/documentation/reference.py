"""Pages made from what they describe: every symbol, every sheet of the library, every sheet of the flagship."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator
from html import escape
from pathlib import Path
from typing import Any

import saoflow
from saoflow.blocks.library import SYMBOLS
from saoflow.diagrams.reader import read_sheet
from saoflow.diagrams.store import SHIPPED
from saoflow.drawing.style import picture_css
from saoflow.symbol_catalogue import LibrarySheet, SymbolEntry, library_sheets, symbol_entries
from verification.documentation.paper_equations import EQUATIONS, aligned

FLAGSHIP = (
    *("cmhe_fte", "conditioning", "start_up", "first_state", "warm_start", "output_equation", "step1", "step2"),
    *("configuration", "step3", "linearisation", "interior_point", "barrier", "newton_transition", "newton_output"),
    *("stage", "measurement_update", "time_update", "backward_stage", "line_search"),
)
"""The order of the paper; further sheets of its folder follow in the order in which they are met."""


def instances(data: dict[str, Any]) -> dict[str, str]:
    """The first instance of every sheet inside a sheet, by the sheet's name, the outermost first."""
    found = {data["title"]: ""}
    queue = deque([("", 0)])
    seen = {0}
    while queue:
        path, number = queue.popleft()
        drawing = data["drawings"][number]
        outer = path.rpartition(".")[0] if drawing["kind"] == "stack" else path
        for block in drawing["blocks"]:
            if block["in"] is None:
                continue
            inner = f"{outer}.{block['n']}" if outer else block["n"]
            if block["k"] == "sheet":
                found.setdefault(block["of"], inner)
            if block["in"] not in seen:
                seen.add(block["in"])
                queue.append((inner, block["in"]))
    return found


def symbols_page() -> str:
    """Every symbol: glyph, equation, inputs, parameters, examples with their cost."""
    parts = [
        "# Symbols",
        "",
        "The blocks that sheets are made of; made from `saoflow/blocks/`, one file a symbol. Profile `six` is what the",
        "numerics may use, `sao` adds the decision symbols. The examples are counted and run by the tests",
        "(`tests/blocks/test_symbols.py`). Composites are in the [library](library.md).",
        "",
    ]
    for entry in symbol_entries():
        parts += _symbol(entry)
    return "\n".join(parts)


def _symbol(entry: SymbolEntry) -> Iterator[str]:
    yield f"## {entry.name}"
    yield ""
    yield f'<div class="glyph">{glyph(entry.name)}</div>'
    yield ""
    yield f"{entry.summary[:1].upper()}{entry.summary[1:]}. Profile `{entry.profile}`."
    yield ""
    yield f"    {entry.equation}"
    yield ""
    yield from _table("input", [(p.name, p.doc) for p in entry.ports])
    yield from _table("parameter", [(p.name, p.doc) for p in entry.parameters])
    yield "| example | costs in a frame |"
    yield "|---|---|"
    yield from (f"| `{_cell(example.text)}` | {_cell(example.cost)} |" for example in entry.examples)
    yield ""


def glyph(name: str) -> str:
    """The drawing of a symbol, as an SVG element with its own colours."""
    kept = "".join(line for line in picture_css().splitlines() if line.startswith((".box", ".stroke", ".curve", ".dot", "text", "tspan")))
    radius = 24 if name == "add" else 4
    box = f'<rect class="box" x="-24" y="-24" width="48" height="48" rx="{radius}"/>'
    return (
        f'<svg viewBox="-26 -26 52 52" width="72" height="72" role="img" aria-label="{escape(name)}">'
        f"<style>{kept}</style>{box}{SYMBOLS[name].glyph}</svg>"
    )


def _table(title: str, rows: list[tuple[str, str]]) -> Iterator[str]:
    if rows:
        yield f"| {title} | |"
        yield "|---|---|"
        yield from (f"| `{name}` | {_cell(doc)} |" for name, doc in rows)
        yield ""


def _cell(text: str) -> str:
    return " ".join(text.split()).replace("|", "\\|")


def library_page() -> str:
    """Every sheet of the library."""
    parts = [
        "# Library",
        "",
        "Sheets that are used as if they were symbols; made from `saoflow/diagrams/library/`.",
        "",
    ]
    for sheet in library_sheets():
        parts += _library_sheet(sheet)
    return "\n".join(parts)


def _library_sheet(sheet: LibrarySheet) -> Iterator[str]:
    yield f"## {sheet.name}"
    yield ""
    yield f"{sheet.doc} Profile `{sheet.profile}`."
    yield ""
    if sheet.equations:
        yield from (f"    {line}" for line in sheet.equations.splitlines())
        yield ""
    yield from _table("input", [(m.name, m.doc) for m in sheet.inputs])
    yield from _table("parameter", [(m.name, m.doc) for m in sheet.parameters])
    yield from _table("output", [(m.name, m.doc) for m in sheet.outputs])


def flagship_page(pictures: Path) -> str:
    """The flagship, sheet by sheet beside the paper's equations, each with its drawing in ``pictures``."""
    from saoflow.drawing.svg import Drafter

    sheet = saoflow.load("cmhe_fte")
    drafter = Drafter(sheet)
    tree = sheet.budget().tree
    parts = [
        "# The flagship, sheet by sheet",
        "",
        "Wan, Keviczky: *Real-time fault-tolerant moving horizon air data estimation for the RECONFIGURE benchmark*, IEEE",
        "Transactions on Control Systems Technology 27 (2019), as it would stand on the flight-control computer. Made from the",
        "sheets in `saoflow/diagrams/cmhe_fte/`; what is corrected in the paper is in [corrections](corrections.md). To walk",
        "through the drawings, and to play a flight: `saoflow view cmhe_fte`, see [drawings](view.md). The paper's equations stand",
        "in the form that is right; where the paper prints another, *corrected* stands behind them.",
        "",
    ]
    places = instances(drafter.data)
    own = [name for name in places if (SHIPPED / "cmhe_fte" / f"{name}.yaml").exists()]
    for name in [*FLAGSHIP, *(name for name in own if name not in FLAGSHIP)]:
        path = places[name]
        read = read_sheet(SHIPPED / "cmhe_fte" / f"{name}.yaml")
        cost = tree
        for part in path.split(".") if path else []:
            cost = cost.parts[part]
        picture = f"{name}.svg"
        (pictures / picture).write_text(drafter.draw(path), encoding="utf-8")
        parts += [f"## {name}", "", " ".join(read.doc.split()), ""]
        if read.equations:
            parts += [f"*{' '.join(read.equations.split())}*", ""]
        if name in EQUATIONS:
            parts += ["```text", aligned(EQUATIONS[name]), "```", ""]
        where = f" at `{path}`" if path else ""
        parts += [f"![{name}](flagship/{picture})", "", f"{cost.total} operations a frame{where}.", ""]
        text = (SHIPPED / "cmhe_fte" / f"{name}.yaml").read_text(encoding="utf-8")
        blocks = text[text.index("\nblocks:") + 1 :] if "\nblocks:" in text else text
        parts += ["<details><summary>its blocks</summary>", "", "```yaml", blocks.rstrip(), "```", "", "</details>", ""]
    return "\n".join(parts)
