"""Answers about a place in a sheet: what it is, where it is defined and used, and what a new name for it would change."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from saoflow.blocks.library import SYMBOLS
from saoflow.diagnosis import Position
from saoflow.diagrams.sheet import BlockDeclaration, IterationDeclaration, ParameterDeclaration
from saoflow.lsp.places import Place, target_of
from saoflow.lsp.workspace import Readable, Sheets


@dataclass(frozen=True, slots=True)
class Found:
    """A place in a file."""

    file: Path
    position: Position


def place_at(readable: Readable, line: int, column: int) -> Place | None:
    """The name at a line and column from 1; the cursor may stand behind its last letter."""
    for place in readable.places:
        at = place.position
        if at.line == line and at.column <= column <= at.column + at.length:
            return place
    return None


# -- hover


def hover(sheets: Sheets, path: Path, place: Place) -> str:
    """What a name means, as Markdown."""
    readable = sheets.sheet(path)
    assert readable is not None
    match place.kind:
        case "symbol":
            return _symbol(place.name)
        case "sheet":
            return _sheet(sheets, path, place.name)
        case "parameter":
            return _parameter(sheets, path, readable, place.name)
        case "wire":
            return _wire(sheets, path, readable, place.name)
        case "output":
            return _output(sheets, path, readable, place)
        case _:
            return _member(sheets, path, place)


def _symbol(name: str) -> str:
    symbol = SYMBOLS[name]
    ports = ", ".join(f"`{port.name}`" for port in symbol.ports)
    return f"**{name}** (symbol): {symbol.summary}\n\n`{symbol.equation}`" + (f"\n\ninputs: {ports}" if ports else "")


def _sheet(sheets: Sheets, path: Path, name: str) -> str:
    found = sheets.find(name, path)
    if found is None:
        return f"**{name}**: no sheet of that name"
    sheet = found[1].sheet
    ports = f"inputs: {_named([i.name.text for i in sheet.inputs])}; outputs: {_named([o.name.text for o in sheet.outputs])}"
    equations = f"\n\n*{sheet.equations}*" if sheet.equations else ""
    return f"**{name}** (sheet): {sheet.doc}{equations}\n\n{ports}"


def _named(names: list[str]) -> str:
    return ", ".join(f"`{name}`" for name in names) or "none"


def _parameter(sheets: Sheets, path: Path, readable: Readable, name: str) -> str:
    declared = next((p for p in readable.sheet.parameters if p.name.text == name), None)
    if declared is None:
        return ""
    facts = sheets.known(path)
    value = facts.parameters.get(name) if facts is not None else None
    return _described_parameter(declared, readable, value)


def _described_parameter(declared: ParameterDeclaration, readable: Readable, value: str | None) -> str:
    at = declared.name.position
    written = readable.sheet.lines[at.line - 1].strip() if at.line <= len(readable.sheet.lines) else ""
    parts = [f"**{declared.name.text}** (parameter)" + (", inherited" if declared.inherited else "")]
    if value is not None:
        parts.append(f"value: `{value}`" + (f" {declared.unit.items}" if declared.unit is not None else ""))
    elif written:
        parts.append(f"```yaml\n{written}\n```")
    parts += [text for text in (declared.doc, declared.source and f"source: {declared.source}") if text]
    return "\n\n".join(parts)


def _wire(sheets: Sheets, path: Path, readable: Readable, name: str) -> str:
    port = next((i for i in readable.sheet.inputs if i.name.text == name), None)
    if port is not None:
        return f"**{name}** (input)" + _types(sheets, path, port.name.position) + (f"\n\n{port.doc}" if port.doc else "")
    block = sheets.declarations(readable).get(name)
    if block is None:
        return ""
    meaning = _iteration(block) if isinstance(block, IterationDeclaration) else _block(sheets, path, block)
    doc = f"\n\n{block.doc}" if block.doc else ""
    return f"**{name}**{_types(sheets, path, block.name.position)}{_cost(sheets, path, block.name.position)}{doc}\n\n{meaning}"


def _block(sheets: Sheets, path: Path, block: BlockDeclaration) -> str:
    name = block.symbol.text
    return _symbol(name) if name in SYMBOLS else _sheet(sheets, path, name)


def _iteration(block: IterationDeclaration) -> str:
    order = ", in reverse" if block.reverse else ""
    return f"{block.kind} of `{block.sheet.text}`{order}"


def _types(sheets: Sheets, path: Path, position: Position) -> str:
    facts = sheets.known(path)
    fact = facts.at(str(path), position.line, position.column) if facts is not None else None
    if fact is None:
        return ""
    if len(fact.types) == 1:
        return f": {fact.types[0][1]}"
    return "".join(f"\n- `.{name}`: {found}" for name, found in fact.types)


def _cost(sheets: Sheets, path: Path, position: Position) -> str:
    facts = sheets.known(path)
    fact = facts.at(str(path), position.line, position.column) if facts is not None else None
    if facts is None or fact is None:
        return ""
    cost = facts.cost(fact.path)
    return "" if cost is None else f"\n\n{cost} operation{'' if cost == 1 else 's'} a frame (at `{fact.path}`)"


def _output(sheets: Sheets, path: Path, readable: Readable, place: Place) -> str:
    found = sheets.find(place.owner, path) if place.owner != readable.sheet.name.text else (path, readable)
    if found is None:
        return ""
    output = next((o for o in found[1].sheet.outputs if o.name.text == place.name), None)
    if output is None:
        return ""
    facts = sheets.known(path)
    block = sheets.declarations(readable).get(place.of)
    types = ""
    for declared in sheets.declarations(readable).values():
        fact = facts.at(str(path), declared.name.position.line, declared.name.position.column) if facts else None
        names = dict(fact.types) if fact is not None else {}
        if declared is not block and target_of(declared) == place.owner and place.name in names:
            types = f": {names[place.name]}"
            break
    return f"**{place.name}** (output of `{place.owner}`){types}" + (f"\n\n{output.doc}" if output.doc else "")


def _member(sheets: Sheets, path: Path, place: Place) -> str:
    """A port or a parameter of what a block uses."""
    if place.owner in SYMBOLS:
        symbol = SYMBOLS[place.owner]
        docs = {port.name: port.doc for port in symbol.ports}
        docs.update({parameter.name: parameter.doc for parameter in symbol.parameters})
        return f"**{place.name}** of `{place.owner}`: {docs[place.name]}" if place.name in docs else ""
    found = sheets.find(place.owner, path)
    if found is None:
        return ""
    port = next((i for i in found[1].sheet.inputs if i.name.text == place.name), None)
    if port is not None:
        return f"**{place.name}** (input of `{place.owner}`)" + (f"\n\n{port.doc}" if port.doc else "")
    declared = next((p for p in found[1].sheet.parameters if p.name.text == place.name), None)
    return "" if declared is None else _described_parameter(declared, found[1], None)


# -- definition and uses


def definition(sheets: Sheets, path: Path, place: Place) -> Found | None:
    """Where a name is defined; symbols are defined in no sheet."""
    readable = sheets.sheet(path)
    assert readable is not None
    if place.kind in ("wire", "parameter"):
        return _defined(path, readable, place.kind, place.name)
    if place.kind == "symbol" or (place.kind in ("port", "argument") and place.owner in SYMBOLS):
        return None
    name = place.name if place.kind == "sheet" else place.owner
    found = (path, readable) if name == readable.sheet.name.text else sheets.find(name, path)
    if found is None:
        return None
    file, other = found
    if place.kind == "sheet":
        return Found(file, other.sheet.name.position)
    if place.kind == "output":
        output = next((o for o in other.sheet.outputs if o.name.text == place.name), None)
        return None if output is None else Found(file, output.name.position)
    return _defined(file, other, "wire", place.name) or _defined(file, other, "parameter", place.name)


def _defined(file: Path, readable: Readable, kind: str, name: str) -> Found | None:
    for place in readable.places:
        if place.kind == kind and place.defines and place.name == name:
            return Found(file, place.position)
    return None


def references(sheets: Sheets, path: Path, place: Place) -> list[Found]:
    """Every place in the folder that names the same thing, its definition included."""
    readable = sheets.sheet(path)
    assert readable is not None
    target = meant_by(sheets, path, readable, place)
    found = {Found(file, p.position): None for file, p in same(sheets, target)}
    return list(found)


@dataclass(frozen=True, slots=True)
class Meant:
    """A thing with a name: of a sheet in a file; which of its roles are seen from outside."""

    file: Path
    sheet: str
    name: str
    kind: str
    """``wire``, ``parameter``, ``sheet``, ``symbol`` or ``output``."""
    is_output: bool = False
    """A wire that is an output under its own name."""


def meant_by(sheets: Sheets, path: Path, readable: Readable, place: Place) -> Meant:
    own = readable.sheet.name.text
    if place.kind in ("symbol", "sheet"):
        return Meant(path, own, place.name, place.kind)
    if place.kind in ("wire", "parameter"):
        listed = any(
            o.name.text == place.name and o.name.position == o.wire.position for o in readable.sheet.outputs
        )
        return Meant(path, own, place.name, place.kind, place.kind == "wire" and listed)
    found = (path, readable) if place.owner == own else sheets.find(place.owner, path)
    if found is None:
        return Meant(path, place.owner, place.name, place.kind)
    file, other = found
    if place.kind == "output":
        listed = any(o.name.text == place.name and o.name.position == o.wire.position for o in other.sheet.outputs)
        return Meant(file, place.owner, place.name, "wire" if listed else "output", listed)
    inputs = {i.name.text for i in other.sheet.inputs}
    return Meant(file, place.owner, place.name, "wire" if place.name in inputs else "parameter")


def same(sheets: Sheets, meant: Meant) -> Iterator[tuple[Path, Place]]:
    for file, readable in sheets.around(meant.file):
        is_own = readable.sheet.name.text == meant.sheet and file == meant.file
        for place in readable.places:
            if place.name != meant.name:
                continue
            outside = place.owner == meant.sheet and (
                (place.kind in ("port", "argument") and meant.kind in ("wire", "parameter"))
                or (place.kind == "output" and (meant.kind == "output" or meant.is_output))
            )
            own = is_own and place.kind == meant.kind and not place.owner
            if own or outside or (meant.kind in ("sheet", "symbol") and place.kind == meant.kind):
                yield file, place
