"""The command ``saoflow show``."""

from __future__ import annotations

from typing import Annotated

import typer

from saoflow.commands.shell import BAD_INPUT, Findings, Json, Set, SheetName, finish, load_sheet, one_of


def show(
    name: SheetName,
    stage: Annotated[
        str, typer.Option("--stage", metavar="STAGE", help="sheet, netlist, schedule, program or python.")
    ] = "sheet",
    settings: Set = None,
    json: Json = False,
) -> None:
    """Print a sheet as it is after a stage of its way to frames.

    Example: saoflow show my_sheet.yaml --stage program
    """
    from saoflow.pipeline import STAGES

    findings = Findings()
    if stage not in STAGES:
        findings.add(one_of("--stage", stage, STAGES))
    sheet = load_sheet(name, settings, findings)
    if sheet is None or findings.errors:
        finish(findings.found, json)
        raise typer.Exit(BAD_INPUT)
    from saoflow.stage_text import stage_text

    text = findings.attempt(lambda: stage_text(sheet, stage))
    if json:
        finish(findings.found, json, {"sheet": sheet.name, "stage": stage, "text": text})
        return
    finish(findings.found, json)
    print(text)
