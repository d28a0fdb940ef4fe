"""The command ``saoflow budget``."""

from __future__ import annotations

from typing import Annotated

import typer

from saoflow.commands.shell import (
    BAD_INPUT,
    Findings,
    Json,
    Set,
    SheetName,
    console,
    exit_code,
    finish,
    load_sheet,
    tell,
)
from saoflow.diagnosis import Diagnosis


def budget(
    name: SheetName,
    settings: Set = None,
    depth: Annotated[int, typer.Option("--depth", min=0, metavar="N", help="Levels of sub-sheets shown.")] = 3,
    target: Annotated[
        str | None, typer.Option("--target", metavar="NAME", help="Cycles on a target (not yet).", show_default=False)
    ] = None,
    json: Json = False,
) -> None:
    """Operations of one frame by kind and by sub-sheet, against the sheet's budget. Exits 1 if it is over.

    Example: saoflow budget cmhe_fte --depth 2
    """
    findings = Findings()
    if target is not None:
        findings.add(
            Diagnosis(
                "E608",
                f"there is no target `{target}`",
                cause="this version knows no targets yet: it counts operations, not cycles",
                remedy="leave out --target",
            )
        )
    sheet = load_sheet(name, settings, findings)
    report = None if sheet is None else findings.attempt(sheet.budget)
    if report is None or findings.errors:
        finish(findings.found, json)
        raise typer.Exit(BAD_INPUT)
    findings.attempt(report.raise_if_over)
    if json:
        finish(findings.found, json, report.to_dict())
        return
    from saoflow.printing import print_budget

    print_budget(report, console(), depth)
    tell(findings.found)
    if report.over:
        raise typer.Exit(exit_code(findings.found))
