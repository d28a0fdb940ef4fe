"""The command ``saoflow check``."""

from __future__ import annotations

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
        sheet = load_sheet(name, settings, findings)
        everything += findings.found
        facts.append(_facts(name, sheet, findings))
        if not json:
            tell(findings.found)
            print(_summary(facts[-1]))
    if json:
        finish(everything, json, {"sheets": facts})
    elif exit_code(everything):
        raise typer.Exit(exit_code(everything))


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
