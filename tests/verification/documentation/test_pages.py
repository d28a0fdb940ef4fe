"""The pages of docs/: their blocks are what the commands print, and what they name exists.

Blocks from ``python -m verification.results...`` take seconds to minutes; they are renewed by hand, ``python -m
verification.demo.readme docs/multirate.md``, and ``tests/verification/results`` holds what they claim. What is printed in
docs/diagnoses.md is held by ``tests/authoring/test_explain.py``, in docs/new_symbol.md by ``test_new_symbol.py``.
Commands without such a block are run by ``test_commands.py``; here they are only known to exist.
"""

from __future__ import annotations

import contextlib
import importlib.util
import io
import re
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import pytest

from saoflow import cli
from verification.demo.readme import blocks, output

ROOT = Path(__file__).parents[3]
DOCS = ROOT / "docs"
PAGES = sorted(DOCS.glob("*.md"))
SLOW = "python -m verification.results"
TO_WRITE = {"saoflow/blocks/deadzone.py"}
"""Files that a page tells its reader to write."""
MADE = ("symbols.md", "library.md", "flagship.md", "index.md")
"""Pages that are made when the site is built (``verification/documentation/reference.py``)."""


def text_of(page: Path) -> str:
    return page.read_text(encoding="utf-8")


def with_quick_numbers() -> list[Path]:
    return [p for p in PAGES if any(b.kind == "numbers" and not b.what.startswith(SLOW) for b in blocks(text_of(p)))]


@pytest.mark.parametrize("page", with_quick_numbers(), ids=lambda page: page.stem)
def test_blocks_are_what_the_commands_print(page: Path, tmp_path: Path) -> None:
    found = list(blocks(text_of(page)))
    for block in found:
        if block.kind == "file":
            (tmp_path / block.what).write_text(block.content + "\n", encoding="utf-8")
    for block in found:  # in order: one may need what another wrote
        if block.kind == "numbers" and not block.what.startswith(SLOW):
            shown = output(block.what, tmp_path)
            assert shown == block.content, f"{block.what}: renew it, python -m verification.demo.readme docs/{page.name}"


def test_the_pages_whose_examples_run_are_found() -> None:
    assert {"tutorial", "language", "limits"} <= {page.stem for page in with_quick_numbers()}


# ---------------------------------------------------------------- commands


def lines_of_code(text: str) -> Iterator[str]:
    """Lines of fenced and indented blocks, ``$`` in front of them or not."""
    fenced = False
    for line in text.split("\n"):
        if line.lstrip().startswith("```"):
            fenced = not fenced
        elif fenced or line.startswith("    "):
            yield line.strip().removeprefix("$ ")


def commands_in(page: Path) -> list[str]:
    """What is typed at a prompt: ``saoflow COMMAND ...``, without the remark behind it, parts of a line apart."""
    parts = [part.strip() for line in lines_of_code(text_of(page)) for part in re.split(r"&&|\||\s#", line)]
    return [part for part in parts if re.match(r"saoflow [a-z]+( |$)", part) and not part.startswith("saoflow (")]


@cache
def help_of(*command: str) -> str:
    with contextlib.redirect_stdout(io.StringIO()) as printed, contextlib.suppress(SystemExit):
        cli.run([*command, "--help"])
    return printed.getvalue()


@pytest.mark.parametrize("page", [p for p in PAGES if commands_in(p)], ids=lambda page: page.stem)
def test_commands_and_their_options_exist(page: Path) -> None:
    wrong = []
    for line in commands_in(page):
        name = line.split()[1]
        if f"\n  {name} " not in help_of():
            wrong.append(line)
        elif page.stem != "diagnoses":  # which shows wrong options, and is run as a whole
            options = re.findall(r"(?<=\s)--?[a-zA-Z][\w-]*", line)
            wrong += [line for option in options if not re.search(rf"{option}\b", help_of(name))]
    assert wrong == []


def modules_in(page: Path) -> set[str]:
    return set(re.findall(r"python -m ((?:saoflow|verification)[\w.]*)", text_of(page)))


def scripts_in(page: Path) -> set[str]:
    return set(re.findall(r"python (benchmarks/\w+\.py)", text_of(page)))


@pytest.mark.parametrize("page", [p for p in PAGES if modules_in(p) | scripts_in(p)], ids=lambda page: page.stem)
def test_modules_and_scripts_exist(page: Path) -> None:
    assert [name for name in sorted(modules_in(page)) if importlib.util.find_spec(name.rstrip(".")) is None] == []
    assert [name for name in sorted(scripts_in(page)) if not (ROOT / name).is_file()] == []


# ---------------------------------------------------------------- names


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_files_tests_and_pages_that_are_named_exist(page: Path) -> None:
    text = text_of(page)
    named = set(re.findall(r"`((?:docs|tests|verification|saoflow|benchmarks)/[\w./-]*)", text))
    missing = [name for name in sorted(named - TO_WRITE) if not (ROOT / name).exists()]
    for path, test in re.findall(r"`(tests/[\w./]+\.py)::(\w+)`", text):
        if not re.search(rf"^(async )?def {test}\(", text_of(ROOT / path), re.MULTILINE):
            missing.append(f"{path}::{test}")
    for target in re.findall(r"(?<!!)\]\(([^)\s#]+)", text):
        if "://" not in target and target not in MADE and not (page.parent / target).exists():
            missing.append(target)
    assert missing == []


def test_wrong_pages_are_seen(tmp_path: Path) -> None:
    """Each check fails on a page that is wrong in its way."""
    page = tmp_path / "page.md"
    for text, check in (
        ("    saoflow chekc a.yaml\n", test_commands_and_their_options_exist),
        ("```\n$ saoflow check a.yaml --porbe x   # why\n```\n", test_commands_and_their_options_exist),
        ("    python -m verification.nothing\n", test_modules_and_scripts_exist),
        ("    python benchmarks/nothing.py\n", test_modules_and_scripts_exist),
        ("as `saoflow/nothing.py` says\n", test_files_tests_and_pages_that_are_named_exist),
        ("(`tests/test_cli.py::test_nothing`)\n", test_files_tests_and_pages_that_are_named_exist),
        ("see [this](nothing.md#there)\n", test_files_tests_and_pages_that_are_named_exist),
    ):
        page.write_text(text, encoding="utf-8")
        with pytest.raises(AssertionError):
            check(page)
    page.write_text("<!-- numbers: python -c 'print(7)' -->\n```\n8\n```\n", encoding="utf-8")
    with pytest.raises(AssertionError, match="renew it"):
        test_blocks_are_what_the_commands_print(page, tmp_path)
