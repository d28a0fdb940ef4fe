"""The command ``saoflow schema``."""

from __future__ import annotations

from typing import Annotated

import typer

from saoflow.commands.shell import Findings, finish


def schema(
    name: Annotated[str, typer.Argument(metavar="[KIND]", help="sheet or campaign.")] = "sheet",
    output: Annotated[
        str | None, typer.Option("-o", "--output", metavar="FILE", help="File to write; else it is printed.", show_default=False)
    ] = None,
) -> None:
    """The JSON Schema (draft 2020-12) of sheets or campaigns, for editors that complete and check as you type.

    A file names it in its first line: # yaml-language-server: $schema=sheet.schema.json

    Example: saoflow schema sheet -o sheet.schema.json
    """
    from saoflow.authoring.schema import schema_text
    from saoflow.whole_file import write_text

    findings = Findings()
    text = findings.attempt(lambda: schema_text(name))
    if text is not None and output is not None:
        findings.attempt(lambda: write_text(output, text, "the schema"))
    elif text is not None:
        print(text, end="")
    finish(findings.found, False)
