"""Runs every command that the pages show: ``python -m verification.documentation.commands [PAGE...] [--whole]``.

A page's commands are typed in order into a fresh folder that holds the page's files (its blocks marked ``file:``), a copy of
docs/, and the benchmarks; so nothing is written into the checkout. Each must end with exit code 0, or the one that the page
states, without a traceback, and leave the files that it is told to write. Left out are commands above marked blocks, which
other tests run and compare. Long commands are run in part, ``--whole`` as they stand; which, and why, is in
``command_table.py``.
"""

from __future__ import annotations

import argparse
import itertools
import os
import re
import resource
import shlex
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from verification.demo.readme import Block, blocks, shortened
from verification.documentation import command_table as table
from verification.documentation.shown_commands import ROOT, Shown, page_name, pages, shown_commands

PATIENCE = 300.0
"""[s] that a command may take where it is not run whole."""


@dataclass(frozen=True)
class Step:
    """What is run for one command that a page shows; ``left_out`` says why nothing is."""

    shown: Shown
    runs: tuple[str, ...]
    ends: int = 0
    left_out: str = ""

    @property
    def as_shown(self) -> bool:
        """The command is run as it stands, so its print can be compared."""
        return self.runs == (self.shown.command,)


@dataclass(frozen=True)
class Outcome:
    """What became of a step: ``seconds`` of processors, and what is wrong; "" if nothing is."""

    step: Step
    seconds: float
    problem: str = ""


# ---------------------------------------------------------------- what is run


def steps(page: Path, whole: bool = False, among: Sequence[Path] | None = None) -> list[Step]:
    """The steps of a page. Of steps that run the same, on this page or others of ``among``, one is left: the first that is
    typed in a block, or else the first; and those that write what a later step of their page reads."""
    every = [_step(s, whole) for other in (pages() if among is None else among) for s in shown_commands(other)]
    chosen: dict[tuple[str, ...], Step] = {}
    for step in every:
        first = chosen.setdefault(step.runs, step)
        if step.shown.typed and not first.shown.typed:
            chosen[step.runs] = step
    mine = [_step(shown, whole) for shown in shown_commands(page)]
    return [
        step
        for k, step in enumerate(mine)
        if step.left_out or chosen[step.runs] == step or any(_reads(later, step) for later in mine[k + 1 :])
    ]


def _reads(later: Step, step: Step) -> bool:
    return any(path in command for run in step.runs for path in promised(run) for command in later.runs)


def _step(shown: Shown, whole: bool) -> Step:
    command = shown.command
    for held in table.HELD:
        if held.page == shown.page and shown.typed:
            return Step(shown, (), left_out=f"run by {held.test}")
    for missing in table.NEEDS:
        if missing.command == command and shutil.which(missing.program) is None:
            return Step(shown, (), left_out=f"{missing.program} is not installed")
    for elsewhere in table.ELSEWHERE:
        if elsewhere.command == command and elsewhere.page in ("", shown.page) and (elsewhere.always or not whole):
            return Step(shown, (), left_out=f"run by {elsewhere.where}: {elsewhere.why}")
    for never in table.NOT_HERE:
        if never.command == command:
            return Step(shown, (), left_out=never.why)
    for filled in table.FILLED:
        if filled.command == command:
            return Step(shown, filled.runs, filled.ends)
    for short in table.SHORT:
        if short.command == command and not whole:
            return Step(shown, (short.run,))
    return Step(shown, (command,), next((e.code for e in table.ENDS if e.command == command), 0))


def entries() -> list[table.Entry]:
    """All of the table that belongs to a command."""
    return [*table.FILLED, *table.SHORT, *table.ELSEWHERE, *table.NOT_HERE, *table.ENDS, *table.NEEDS]


# ---------------------------------------------------------------- the folder


