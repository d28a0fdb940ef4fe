"""``python -m verification.papers [-o docs/papers] [--only 003] [--short]``: the papers' results, made again."""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Sequence
from pathlib import Path

from verification.papers.document import PAPERS, DocumentError, write_document


def main(arguments: Sequence[str] | None = None) -> int:
    """Write the document and its pictures. Exit code 2: nothing can be written there."""
    parser = argparse.ArgumentParser(prog="python -m verification.papers", description=__doc__)
    parser.add_argument("-o", "--output", type=Path, help="the folder to write; docs/papers, with --short out/papers")
    parser.add_argument("--only", action="append", choices=list(PAPERS), default=[], help="this paper; may be repeated")
    parser.add_argument("--short", action="store_true", help="fewer runs: a look, not the numbers")
    given = parser.parse_args(arguments)
    folder: Path = given.output or Path("out/papers" if given.short else "docs/papers")
    above = next(p for p in (folder.resolve(), *folder.resolve().parents) if p.exists())
    if not above.is_dir() or not os.access(above, os.W_OK):
        parser.error(f"{folder} cannot be written: {above} is no folder that you may write to")
    try:
        findings = write_document(folder, given.only, short=given.short, progress=lambda word: print(word, flush=True))
    except (OSError, DocumentError) as problem:
        print(f"{folder}: {problem}", file=sys.stderr)
        return 2
    print(f"{folder / 'README.md'}: {len(findings)} findings")
    return 0


if __name__ == "__main__":
    sys.exit(main())
