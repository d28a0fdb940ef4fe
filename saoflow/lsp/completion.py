"""What may be written next: keys, symbols and sheets, ports, parameters, wires, outputs of a block, units."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from saoflow.blocks.library import SYMBOLS
from saoflow.diagrams.sheet import BlockDeclaration, IterationDeclaration
from saoflow.diagrams.store import SheetStore
from saoflow.lsp.places import target_of
from saoflow.lsp.workspace import Readable, Sheets
from saoflow.unit_names import KNOWN

KEYS = ("sheet", "doc", "equations", "profile", "parameters_of", "parameters", "inputs", "blocks", "outputs", "budget")
PORT_KEYS = ("shape", "unit", "type", "doc")
PARAMETER_KEYS = ("value", "inherited", "unit", "range", "doc", "source")
RATE_KEYS = ("every", "offset", "transition", "held")
ITERATION_KEYS = ("count", "order", "carry", "each", "in", "doc")


@dataclass(frozen=True, slots=True)
class Choice:
    """One thing that may be written."""

    text: str
    kind: str
    """``key``, ``symbol``, ``sheet``, ``wire``, ``output``, ``parameter``, ``port`` or ``unit``."""
    detail: str = ""


def complete(sheets: Sheets, path: Path, lines: Sequence[str], line: int, column: int) -> list[Choice]:
    """Choices at a line and column from 0; ``lines`` are the text as it now is."""
    before = lines[line][:column] if line < len(lines) else ""
    readable = sheets.sheet(path)
    section = _section(lines, line)
    if re.fullmatch(r"\w*", before):
        return [Choice(key, "key") for key in KEYS]
    if re.search(r"\bunit: *\"?[\w^*/ .-]*$", before):
        return [Choice(unit, "unit", meaning.replace("_", " ")) for unit, meaning in KNOWN.items()]
    member = re.search(r"(\w+)(?:\[[^\]]*\])?\.(\w*)$", before)
    if member is not None and readable is not None:
        return _members(sheets, path, readable, member[1])
    if section == "blocks":
        return _in_block(sheets, path, lines, line, before, readable)
    if section == "inputs" and re.search(r"[{,] *\w*$", before):
        return [Choice(key, "key") for key in PORT_KEYS]
    if section == "parameters" and re.search(r"[{,] *\w*$", before):
        return [Choice(key, "key") for key in PARAMETER_KEYS]
    return _wires(readable)


def _section(lines: Sequence[str], line: int) -> str:
    """The top-level key that a line belongs to."""
    for text in reversed(lines[: line + 1]):
        match = re.match(r"(\w+):", text)
        if match is not None:
            return match[1]
    return ""


def _in_block(
    sheets: Sheets, path: Path, lines: Sequence[str], line: int, before: str, readable: Readable | None
) -> list[Choice]:
    if re.search(r"^ +\w+: *\{ *\w*$", before) or re.search(r"^ {4}\w*$", before):
        return _targets(sheets, path)
    if re.search(r"\b(?:fold|map): *\w*$", before):
        return [choice for choice in _targets(sheets, path) if choice.kind == "sheet"]
    opened = re.search(r"^ +(\w+): *\{ *(\w+):", before)
    depth = before.count("[") - before.count("]")
    if opened is not None and not depth and re.search(r"[,{] *\w*$", before):
        return _arguments(sheets, path, opened[2], before)
    return _wires(readable)


def _targets(sheets: Sheets, path: Path) -> list[Choice]:
    found = [Choice(name, "symbol", symbol.summary) for name, symbol in SYMBOLS.items()]
    found += [Choice(word, "symbol", "the same sheet several times") for word in ("fold", "map")]
    names = {file.stem for file, _ in sheets.around(path)} | set(SheetStore().shipped)
    return found + [Choice(name, "sheet") for name in sorted(names - {path.stem})]


def _arguments(sheets: Sheets, path: Path, target: str, before: str) -> list[Choice]:
    """Ports and parameters of what a block uses; inside braces of its own, ports alone."""
    if target in ("fold", "map"):
        return [Choice(key, "key") for key in ITERATION_KEYS]
    only_ports = before.count("{") - before.count("}") > 1
    if target in SYMBOLS:
        symbol = SYMBOLS[target]
        ports = [Choice(p.name, "port", p.doc) for p in symbol.ports]
        return ports if only_ports else [*ports, *(Choice(p.name, "parameter", p.doc) for p in symbol.parameters)]
    found = sheets.find(target, path)
    if found is None:
        return []
    sheet = found[1].sheet
    ports = [Choice(i.name.text, "port", i.doc) for i in sheet.inputs]
    if only_ports:
        return ports
    parameters = [Choice(p.name.text, "parameter", p.doc) for p in sheet.parameters if not p.inherited]
    return [*ports, *parameters, *(Choice(key, "key") for key in RATE_KEYS)]


def _members(sheets: Sheets, path: Path, readable: Readable, block: str) -> list[Choice]:
    """The outputs of a block; the transpose of any wire."""
    found = [Choice("T", "output", "the transpose")]
    declared = sheets.declarations(readable).get(block)
    if declared is None:
        return found
    target = target_of(declared)
    other = sheets.find(target, path) if target not in SYMBOLS else None
    if other is not None:
        found = [Choice(o.name.text, "output", o.doc) for o in other[1].sheet.outputs] + found
    return found


def _wires(readable: Readable | None) -> list[Choice]:
    if readable is None:
        return []
    sheet = readable.sheet
    found = [Choice(i.name.text, "wire", i.doc or "input") for i in sheet.inputs]
    found += [Choice(b.name.text, "wire", b.doc or _what(b)) for b in sheet.blocks]
    return found + [Choice(p.name.text, "parameter", p.doc) for p in sheet.parameters]


def _what(block: BlockDeclaration | IterationDeclaration) -> str:
    return f"{block.kind} of {block.sheet.text}" if isinstance(block, IterationDeclaration) else block.symbol.text
