"""What ``saoflow check`` found before, if that was nothing wrong: told without reading a sheet, numpy or a parser of options.

A verdict is kept under the content of every file that the sheet may read, of saoflow's code, and of the options; so one that
is found is about exactly what is there now.
"""

from __future__ import annotations

import json as json_text
import os
from collections.abc import Sequence
from contextlib import suppress
from typing import Any

from saoflow.cache import cache_folder
from saoflow.diagrams.content_key import code_fingerprint, digest, readable_sheets
from saoflow.diagrams.shipped import place_of, shipped_sheets

Facts = dict[str, Any]
"""What ``--json`` tells of one sheet."""


def answer(arguments: Sequence[str]) -> int | None:
    """Answer a command line of ``saoflow check`` if all its sheets are known to be without fault; None: it must be run.

    Takes only what needs no parser: names of sheets, ``--json``, and ``--set NAME=VALUE`` in two words.
    """
    names, settings, json = list[str](), list[str](), False
    words = iter(arguments)
    for word in words:
        if word == "--json":
            json = True
        elif word == "--set":
            settings.append(next(words, ""))
        elif word.startswith("-") or not word:
            return None
        else:
            names.append(word)
    if not names:
        return None
    facts = list[Facts]()
    for name in names:
        known = kept(verdict_key(name, settings))
        if known is None:
            return None
        facts.append(known)
    if json:
        print(json_text.dumps({"sheets": facts, "diagnoses": []}, indent=1))
    else:
        print("\n".join(summary(known) for known in facts))
    return 0


def verdict_key(name: str, settings: Sequence[str]) -> str:
    """The name of the verdict on a sheet; empty where none is kept."""
    try:
        place = place_of(name, shipped_sheets())
        files = None if place is None else readable_sheets(place)
        if files is None:
            return ""
        return digest("check", code_fingerprint(), os.getcwd(), name, *settings, "\1", *files)
    except (OSError, ValueError):  # a name that no file can have, a folder that is gone: the reader tells
        return ""


def kept(key: str) -> Facts | None:
    """The verdict of that name; None if there is none."""
    folder = cache_folder()
    content = None if folder.problem or not key else folder.read(f"{key}.check")
    if content is None:
        return None
    facts: Facts = json_text.loads(content)
    return facts


def keep(key: str, facts: Facts) -> None:
    """Keep that nothing is wrong; where that cannot be, the sheet is checked anew next time."""
    folder = cache_folder()
    if key and not folder.problem:
        with suppress(OSError):
            folder.write(f"{key}.check", json_text.dumps(facts).encode())


def summary(facts: Facts) -> str:
    """One line about a sheet."""
    found = f"{_many(facts['errors'], 'error')}" + (
        f", {_many(facts['warnings'], 'warning')}" if facts["warnings"] else ""
    )
    if "blocks" not in facts:
        return f"{facts['sheet']}: {found}"
    return f"{facts['sheet']}: {_many(facts['blocks'], 'block')}, {_many(facts['sub_sheets'], 'sub-sheet')}, {found}"


def _many(count: int, word: str) -> str:
    return f"{count} {word}{'' if count == 1 else 's'}"
