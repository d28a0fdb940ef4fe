"""The command ``saoflow schema``."""

from __future__ import annotations

from typing import Annotated

import typer

from saoflow.commands.shell import Findings, finish
from saoflow.diagnosis import refusal


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

    findings = Findings()
    text = findings.attempt(lambda: schema_text(name))
    if text is not None and output is not None:
        findings.attempt(lambda: _write(output, text))
    elif text is not None:
        print(text, end="")
    finish(findings.found, False)


def _write(output: str, text: str) -> None:
    from saoflow.whole_file import write_whole

    try:
        write_whole(output, text.encode())
    except OSError as error:
        cause = error.strerror or str(error)
        raise refusal("E601", f"{output} cannot be written", cause=cause, remedy="name a file in a folder that exists") from None
