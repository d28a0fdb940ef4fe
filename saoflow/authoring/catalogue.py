"""The catalogue of all diagnoses as a page, docs/diagnoses.md, and what their examples say.

``python -m saoflow.authoring.catalogue`` runs every example, and writes what it says beside it, and the page.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from saoflow.authoring.explanation import EXAMPLES, Explanation, explanation, explanations
from saoflow.authoring.run_example import run_example
from saoflow.codes import CODES
from saoflow.whole_file import write_whole

PAGE = Path(__file__).parents[2] / "docs" / "diagnoses.md"
LONGEST = 18
"""Lines of a message that are shown."""
GROUPS = {
    "E1": "Reading text",
    "E2": "Elaboration: names, parameters, shapes, types, units, profiles",
    "E3": "Order and lowering",
    "E4": "Budgets",
    "E5": "Recordings and runs",
    "E6": "Commands and files",
    "E7": "Flights, sensors and their faults",
    "E8": "Campaigns and comparisons",
}
"""Titles of the parts of the page, by the code's first two characters; warnings stand with the errors of their number."""
_HEAD = """\
# What each diagnosis means

Every diagnosis of saoflow has a code that does not change. `saoflow explain CODE` shows one of these entries. The messages
are those that the examples give; page and messages are made by `python -m saoflow.authoring.catalogue`, and held against
runs by `tests/authoring/test_explain.py`.
"""


def page() -> str:
    """The page, from the explanations as they are kept."""
    parts = [_HEAD, *_contents()]
    group = ""
    for entry in explanations():
        if _group(entry.code) != group:
            group = _group(entry.code)
            parts.append(f"## {group}\n")
        parts.append(_entry(entry))
    return "\n".join(parts)


def _group(code: str) -> str:
    return GROUPS.get(f"E{code[1]}", "Others")


def _contents() -> Iterator[str]:
    yield "| code | says |\n|---|---|"
    yield from (f"| [{code}](#{code.lower()}) | {title} |" for code, title in CODES.items())
    yield ""


def _entry(entry: Explanation) -> str:
    lines = [f"### {entry.code}", "", f"*{entry.title[:1].upper()}{entry.title[1:]}.* {entry.cause}", ""]
    for file in entry.files:
        lines += [f"`{file.name}`", "", f"```{file.name.rpartition('.')[2]}", *shown(file.text), "```", ""]
    if entry.commands:
        lines += ["```", *(f"$ {command}{_where(entry)}" for command in entry.commands), *shown(entry.message, LONGEST), "```"]
    else:
        lines += [entry.how]
    return "\n".join([*lines, "", f"**Remedy.** {entry.remedy}", ""])


def _where(entry: Explanation) -> str:
    return f"    # without {entry.without}" if entry.without else ""


def shown(text: str, most: int = 0) -> list[str]:
    """The lines of a file or message, ``most`` of them if it is above 0; characters that cannot be shown as escapes."""
    lines = text.rstrip("\n").split("\n")
    if most and len(lines) > most:
        lines = [*lines[:most], f"... and {len(lines) - most} lines more"]
    return ["".join(c if c.isprintable() else f"\\x{ord(c):02x}" for c in line) for line in lines]


def main() -> None:
    """Run all examples, and write what they say, and the page."""
    for code in CODES:
        entry = explanation(code)
        if entry.commands:
            write_whole(EXAMPLES / f"{code}.txt", (run_example(entry) + "\n").encode())
    explanation.cache_clear()
    write_whole(PAGE, page().encode())


if __name__ == "__main__":
    main()
