"""The command ``saoflow fmt``."""

from __future__ import annotations

import errno
from pathlib import Path
from typing import Annotated

import typer

from saoflow.commands.shell import FAILED, Findings, Json, finish
from saoflow.diagnosis import refusal


def fmt(
    files: Annotated[
        list[str], typer.Argument(metavar="FILE...", help="YAML files of sheets or campaigns.", show_default=False)
    ],
    check: Annotated[bool, typer.Option("--check", help="Change nothing; exit 1 if something would change.")] = False,
    json: Json = False,
) -> None:
    """Format sheets: order of keys, indentation, width, aligned comments. Meaning and comments stay.

    A file with mistakes of reading is refused with the diagnoses of `saoflow check`, and stays as it is.

    Example: saoflow fmt my_sheet.yaml

    Example: saoflow fmt --check sheets/*.yaml
    """
    findings = Findings()
    changed = {name: findings.attempt(lambda name=name: _format(name, check)) for name in files}  # type: ignore[misc]
    for name, was in changed.items():
        if was and not json:
            print(f"{name}: {'would change' if check else 'formatted'}")
    finish(findings.found, json, {"files": [{"file": name, "changed": was} for name, was in changed.items()]})
    if check and any(changed.values()):
        raise typer.Exit(FAILED)


def _format(name: str, check: bool) -> bool:
    """Whether the file changes, or would. Raises DiagnosisError."""
    from saoflow.authoring.formatting import formatted
    from saoflow.diagrams.reader import file_text
    from saoflow.whole_file import remedy_of, write_whole

    result = formatted(file_text(name), name).encode()
    if result == Path(name).read_bytes():
        return False
    if not check:
        try:
            path = Path(name).resolve()
            mode = path.stat().st_mode
            if not mode & 0o222:
                raise PermissionError(errno.EACCES, "it is read-only")
            write_whole(path, result)
            path.chmod(mode)
        except OSError as error:
            raise refusal(
                "E601",
                f"{name}: cannot be written",
                cause=error.strerror or str(error),
                remedy=remedy_of(error, "make the file and its folder writable"),
            ) from None
    return True
