"""The command ``saoflow new``."""

from __future__ import annotations

from typing import Annotated

import typer

from saoflow.commands.shell import Findings, Json, finish


def new(
    name: Annotated[str, typer.Argument(metavar="NAME", help="Of the sheet, and of its files.", show_default=False)],
    folder: Annotated[str, typer.Option("-o", "--output", metavar="FOLDER", help="Where the files go.")] = ".",
    kind: Annotated[str, typer.Option("--kind", metavar="KIND", help="sheet, estimator or campaign.")] = "sheet",
    json: Json = False,
) -> None:
    """Write a first sheet that runs, with comments and a recording; an estimator; or a campaign. Overwrites nothing.

    Example: saoflow new my_filter --kind estimator
    """
    from saoflow.authoring.first import write_first

    findings = Findings()
    done = findings.attempt(lambda: write_first(name, folder, kind))
    finish(findings.found, json, None if done is None else {"files": list(done.files), "commands": list(done.commands)})
    if json or done is None:
        return
    print(f"written: {', '.join(done.files)}\nnext:")
    print("\n".join(f"  {command}" for command in done.commands))
