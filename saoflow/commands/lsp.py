"""The command ``saoflow lsp``."""

from __future__ import annotations

import typer

from saoflow.commands.shell import BAD_INPUT, tell
from saoflow.diagnosis import Diagnosis


def lsp() -> None:
    """Run the language server for editors, over standard input and output (docs/editors.md says how to set them up).

    Example: saoflow lsp
    """
    try:
        from saoflow.lsp.server import server
    except ImportError:
        tell(
            [
                Diagnosis(
                    "E605",
                    "the language server needs pygls",
                    cause="it is not installed",
                    remedy="pip install 'saoflow[lsp]'",
                )
            ]
        )
        raise typer.Exit(BAD_INPUT) from None
    server.start_io()
