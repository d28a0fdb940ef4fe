"""``saoflow build``: a folder of C99 with its self-check, its README and its trace, whole or not at all."""

from __future__ import annotations

import contextlib
import hashlib
import json
import os
import shutil
import tempfile
import textwrap
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from saoflow.codegen.frame_operations import Cost, cost_of
from saoflow.codegen.generate import About, Code, generate
from saoflow.codegen.printer import Printed, print_file
from saoflow.codegen.readme import readme
from saoflow.codegen.self_check import exercise, self_check_file
from saoflow.codegen.stack import describe, measured_stack, stack_bound
from saoflow.diagnosis import Diagnosis, DiagnosisError, refusal
from saoflow.diagrams.netlist import SourceLines
from saoflow.pipeline import LoadedSheet
from saoflow.scheduler.budget import BudgetReport
from saoflow.scheduler.simulator import Simulator
from saoflow.whole_file import remedy_of

GENERATOR = "saoflow build"
TRACE = "trace.json"
WORK = ".saoflow-build-"
"""How the names of folders begin in which files are made."""
MOST_STACK = 1 << 20
"""Bytes of stack that a frame may take, as gcc -O0 lays it out (or as calculated, without gcc)."""


@dataclass(frozen=True, slots=True)
class Built:
    """What was written."""

    sheet: str
    folder: str
    files: tuple[str, ...]
    real: int
    sheet_hash: str
    cost: Cost
    stack: Mapping[str, int | None]
    stack_bound: int
    frames_checked: int

    def to_dict(self) -> dict[str, Any]:
        """The machine-readable form."""
        return {
            "sheet": self.sheet,
            "folder": self.folder,
            "files": list(self.files),
            "real": self.real,
            "sha256": self.sheet_hash,
            "operations": self.cost.total,
            "kinds": dict(self.cost.kinds),
            "frames": list(self.cost.frames),
            "stack": dict(self.stack),
            "stack_bound": self.stack_bound,
            "frames_checked": self.frames_checked,
        }

    def __str__(self) -> str:
        return (
            f"{self.sheet}: {', '.join(self.files)} in {self.folder}\n{self.cost.headline} in binary{self.real}; "
            f"stack: {describe(self.stack, self.stack_bound)}"
        )


def build(sheet: LoadedSheet, folder: str | Path, real: int = 64, inputs: Mapping[str, Any] | None = None) -> Built:
    """Write the C of a sheet to a folder. ``inputs``: what the self-check runs, arrays as of :meth:`Simulator.run`.

    Raises DiagnosisError E401 (over budget), E601 (the folder is not ours, or cannot be written), E610 (stack).
    """
    place = Path(folder)
    check_folder(place)
    report = sheet.budget()
    report.raise_if_over()
    program = sheet.program(real)
    cost = cost_of(report)
    sheet_hash = hash_of(sheet.netlist.sources)
    doc = "\n".join(_wrapped(sheet.netlist.root.structure.doc))
    code = generate(program, About(doc, sheet_hash, _facts(sheet, real, report, cost)))
    simulator = Simulator(program)
    given = dict(inputs) if inputs is not None else exercise(program)
    frames = len(next(iter(given.values()))) if given else 8
    outputs = simulator.run(given or {"frames": np.zeros(frames)})
    check = self_check_file(program, code.interface, given, outputs)
    printed = [print_file(file) for file in (code.source, code.header, check)]
    with _whole_folder(place) as work:
        for file in printed:
            (work / file.name).write_text(file.text, encoding="ascii")
        stack = {level: measured_stack(program, code.interface, work, level) for level in ("-O0", "-O2")}
        bound = stack_bound(program)
        _check_stack(sheet.name, stack["-O0"], bound)
        names = (*(file.name for file in printed), "README.md", TRACE)
        built = Built(sheet.name, str(place), names, real, sheet_hash, cost, stack, bound, frames)
        (work / "README.md").write_text(readme(code, program, cost, describe(stack, bound)), encoding="utf-8")
        trace = _trace(sheet, code, printed[0], sheet_hash, names)
        (work / TRACE).write_text(json.dumps(trace, indent=1), encoding="utf-8")
    return built


def hash_of(sources: SourceLines) -> str:
    """SHA-256 of the text of every sheet that was read: of each file's name and lines, in order of name and text."""
    total = hashlib.sha256()
    for name, text in sorted((Path(file).name, "\n".join(sources.lines(file))) for file in sources.files):
        total.update(f"{name}\0{len(text)}\0{text}\0".encode("utf-8", "surrogateescape"))
    return total.hexdigest()