def prepare(folder: Path, page: Path, whole: bool = False) -> None:
    """Make a fresh folder what a page supposes: the checkout around it, its files, and the programs on the path."""
    shutil.copytree(ROOT / "docs", folder / "docs")
    for name in ("Makefile", "pyproject.toml", "README.md", "LICENSE", "mkdocs.yml"):
        shutil.copy(ROOT / name, folder)
    (folder / "benchmarks").symlink_to(ROOT / "benchmarks")
    starts = {"saoflow": "-m saoflow.cli", "python": "", "pip": "-m pip --disable-pip-version-check"}
    for place in (folder / ".bin", folder / ".venv" / "bin"):
        place.mkdir(parents=True)
        for name, start in starts.items():
            (place / name).write_text(f'#!/bin/sh\nexec "{sys.executable}" {start} "$@"\n', encoding="utf-8")
            (place / name).chmod(0o755)
    for name in (".installed", ".installed-test"):
        (folder / ".venv" / name).touch()
    for block in blocks(page.read_text(encoding="utf-8")):
        if block.kind == "file":
            (folder / block.what).write_text(block.content + "\n", encoding="utf-8")
    for supposed in table.SUPPOSED:
        if supposed.page == page_name(page):
            (folder / supposed.name).write_text(supposed.content, encoding="utf-8")
    if whole:
        shutil.rmtree(folder / ".venv")
        for package in ("saoflow", "verification", "tests"):
            shutil.copytree(ROOT / package, folder / package, ignore=shutil.ignore_patterns("__pycache__"))


def _few(command: str, folder: Path) -> None:
    for match in table.FEW.finditer(command):
        path = folder / match[0]
        path.parent.mkdir(exist_ok=True)
        path.write_text(table.few_runs(match[1]), encoding="utf-8")


def _programs(page: Path) -> list[Block]:
    """Programs of the page that blocks of numbers run and compare elsewhere: they write what later commands read."""
    found = list(blocks(page.read_text(encoding="utf-8")))
    own = {block.what for block in found if block.kind == "file"}
    return [b for b in found if b.kind == "numbers" and b.what.removeprefix("python ") in own]


# ---------------------------------------------------------------- running


def run_page(page: Path, whole: bool = False, among: Sequence[Path] | None = None) -> Iterator[Outcome]:
    """Run a page's commands, one after the other, in a folder that is removed at the end."""
    todo = steps(page, whole, among)
    if not any(step.runs for step in todo):
        yield from (Outcome(step, 0.0) for step in todo)
        return
    with tempfile.TemporaryDirectory(prefix="saoflow-page-") as name:
        folder = Path(name)
        prepare(folder, page, whole)
        programs = _programs(page)
        for step in todo:
            while programs and programs[0].first < step.shown.line:
                run(programs.pop(0).what, folder)
            start = _spent()
            problem = "" if step.left_out else run_step(step, folder, None if whole else PATIENCE)
            yield Outcome(step, _spent() - start, problem)


def run_step(step: Step, folder: Path, patience: float | None = PATIENCE) -> str:
    """Run what stands for one command; what is wrong with it, or ""."""
    for k, command in enumerate(step.runs):
        started = time.time_ns()
        _few(command, folder)
        try:
            done = run(command, folder, patience)
        except subprocess.TimeoutExpired:
            return f"{command}: not done after {patience:g} s; shorten it in verification/documentation/command_table.py"
        code = step.ends if k == len(step.runs) - 1 else 0
        said = f"{done.stdout[-2000:]}{done.stderr[-2000:]}"
        if done.returncode != code:
            return f"{command}: exit code {done.returncode}, not {code}\n{said}"
        if "Traceback (most recent call last)" in done.stdout + done.stderr:
            return f"{command}: a traceback\n{said}"
        if "does not provide the extra" in done.stderr:
            return f"{command}: no such extra\n{said}"
        for path in promised(command):
            if not _is_new(folder / path, started):
                return f"{command}: {path} was not written\n{said}"
        for answer in step.shown.answers if step.as_shown else ():
            if shortened(done.stdout, answer.filters) != answer.content:
                return f"{command}: the page shows another answer\n{said}"
    return ""


