"""A new name for a wire, port or parameter, everywhere it must change with it.

Some names are one by rule, in several sheets: a parameter and those that inherit it, the input and the output that a fold
carries. They change together, or not at all.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from saoflow.blocks.library import SYMBOLS
from saoflow.diagrams.sheet import BlockDeclaration, IterationDeclaration
from saoflow.lsp.answers import Found, Meant, meant_by, same
from saoflow.lsp.places import Place, target_of
from saoflow.lsp.workspace import Readable, Sheets

Block = BlockDeclaration | IterationDeclaration
RESERVED = ("fold", "map", "zeros", "ones", "diag", "pi", "index", "inherited")


def rename(sheets: Sheets, path: Path, place: Place, new: str) -> list[Found] | str:
    """The places to change, or why that name cannot be given."""
    readable = sheets.sheet(path)
    assert readable is not None
    if place.kind not in ("wire", "output", "port", "parameter", "argument") or place.owner in SYMBOLS:
        return "only wires, ports and parameters are renamed here; a sheet's name is its file's name"
    if not (new.isidentifier() and new.isascii()) or new in RESERVED:
        return f"`{new}` is no name: letters, digits and _, no digit first"
    things = _together(sheets, meant_by(sheets, path, readable, place), path.parent)
    if isinstance(things, str):
        return things
    found: dict[Found, None] = {}
    for thing in things:
        owner = sheets.sheet(thing.file)
        if owner is not None and new in _names(owner):
            return f"`{new}` is taken in sheet `{thing.sheet}`"
        found.update({Found(file, other.position): None for file, other in same(sheets, thing)})
    return list(found)


def _names(readable: Readable) -> set[str]:
    return {p.name for p in readable.places if p.defines and p.kind in ("wire", "parameter", "output")}


def _together(sheets: Sheets, first: Meant, folder: Path) -> list[Meant] | str:
    """All things that have one name by rule; or why they cannot be told."""
    things, waiting = {first: None}, [first]
    while waiting:
        thing = waiting.pop()
        if thing.file.parent != folder:
            return f"`{thing.name}` is a name of sheet `{thing.sheet}` too, in another folder ({thing.file.parent})"
        readable = sheets.sheet(thing.file)
        if readable is None:
            continue
        if thing.kind == "parameter":
            shared = _shared(sheets, thing, readable)
            if shared:
                return f"`{thing.name}` is a parameter of `{shared}` too, by `parameters_of`: rename it by hand"
            others = [*_heirs(sheets, thing, readable), *_givers(sheets, thing, readable)]
        else:
            others = list(_carried(sheets, thing, readable))
        waiting += [other for other in others if other not in things]
        things.update(dict.fromkeys(others))
    return list(things)


def _shared(sheets: Sheets, thing: Meant, readable: Readable) -> str:
    """The sheet that shares a parameter by ``parameters_of``; empty if none does."""
    other = readable.sheet.parameters_of
    if other is not None:
        found = sheets.find(other.text, thing.file)
        if found is not None and _declares(found[1], thing.name):
            return other.text
    for _, user in sheets.around(thing.file):
        named = user.sheet.parameters_of
        if named is None:
            continue
        uses = any(target_of(block) == thing.sheet for block in user.sheet.blocks)
        if named.text == thing.sheet or (uses and not _declares(user, thing.name)):
            return user.sheet.name.text
    return ""


def _declares(readable: Readable, name: str, inherited: bool = False) -> bool:
    return any(p.name.text == name and (p.inherited or not inherited) for p in readable.sheet.parameters)


def _is_given(block: Block, name: str) -> bool:
    return any(argument.name.text == name for argument in block.arguments)


def _heirs(sheets: Sheets, thing: Meant, readable: Readable) -> Iterator[Meant]:
    """The sheets inside that inherit a parameter."""
    for block in readable.sheet.blocks:
        target = target_of(block)
        found = None if target in SYMBOLS or _is_given(block, thing.name) else sheets.find(target, thing.file)
        if found is not None and _declares(found[1], thing.name, inherited=True):
            yield Meant(found[0], target, thing.name, "parameter")


def _givers(sheets: Sheets, thing: Meant, readable: Readable) -> Iterator[Meant]:
    """The sheets around from which a parameter is inherited."""
    if not _declares(readable, thing.name, inherited=True):
        return
    for file, user in sheets.around(thing.file):
        uses = any(target_of(b) == thing.sheet and not _is_given(b, thing.name) for b in user.sheet.blocks)
        if uses and _declares(user, thing.name):
            yield Meant(file, user.sheet.name.text, thing.name, "parameter")


def _carried(sheets: Sheets, thing: Meant, readable: Readable) -> Iterator[Meant]:
    """The input and the output of one name that a fold hands from instance to instance."""
    for _, user in sheets.around(thing.file):
        for block in user.sheet.blocks:
            if not isinstance(block, IterationDeclaration) or target_of(block) != thing.sheet:
                continue
            if any(c.port is not None and c.port.text == thing.name for c in block.carry):
                yield from _ports(thing, readable)
                return


def _ports(thing: Meant, readable: Readable) -> Iterator[Meant]:
    sheet = readable.sheet
    listed = any(o.name.text == thing.name and o.name.position == o.wire.position for o in sheet.outputs)
    if any(i.name.text == thing.name for i in sheet.inputs):
        yield Meant(thing.file, thing.sheet, thing.name, "wire", listed)
    if any(o.name.text == thing.name for o in sheet.outputs):
        yield Meant(thing.file, thing.sheet, thing.name, "wire" if listed else "output", listed)
