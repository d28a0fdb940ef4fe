"""The command ``saoflow check``."""

from __future__ import annotations

from contextlib import suppress
from functools import partial
from typing import TYPE_CHECKING, Annotated, Any

import typer

from saoflow.commands.shell import Findings, Json, Set, exit_code, finish, load_sheet, tell

if TYPE_CHECKING:
    from saoflow.pipeline import LoadedSheet


def check(
    sheets: Annotated[
        list[str],
        typer.Argument(metavar="SHEET...", help="YAML files, or names of shipped sheets.", show_default=False),
    ],
    settings: Set = None,
    json: Json = False,
) -> None:
    """Read, elaborate and order sheets; print every diagnosis, not only the first.

    Example: saoflow check my_sheet.yaml cmhe_fte
    """
    facts, everything = [], []
    for name in sheets:
        findings = Findings()
        sheet = load_sheet(name, settings, findings, check=False)
        known = None if sheet is None else _known(sheet)
        if known is None:
            sheet = None if sheet is None else findings.attempt(partial(_checked, sheet))
            known = _facts(name, sheet, findings)
            if sheet is not None and not findings.found:
                _keep(sheet, known)
        everything += findings.found
        facts.append(known)
        if not json:
            tell(findings.found)
            print(_summary(facts[-1]))
    if json:
        finish(everything, json, {"sheets": facts})
    elif exit_code(everything):
        raise typer.Exit(exit_code(everything))


def _checked(sheet: LoadedSheet) -> LoadedSheet:
    """The sheet, elaborated and ordered. Raises DiagnosisError."""
    sheet.check()
    return sheet


def _known(sheet: LoadedSheet) -> dict[str, Any] | None:
    """What was found before in the same sheets by the same code, if that was nothing wrong."""
    from saoflow.cache import cache_folder
    from saoflow.codegen.objects import content_key

    folder = cache_folder()
    key = "" if folder.problem else content_key(sheet)
    content = folder.read(f"{key}.check") if key else None
    if content is None:
        return None
    blocks, sheets = (int(number) for number in content.split())
    return _fine(sheet, blocks, sheets)


def _keep(sheet: LoadedSheet, facts: dict[str, Any]) -> None:
    """Keep that nothing is wrong; where that cannot be, the sheet is checked anew next time."""
    from saoflow.cache import cache_folder
    from saoflow.codegen.objects import content_key

    folder = cache_folder()
    key = "" if folder.problem else content_key(sheet)
    if key:
        with suppress(OSError):
            folder.write(f"{key}.check", f"{facts['blocks']} {facts['sub_sheets']}".encode())


def _fine(sheet: LoadedSheet, blocks: int, sheets: int) -> dict[str, Any]:
    found = {"sheet": sheet.name, "errors": 0, "warnings": 0}
    return {**found, "file": sheet.sheet.file, "blocks": blocks, "sub_sheets": sheets}


def _facts(name: str, sheet: LoadedSheet | None, findings: Findings) -> dict[str, Any]:
    errors = len(findings.errors)
    facts: dict[str, Any] = {"sheet": name, "errors": errors, "warnings": len(findings.found) - errors}
    if sheet is not None:
        from saoflow.diagrams.netlist import count_instances

        blocks, sheets = count_instances(sheet.netlist)
        facts |= {"sheet": sheet.name, "file": sheet.sheet.file, "blocks": blocks, "sub_sheets": sheets}
    return facts


def _summary(facts: dict[str, Any]) -> str:
    found = f"{_many(facts['errors'], 'error')}" + (
        f", {_many(facts['warnings'], 'warning')}" if facts["warnings"] else ""
    )
    if "blocks" not in facts:
        return f"{facts['sheet']}: {found}"
    return f"{facts['sheet']}: {_many(facts['blocks'], 'block')}, {_many(facts['sub_sheets'], 'sub-sheet')}, {found}"


def _many(count: int, word: str) -> str:
    return f"{count} {word}{'' if count == 1 else 's'}"
