"""The command ``saoflow check``."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, Annotated

import typer

from saoflow.commands.kept_check import Facts, keep, kept, summary, verdict_key
from saoflow.commands.shell import Findings, Json, Set, errors_stay, exit_code, finish, load_sheet, tell

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
        key = verdict_key(name, settings or ())
        known = kept(key)
        if known is None:
            known = _found(name, settings, findings)
            # Files that changed meanwhile may have been read before or after that.
            if not findings.found and verdict_key(name, settings or ()) == key:
                keep(key, known)
        everything += findings.found
        facts.append(known)
        if not json:
            with errors_stay(everything):
                tell(findings.found)
                print(summary(known), flush=True)
    if json:
        finish(everything, json, {"sheets": facts})
    elif exit_code(everything):
        raise typer.Exit(exit_code(everything))


def _found(name: str, settings: list[str] | None, findings: Findings) -> Facts:
    """Check a sheet: what is wrong goes to ``findings``."""
    sheet = load_sheet(name, settings, findings, check=False)
    sheet = None if sheet is None else findings.attempt(partial(_checked, sheet))
    return _facts(name, sheet, findings)


def _checked(sheet: LoadedSheet) -> LoadedSheet:
    """The sheet, elaborated and ordered. Raises DiagnosisError."""
    sheet.check()
    return sheet


def _facts(name: str, sheet: LoadedSheet | None, findings: Findings) -> Facts:
    errors = len(findings.errors)
    facts: Facts = {"sheet": name, "errors": errors, "warnings": len(findings.found) - errors}
    if sheet is not None:
        from saoflow.diagrams.netlist import count_instances

        blocks, sheets = count_instances(sheet.netlist)
        facts |= {"sheet": sheet.name, "file": sheet.sheet.file, "blocks": blocks, "sub_sheets": sheets}
    return facts
