"""The compiled objects of a sheet: found again by the content of its YAML, else elaborated, printed and compiled.

What a program is made from is all in a few files, so their content finds the program and its objects again without reading
a sheet. Every step checks by content: the YAML, this package's own code, the C text, the compiler and its flags.
"""

from __future__ import annotations

import os
import pickle
import warnings
from collections.abc import Collection, Mapping
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Protocol

from saoflow.cache import Folder, cache_folder
from saoflow.codegen.compiler import Compiler, compiled, object_name
from saoflow.collector import collector_paused
from saoflow.diagnosis import Diagnosis
from saoflow.diagrams.content_key import code_fingerprint, digest, readable_sheets
from saoflow.diagrams.expression_value import Quantity
from saoflow.diagrams.sheet import Sheet
from saoflow.scheduler.program import FrameProgram

if TYPE_CHECKING:
    from saoflow.scheduler.budget import BudgetReport


class BackendWarning(UserWarning):
    """What was asked for is not there, and something else does the work."""

    def __init__(self, diagnosis: Diagnosis) -> None:
        super().__init__(diagnosis.render())
        self.diagnosis = diagnosis


class ProgramSource(Protocol):
    """A sheet on its way to frames: what compiling needs of it."""

    sheet: Sheet
    given: Mapping[str, Quantity]

    @property
    def frame_program(self) -> FrameProgram:
        """The program in binary64 without probes."""
        ...

    def program(self, real: int = 64, probes: Collection[str] = ()) -> FrameProgram:
        """The program in ``real`` bits, with probes."""
        ...

    def budget(self) -> BudgetReport:
        """What a frame costs against what it may cost."""
        ...


@lru_cache(maxsize=64)
def warn_once(message: str, cause: str, remedy: str) -> None:
    """A warning that is given once in a process."""
    warnings.warn(BackendWarning(Diagnosis("W607", message, cause=cause, remedy=remedy)), stacklevel=4)


@dataclass(frozen=True, slots=True, eq=False)
class Objects:
    """The shared objects of a program. ``key`` finds them again; empty: it does not."""

    program: FrameProgram
    compiler: Compiler
    folder: Folder
    key: str

    def path(self, lanes: int) -> Path:
        """The object for one flight (0) or so many side by side. Raises DiagnosisError E607."""
        # A batch is worth a longer compile; one flight only if it was asked for.
        placed = lanes > 0 or self.compiler.thorough
        note = f"{self.key}.{lanes}{'p' if placed else ''}"
        known = self.folder.read(note) if self.key else None
        if known is not None:
            name = object_name(known.decode("ascii"), self.compiler)
            if self.folder.read(name) is not None:
                return self.folder.path / name
        from saoflow.codegen.generate import native_files
        from saoflow.codegen.printer import print_file

        with collector_paused():
            files = native_files(self.program, lanes, placed)
            texts = [print_file(file, traced=False).text for file in files]
        path = compiled(texts, self.compiler, self.folder)
        if self.key:
            _keep(self.folder, note, digest(*texts).encode("ascii"))
        return path


def objects_of(sheet: ProgramSource, real: int, probes: Collection[str], compiler: Compiler) -> Objects:
    """The program of a sheet and its objects. Raises DiagnosisError as elaboration does, and E401."""
    kept, folder, key = _kept(sheet, real, probes)
    if kept is not None:
        return Objects(kept, compiler, folder, key)
    if folder.problem:
        warn_once(
            "compiled code is not kept",
            f"the cache folder cannot be used: {folder.problem}",
            "set XDG_CACHE_HOME to a folder of your own",
        )
    sheet.budget().raise_if_over()
    program = sheet.program(real, probes) if real != 64 or probes else sheet.frame_program
    if key:
        _keep(folder, f"{key}.program", pickle.dumps(program, 5))
    return Objects(program, compiler, folder, key)


def kept_objects(sheet: ProgramSource, real: int, probes: Collection[str], compiler: Compiler) -> Objects | None:
    """:func:`objects_of` for a sheet that was elaborated before, in this or another process; else None."""
    kept, folder, key = _kept(sheet, real, probes)
    return None if kept is None else Objects(kept, compiler, folder, key)


def _kept(sheet: ProgramSource, real: int, probes: Collection[str]) -> tuple[FrameProgram | None, Folder, str]:
    """The program if it is kept, where that is, and what finds it there. A program over its budget is not kept."""
    folder = cache_folder()
    key = "" if folder.problem else content_key(sheet, real, probes)
    found = folder.read(f"{key}.program") if key else None
    if found is None:
        return None, folder, key
    with collector_paused():
        # Written by this very code (its fingerprint is in the key), into a folder that only its owner writes to.
        program: FrameProgram = pickle.loads(found)
    return program, folder, key


def _keep(folder: Folder, name: str, content: bytes) -> None:
    try:
        folder.write(name, content)
    except OSError as error:
        warn_once("compiled code is not kept", f"{folder.path}: {error.strerror}", "make room there")


def content_key(sheet: ProgramSource, real: int = 64, probes: Collection[str] = ()) -> str:
    """All that a program depends on; empty where that is too much to read every time."""
    files = readable_sheets(Path(sheet.sheet.file))
    if files is None:
        return ""
    given = [
        f"{name}={value.array.shape}{value.array.tobytes()!r}{value.unit}{value.text}{value.literal}"
        for name, value in sheet.given.items()
    ]
    where = (os.getcwd(), sheet.sheet.file, *sheet.sheet.lines)
    return digest(code_fingerprint(), str(real), *sorted(given), *probes, "\1", *where, "\1", *files)
