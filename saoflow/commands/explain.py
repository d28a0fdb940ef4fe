"""The command ``saoflow explain``."""

from __future__ import annotations

import re
import textwrap
from collections.abc import Iterator
from typing import TYPE_CHECKING, Annotated

import typer

from saoflow.codes import CODES
from saoflow.commands.shell import Findings, Json, finish
from saoflow.diagnosis import Diagnosis, did_you_mean

if TYPE_CHECKING:
    from saoflow.authoring.explanation import Explanation

WIDTH = 100


def explain(
    code: Annotated[
        str | None, typer.Argument(metavar="CODE", help="A code, as in error[E211]; else all.", show_default=False)
    ] = None,
    json: Json = False,
) -> None:
    """What a diagnosis means: its cause, an example that gives it, and the remedy.

    Example: saoflow explain E211
    """
    from saoflow.authoring.explanation import explanation, explanations

    if code is None:
        if json:
            finish([], True, {"explanations": [entry.to_dict() for entry in explanations()]})
            return
        for known, title in CODES.items():
            print(f"{known}  {title}")
        print("\n`saoflow explain CODE` shows cause, example and remedy of one of them.")
        return
    bare = re.sub(r"^(error|warning)?\[?(\w+)\]?$", r"\2", code.strip()).upper()
    if bare not in CODES:
        findings = Findings()
        findings.add(
            Diagnosis(
                "E603",
                f"there is no diagnosis `{code}`",
                cause=f"codes are {next(iter(CODES))} to {list(CODES)[-1]}, with gaps",
                remedy=did_you_mean(bare, CODES) or "`saoflow explain` lists all",
            )
        )
        finish(findings.found, json)
        return
    entry = explanation(bare)
    if json:
        finish([], True, entry.to_dict())
    else:
        print("\n".join(_text(entry)))


def _text(entry: Explanation) -> Iterator[str]:
    from saoflow.authoring.catalogue import LONGEST, shown

    yield f"{entry.severity}[{entry.code}]: {entry.title}"
    yield ""
    yield from textwrap.wrap(entry.cause, WIDTH)
    yield ""
    if entry.how:
        yield from textwrap.wrap(entry.how, WIDTH)
    else:
        yield f"Example{f', without {entry.without}' if entry.without else ''}:"
        yield ""
    for file in entry.files:
        yield f"    {file.name}"
        yield from (f"        {line}".rstrip() for line in shown(file.text))
        yield ""
    yield from (f"    $ {command}" for command in entry.commands)
    yield from (f"    {line}".rstrip() for line in (shown(entry.message, LONGEST) if entry.commands else ()))
    yield ""
    yield from textwrap.wrap(f"Remedy: {entry.remedy}", WIDTH, subsequent_indent="  ")
