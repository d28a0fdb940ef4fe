"""The commands that a page shows: at a prompt, in its text, and above its marked blocks."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

from verification.demo.readme import Block, blocks

ROOT = Path(__file__).resolve().parents[2]
PROGRAM = re.compile(r"(?:[A-Z_]+=(?:\"[^\"]*\"|\S+) )?(saoflow|python|make|pip) [\w'\"/.-]")
"""How a command begins; a variable of the environment may stand before it."""
COMPLETE = ("demo", "lsp", "schema", "symbols")
"""Commands of saoflow that need no argument. `saoflow check` alone, in a text, is the name of a command."""
SHELLS = ("", "console", "sh", "bash", "shell")
"""Languages of fenced blocks in which commands are typed."""
SLOW = "python -m verification.results"
"""Numbers that take too long for `test_pages.py` and `demo/test_readme.py`, which hold the other blocks of numbers."""


@dataclass(frozen=True)
class Answer:
    """What a page says that a command prints: the block, and the filters (``head -5``) that it was shortened with."""

    content: str
    filters: tuple[str, ...]


@dataclass(frozen=True)
class Shown:
    """One command of a page: ``page`` as a path from the root, ``line`` from 1, ``command`` in one line.

    ``typed``: it stands in a block, so what is typed below it may need what it wrote.
    """

    page: str
    line: int
    command: str
    typed: bool
    answers: tuple[Answer, ...] = ()


def pages() -> list[Path]:
    """Every page: README.md and all of docs/."""
    return [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]


def page_name(page: Path) -> str:
    """A page's path from the root; the name alone of one that lies elsewhere."""
    path = page.resolve()
    return path.relative_to(ROOT).as_posix() if path.is_relative_to(ROOT) else path.name


def shown_commands(page: Path) -> list[Shown]:
    """What a page shows, in order, each command once, those left out that tests of marked blocks run and compare."""
    text = page.read_text(encoding="utf-8")
    marked = list(blocks(text))
    compared = {_typed_at(b) for b in marked if b.kind == "numbers" and not b.what.startswith(SLOW)}
    found: dict[str, Shown] = {}
    for one in sorted((*_marked(marked), *_typed(text, marked), *_named(text, marked)), key=lambda one: one.line):
        if one.command in compared:
            continue
        before = found.setdefault(one.command, replace(one, page=page_name(page)))
        if before.answers != one.answers:
            found[one.command] = replace(before, answers=before.answers + one.answers)
    return list(found.values())


def _typed_at(block: Block) -> str:
    return block.what.removesuffix("2>&1").split("|")[0].strip()


def _marked(marked: list[Block]) -> Iterator[Shown]:
    """Commands above blocks; and the programs among the page's files, run or, if they are modules, imported."""
    for block in marked:
        if block.kind == "file":
            if block.what.endswith(".py"):
                yield Shown("", block.first, f"python {block.what}", True)
            continue
        filters = tuple(part.strip() for part in block.what.split("|")[1:])
        answers = (Answer(block.content, filters),) if block.kind == "numbers" else ()
        yield Shown("", block.first, _typed_at(block), True, answers)


def _typed(text: str, marked: list[Block]) -> Iterator[Shown]:
    """Lines of fenced and indented blocks; parts of a line joined by ``&&`` apart, remarks left out."""
    covered = {k for block in marked for k in range(block.first, block.last)}
    language: str | None = None
    for k, line in enumerate(text.split("\n")):
        content = line.strip()
        if content.startswith("```"):
            language = content.strip("`").split(" ")[0] if language is None else None
        elif k not in covered and (language in SHELLS or (language is None and line.startswith("    "))):
            if language == "console" and not content.startswith("$ "):
                continue  # an answer
            typed = re.split(r"\s#\s", content.removeprefix("$ "))[0]
            for part in typed.split("&&"):
                if PROGRAM.match(part.strip()):
                    yield Shown("", k + 1, part.strip(), True)


def _named(text: str, marked: list[Block]) -> Iterator[Shown]:
    """Whole commands in running text, between backticks; a span may go on in the next line."""
    lines = text.split("\n")
    for block in marked:
        lines[block.first : block.last] = [""] * (block.last - block.first)
    fenced = False
    for k, line in enumerate(lines):
        fence = line.strip().startswith("```")
        if fenced or fence or line.startswith(("    ", "<!--")):
            lines[k] = ""
        fenced ^= fence
    text = "\n".join(lines)
    for span in re.finditer(r"`([^`\n]+(?:\n[^`\n]+)?)`", text):
        command = " ".join(span[1].split())
        if PROGRAM.match(command) and not _is_a_name(command):
            yield Shown("", text.count("\n", 0, span.start()) + 1, command, False)


def _is_a_name(command: str) -> bool:
    words = command.split()
    return words[0] == "saoflow" and len(words) == 2 and words[1] not in COMPLETE
