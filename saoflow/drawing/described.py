"""Drawings as the page's script reads them: short keys, types each once."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from saoflow.drawing.drawing import Block, Drawing, Drawings, Source, Terminal, WireShown

if TYPE_CHECKING:
    from saoflow.pipeline import LoadedSheet

LONGEST_LINE = 200


def described(drawings: Drawings, sheet: LoadedSheet) -> dict[str, Any]:
    """``drawings``, ``wires`` (by body, the number of the type of each wire), ``types`` and ``sheets`` (doc, equations)."""
    types: dict[WireShown, int] = {}
    wires = [
        [None if wire is None else types.setdefault(wire, len(types)) for wire in body] for body in drawings.wires
    ]
    sheets = {d.sheet: [d.doc, d.equations] for d in drawings.drawings if d.kind == "sheet"}
    lines = sheet.netlist.sources
    return {
        "drawings": [_drawing(d, lambda b: (lines.line(b.position) or "").strip()[:LONGEST_LINE]) for d in drawings.drawings],
        "wires": wires,
        "types": [[list(t.shape), t.unit, t.boolean] for t in types],
        "sheets": sheets,
    }


def _drawing(d: Drawing, line_of: Any) -> dict[str, Any]:
    return {
        "sheet": d.sheet,
        "kind": d.kind,
        "doc": d.doc,
        "eq": d.equations,
        "f": d.position.file,
        "l": d.position.line,
        "body": d.body,
        "left": d.left_out,
        "blocks": [_block(b, line_of(b)) for b in d.blocks],
        "inputs": [_terminal(t) for t in d.inputs],
        "outputs": [_terminal(t) for t in d.outputs],
    }


def _block(b: Block, line: str) -> dict[str, Any]:
    return {
        "n": b.name,
        "k": b.kind,
        "of": b.of,
        "g": b.glyph,
        "i": [{"n": p.name, "t": p.text, "w": p.wire, "s": _sources(p.sources), "c": int(p.carried)} for p in b.inputs],
        "o": [{"n": p.name, "w": p.wire} for p in b.outputs],
        "f": b.position.file,
        "l": b.position.line,
        "src": line,
        "in": b.inside,
        "call": b.call,
        "count": b.count,
        "ft": int(b.feeds_through),
        "rate": b.rate,
        "tab": [list(axis) for axis in b.table],
    }


def _terminal(t: Terminal) -> dict[str, Any]:
    return {"n": t.name, "w": t.wire, "d": t.doc, "t": t.text, "s": _sources(t.sources)}


def _sources(sources: tuple[Source, ...]) -> list[list[int]]:
    return [[s.block, s.port] for s in sources]
