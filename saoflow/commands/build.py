"""The command ``saoflow build``."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from saoflow.commands.shell import BAD_INPUT, Findings, Json, Set, SheetName, finish, load_sheet, one_of


def build(
    name: SheetName,
    folder: Annotated[
        str, typer.Option("-o", "--output", metavar="DIR", help="Folder to write, new or empty.", show_default=False)
    ],
    real: Annotated[int, typer.Option("--real", metavar="BITS", help="Reals of 64 or 32 bits.")] = 64,
    settings: Set = None,
    recording: Annotated[
        str | None,
        typer.Option(
            "--frames-from", metavar="IN", help="Recording whose first frames the self-check runs.", show_default=False
        ),
    ] = None,
    json: Json = False,
) -> None:
    """C99 of a sheet: source, header, self-check, README, and the trace between C and sheets.

    Example: saoflow build cmhe_fte -o out
    """
    from saoflow.codegen import build as building
    from saoflow.codegen.self_check import frame_count
    from saoflow.recordings import read_frames

    findings = Findings()
    findings.attempt(lambda: building.check_folder(Path(folder)))
    if real not in (64, 32):
        findings.add(one_of("--real", str(real), ("64", "32")))
    sheet = load_sheet(name, settings, findings)
    inputs = None
    if sheet is not None and recording is not None:
        ports = sheet.input_types
        frames = findings.attempt(lambda: read_frames(recording, ports))
        if frames is not None:
            most = frame_count(sheet.frame_program)
            inputs = {port: array[:most] for port, array in frames.inputs.items()}
    if sheet is None or findings.errors:
        finish(findings.found, json)
        raise typer.Exit(BAD_INPUT)
    ready = sheet
    built = findings.attempt(lambda: building.build(ready, folder, real, inputs))
    finish(findings.found, json, None if built is None else built.to_dict())
    if built is not None and not json:
        print(built)