def _facts(sheet: LoadedSheet, real: int, report: BudgetReport, cost: Cost) -> tuple[str, ...]:
    parameters = ", ".join(f"{name} = {value}" for name, value in sheet.netlist.parameters)
    limits = ", ".join(f"{line.kind} {line.limit:g}" for line in report.lines if line.limit is not None)
    lines = (
        *(("",) if sheet.netlist.root.structure.doc else ()),
        f"Sheet {sheet.name}, reals of {real} bits. Made by saoflow; do not edit.",
        *((f"Parameters: {parameters}.",) if parameters else ()),
        f"Operations a frame: {cost.total} ({', '.join(f'{kind} {n}' for kind, n in cost.kinds.items())}){cost.which}.",
        f"Budget a frame: {limits or 'none stated'}.",
        *((f"Frame period: {report.period:g} s.",) if report.period is not None else ()),
        "Compile without contraction or reassociation: -std=c99 -ffp-contract=off, never -ffast-math.",
    )
    return tuple(part for line in lines for part in _wrapped(line))


def _wrapped(text: str) -> list[str]:
    """A comment's line as lines of a page's width."""
    return textwrap.wrap(" ".join(text.split()), 110, subsequent_indent="  ") or [""]


def _check_stack(name: str, measured: int | None, bound: int) -> None:
    taken = bound if measured is None else measured
    if taken > MOST_STACK:
        how = "calculated, as there is no gcc to measure it" if measured is None else "as gcc -O0 lays it out"
        raise DiagnosisError(
            [
                Diagnosis(
                    "E610",
                    f"a frame of `{name}` is too large for the stack: {taken} bytes, {MOST_STACK} allowed",
                    cause=f"every wire of a sheet is a local variable ({how})",
                    remedy="use a sheet with state, a fold or a map less wide, or smaller matrices",
                )
            ]
        )


def _trace(sheet: LoadedSheet, code: Code, source: Printed, sheet_hash: str, names: tuple[str, ...]) -> dict[str, Any]:
    lines = []
    back: dict[str, dict[str, list[int]]] = {}
    for number, trace in source.traces:
        lines.append({"line": number, "wire": trace.path, "file": trace.file, "sheet_line": trace.line})
        back.setdefault(trace.file, {}).setdefault(str(trace.line), []).append(number)
    return {
        "generator": GENERATOR,
        "sheet": sheet.name,
        "sha256": sheet_hash,
        "written": list(names),
        "source": source.name,
        "step": code.interface.step,
        "c_to_sheet": lines,
        "sheet_to_c": back,
    }


# -- the folder


def check_folder(place: Path) -> None:
    """Raise DiagnosisError E601 unless the folder is new, empty, or was written by an earlier build."""
    if not os.path.lexists(place):
        return
    if not place.is_dir():
        raise _unwritable(place, "it is a file", "name a folder")
    there = sorted(path.name for path in place.iterdir() if not path.name.startswith(WORK))
    if there and _written(place) is None:
        raise _unwritable(place, f"it holds other files: {', '.join(there[:4])}", "name a new or an empty folder")


def _written(place: Path) -> list[str] | None:
    """The files that an earlier build wrote there; None if none did."""
    try:
        trace = json.loads((place / TRACE).read_text(encoding="utf-8"))
        written = trace["written"]
        return written if trace["generator"] == GENERATOR and isinstance(written, list) else None
    except (OSError, ValueError, KeyError, TypeError):
        return None


@contextlib.contextmanager
def _whole_folder(place: Path) -> Iterator[Path]:
    """A folder whose files take their place when all are written. What the user put beside ours stays.

    A folder that is there is filled, not replaced: a shell may stand in it (``-o .``), or a disk be mounted on it.
    """
    new = not place.exists()
    work: Path | None = None
    try:
        place.mkdir(parents=True, exist_ok=True)
        work = Path(tempfile.mkdtemp(prefix=WORK, dir=place))
        yield work
        _move(work, place)
    except OSError as error:
        raise refusal(
            "E601",
            f"`{place}` cannot be written",
            cause=error.strerror or str(error),
            remedy=remedy_of(error, "name a folder that can be written"),
        ) from None
    finally:
        if work is not None:
            shutil.rmtree(work, ignore_errors=True)
        if new:
            with contextlib.suppress(OSError):
                place.rmdir()  # where nothing was written


def _move(work: Path, place: Path) -> None:
    """The trace comes last: until then the folder is known as one of an earlier build."""
    ours = _written(place) or ()
    made = {path.name for path in work.iterdir()}
    for name in sorted(made, key=lambda name: (name == TRACE, name)):
        os.replace(work / name, place / name)
        if name == TRACE:
            for stale in set(ours) - made:
                (place / stale).unlink(missing_ok=True)


def _unwritable(place: Path, cause: str, remedy: str) -> DiagnosisError:
    return DiagnosisError([Diagnosis("E601", f"`{place}` cannot be written", cause=cause, remedy=remedy)])
