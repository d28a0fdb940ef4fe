"""Keeps the numbers of a document true: ``python -m verification.demo.readme [--measured] [README.md]``.

A document says where its numbers come from, in comments that no reader sees:

    <!-- file: NAME -->        the fenced block below is this file
    <!-- numbers: COMMAND -->  the fenced block (or table, if there is none) below is what the command prints, the same on every machine
    <!-- measured: COMMAND --> likewise, but it depends on the machine: renewed only with --measured

Commands run in a folder of their own, with the files of the document in it, one after the other. ``| head -N`` and
``| tail -N`` shorten what is printed; ``2>&1`` at the end shows a failure with its messages.
"""

from __future__ import annotations

import argparse
import os
import re
import shlex
import subprocess
import sys
import tempfile
from collections.abc import Collection, Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

MARKER = re.compile(r"^<!-- (file|numbers|measured): (.*?) -->$")


@dataclass(frozen=True)
class Block:
    """A marked block: ``kind`` file, numbers or measured; ``content`` are lines ``first`` to ``last - 1``."""

    kind: str
    what: str
    first: int
    last: int
    content: str


def blocks(text: str) -> Iterator[Block]:
    """The marked blocks of a document, in order. Raises ValueError for a marker without a block below it."""
    lines = text.split("\n")
    for i, line in enumerate(lines):
        match = MARKER.match(line)
        if match is None:
            continue
        first = i + 1
        fenced = first < len(lines) and lines[first].startswith("```")
        first += fenced
        last = first
        while last < len(lines) and (not lines[last].startswith("```") if fenced else lines[last].strip()):
            last += 1
        if last == len(lines) and fenced:
            raise ValueError(f"line {i + 1}: no block below {line}")
        yield Block(match[1], match[2], first, last, "\n".join(lines[first:last]))


def output(command: str, folder: Path) -> str:
    """What a command prints. Raises RuntimeError, with what it says, if it fails and its failure is not what is shown."""
    failing = command.endswith("2>&1")
    text, *filters = (part.strip() for part in command.removesuffix("2>&1").split("|"))
    program, *arguments = shlex.split(text)
    start = {"saoflow": [sys.executable, "-m", "saoflow.cli"], "python": [sys.executable], "grep": ["grep"]}[program]
    root = Path(__file__).parents[2]
    arguments = [str(root / a) if a.startswith(("benchmarks/", "docs/")) else a for a in arguments]
    environment = {**os.environ, "COLUMNS": "100", "PYTHONIOENCODING": "utf-8"}
    done = subprocess.run([*start, *arguments], cwd=folder, capture_output=True, encoding="utf-8", env=environment)
    if bool(done.returncode) != failing:
        raise RuntimeError(f"{command}: exit code {done.returncode}\n{done.stderr}")
    return shortened(done.stdout + done.stderr if failing else done.stdout, filters)


def shortened(printed: str, filters: Iterable[str]) -> str:
    """What was printed, as a page shows it: without spaces at the ends of lines, through filters (``head -5``)."""
    lines = [line.rstrip() for line in printed.strip("\n").split("\n")]
    for name, count in (one.split() for one in filters):
        lines = lines[: abs(int(count))] if name == "head" else lines[-abs(int(count)) :]
    return "\n".join(lines)


def renewed(text: str, kinds: Collection[str] = ("numbers",), only: str = "") -> str:
    """The document with what its commands print now; ``only``: commands that begin so."""
    lines = text.split("\n")
    found = list(blocks(text))
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for block in found:
            if block.kind == "file":
                (folder / block.what).write_text(block.content + "\n", encoding="utf-8")
        replaced = []
        for block in found:
            if block.kind in kinds and block.what.startswith(only):
                replaced.append((block, output(block.what, folder).split("\n")))
    for block, new in reversed(replaced):
        lines[block.first : block.last] = new
    return "\n".join(lines)


def main() -> None:
    """Renew a document in place."""
    parser = argparse.ArgumentParser(description="Renew the numbers of a document from the commands it names.")
    parser.add_argument("document", nargs="?", default="README.md")
    parser.add_argument("--measured", action="store_true", help="those too that depend on the machine")
    arguments = parser.parse_args()
    path = Path(arguments.document)
    kinds = ("numbers", "measured") if arguments.measured else ("numbers",)
    path.write_text(renewed(path.read_text(encoding="utf-8"), kinds), encoding="utf-8")


if __name__ == "__main__":
    main()
