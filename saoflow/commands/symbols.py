"""The command ``saoflow symbols``."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any

import typer

from saoflow.commands.shell import Findings, Json, console, finish
from saoflow.diagnosis import Diagnosis, did_you_mean

if TYPE_CHECKING:
    from saoflow.symbol_catalogue import LibrarySheet, SymbolEntry


def symbols(
    name: Annotated[
        str | None, typer.Argument(metavar="NAME", help="One symbol or library sheet, in full.", show_default=False)
    ] = None,
    json: Json = False,
) -> None:
    """List what sheets are made of: every symbol and library sheet, with ports, meaning and cost.

    Example: saoflow symbols lookup
    """
    from saoflow.symbol_catalogue import library_sheets, symbol_entries

    entries, library = symbol_entries(), library_sheets()
    if name is not None:
        entries = [entry for entry in entries if entry.name == name]
        library = [sheet for sheet in library if sheet.name == name]
        if not entries and not library:
            _unknown(name, json)
    if json:
        facts = {"symbols": [e.to_dict() for e in entries], "sheets": [s.to_dict() for s in library]}
        finish([], True, facts)
    elif name is None:
        _lists(entries, library)
    else:
        lines = [line for entry in entries for line in entry.text()] + [line for s in library for line in s.text()]
        print("\n".join(lines))


def _unknown(name: str, json: bool) -> None:
    from saoflow.symbol_catalogue import library_sheets, symbol_entries

    known = [entry.name for entry in symbol_entries()] + [sheet.name for sheet in library_sheets()]
    findings = Findings()
    findings.add(
        Diagnosis(
            "E201",
            f"there is no symbol or library sheet `{name}`",
            cause="neither the symbols nor the library have one of that name",
            remedy=did_you_mean(name, known) or "`saoflow symbols` lists all",
        )
    )
    finish(findings.found, json)


def _lists(entries: list[SymbolEntry], library: list[LibrarySheet]) -> None:
    from rich.table import Table
    from rich.text import Text

    terminal = console(width=160)
    table: Any = Table(box=None, pad_edge=False, padding=(0, 2, 0, 0))
    for title in ("symbol", "profile", "meaning", "example", "cost"):
        table.add_column(title)
    for entry in entries:
        example = entry.examples[0]
        table.add_row(*map(Text, (entry.name, entry.profile, entry.summary, example.text, example.cost)))
    terminal.print(table)
    print()
    table = Table(box=None, pad_edge=False, padding=(0, 2, 0, 0))
    for title in ("library sheet", "inputs", "outputs", "meaning"):
        table.add_column(title)
    for sheet in library:
        ports = [", ".join(member.name for member in members) for members in (sheet.inputs, sheet.outputs)]
        table.add_row(*map(Text, (sheet.name, *ports, sheet.doc.split(". ")[0].rstrip("."))))
    terminal.print(table)
    print("\n`saoflow symbols NAME` shows one of them in full.")