def run(command: str, folder: Path, patience: float | None = PATIENCE) -> subprocess.CompletedProcess[str]:
    """Type one command in a folder. Raises TimeoutExpired."""
    environment = {
        **{name: value for name, value in os.environ.items() if not name.startswith(("MAKE", "MFLAGS"))},
        "PATH": os.pathsep.join((str(folder / ".bin"), str(Path(sys.executable).parent), os.environ.get("PATH", ""))),
        "COLUMNS": "100",
        "PYTHONIOENCODING": "utf-8",
    }
    return subprocess.run(
        ["/bin/sh", "-c", command],
        cwd=folder,
        env=environment,
        stdin=subprocess.DEVNULL,
        capture_output=True,
        encoding="utf-8",
        timeout=patience,
        check=False,
    )


def promised(command: str) -> list[str]:
    """The files and folders that a command is told to write."""
    words = [word for word in shlex.split(command) if not re.match(r"[A-Z_]+=", word)]
    found = [b for a, b in itertools.pairwise(words) if a in ("-o", "--output", "--report", "--runs")]
    if found or words[0] != "saoflow":
        return found
    rest = [word for word in words[2:] if not word.startswith("-")]
    match words[1]:
        case "demo":
            return ["out/report.html", "out/estimates.csv", "out/recording.csv"]
        case "view" if "--help" not in words:
            return [f"{Path(rest[0]).stem}.{'svg' if '--svg' in words else 'html'}"]
        case "fmu":
            return [f"{Path(rest[0]).stem}.fmu"]
        case "new":
            return [f"{rest[0]}.yaml"]
    return []


def _is_new(path: Path, started: int) -> bool:
    """The file, or something in the folder, was written since then; with room for a coarse clock of the file system."""
    files = [path] if path.is_file() else [p for p in path.rglob("*") if p.is_file()] if path.is_dir() else []
    return any(file.stat().st_size and file.stat().st_mtime_ns >= started - 50_000_000 for file in files)


def _spent() -> float:
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    return usage.ru_utime + usage.ru_stime


def _state_of_the_checkout() -> str:
    done = subprocess.run(["git", "status", "--porcelain"], cwd=ROOT, capture_output=True, encoding="utf-8", check=False)
    return done.stdout


def main(arguments: Sequence[str] | None = None) -> int:
    """Run pages, a line a command. Exit code 1 if something is wrong with one, or with the checkout afterwards."""
    parser = argparse.ArgumentParser(prog="python -m verification.documentation.commands", description=__doc__)
    parser.add_argument("pages", nargs="*", type=Path, metavar="PAGE", help="these; else every page")
    parser.add_argument("--whole", action="store_true", help="long commands as they stand: hours")
    parser.add_argument("--list", action="store_true", help="say what would be run, and end")
    given = parser.parse_args(arguments)
    chosen: list[Path] = given.pages or pages()
    for page in chosen:
        if not page.is_file():
            parser.error(f"{page} is no page")
    before, wrong = _state_of_the_checkout(), 0
    for page in chosen:
        done = (Outcome(s, 0.0) for s in steps(page, given.whole, chosen)) if given.list else run_page(page, given.whole, chosen)
        for outcome in done:
            print(_line(outcome, given.list), flush=True)
            if outcome.problem:
                wrong += 1
                print(outcome.problem, file=sys.stderr, flush=True)
    if not given.list and _state_of_the_checkout() != before:
        print("the checkout is not what it was before", file=sys.stderr)
        wrong += 1
    return 1 if wrong else 0


def _line(outcome: Outcome, listed: bool) -> str:
    step = outcome.step
    mark = "-" if step.left_out else "FAILED" if outcome.problem else "." if listed else f"{outcome.seconds:.1f} s"
    how = f"  ({step.left_out})" if step.left_out else "" if step.as_shown else f"  as {'; '.join(step.runs)}"
    return f"{step.shown.page}:{step.shown.line:<5} {mark:<7} {step.shown.command}{how}"


if __name__ == "__main__":
    sys.exit(main())
