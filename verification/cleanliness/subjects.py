"""What is looked at: the C of shipped sheets and of random ones, in both widths, written to folders."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from hypothesis import HealthCheck, Phase, given, seed, settings

import saoflow
from saoflow.codegen.interface import Interface
from saoflow.diagrams.store import LIBRARY
from saoflow.pipeline import LoadedSheet
from saoflow.scheduler.program import FrameProgram
from verification.bits.flights import flagship_rows
from verification.bits.harness import write_program
from verification.bits.random_sheets import ODD, SIDE_SHEETS, sheets

ESTIMATORS = ("cmhe_fte", "umhe_fte", "ekf_fte", "cmhe_fte_lean")
"""Shipped root sheets that fly; those that do not exist are left out by name."""

LIBRARY_PARAMETERS: Mapping[str, float] = {
    "n": 4, "m": 2, "size": 3, "needed": 2, "largest": 10, "low": -1, "high": 1, "nominal": 0.25,
}  # fmt: skip
"""Values for the parameters of library sheets that have no default, so that they elaborate standalone."""

RANDOM = "random sheets"
"""The group of sheets drawn at random."""


@dataclass(frozen=True, slots=True)
class Subject:
    """The C of one sheet in one width: ``folder`` holds its header, its source, and a ``main.c`` that runs frames."""

    group: str
    name: str
    real: int
    folder: Path
    interface: Interface
    parameters: int
    """The most parameters that one function has."""
    identifiers: int
    """The most identifiers that one block declares."""
    frames: int
    """Frames in ``in.bin``: reals of this width in this machine's byte order."""

    @property
    def drawn(self) -> bool:
        """Whether the sheet is a random one."""
        return self.group == RANDOM

    @property
    def source(self) -> Path:
        """The C file."""
        return self.folder / f"{self.interface.prefix}.c"

    @property
    def header(self) -> Path:
        """Its header."""
        return self.folder / f"{self.interface.prefix}.h"

    def __str__(self) -> str:
        return f"{self.name}, {self.real} bits"


def subject(group: str, sheet: LoadedSheet, real: int, folder: Path, rows: np.ndarray | None, frames: int) -> Subject:
    """Generate the C of a sheet. ``rows``: (frames, inputs), or None for ``frames`` rows of odd and ordinary numbers."""
    folder.mkdir(parents=True, exist_ok=True)
    program = sheet.program(real)
    code = write_program(program, folder)
    if rows is None:
        width = max(sum(port.type.size for port in program.inputs), 1)
        rows = odd_rows(frames, width)
    with np.errstate(all="ignore"):
        (folder / "in.bin").write_bytes(rows.astype(f"f{real // 8}").tobytes())
    parameters, identifiers = sizes(program)
    return Subject(group, sheet.name, real, folder, code.interface, parameters, identifiers, len(rows))


def sizes(program: FrameProgram) -> tuple[int, int]:
    """The most parameters of a function, and the most identifiers of a block, of a program's C."""
    parameters = [len(body.parameters) + 2 for body in program.procedures]
    identifiers = [sum(max(len(op.results), 1) for op in body.operations) for body in program.bodies]
    return max(parameters, default=3), max(identifiers, default=0)


def odd_rows(frames: int, width: int, number: int = 7) -> np.ndarray:
    """(frames, width): normal numbers, and one in four an infinity, NaN, denormal, zero or huge number."""
    rng = np.random.default_rng(number)
    return np.where(
        rng.random((frames, width)) < 0.25, rng.choice(ODD, (frames, width)), rng.normal(size=(frames, width))
    )


def estimators(folder: Path, names: tuple[str, ...], widths: tuple[int, ...], frames: int) -> Iterator[Subject]:
    """The shipped estimators over flights with noise, faults, missing samples and odd numbers. Raises DiagnosisError."""
    rows = flagship_rows(frames, seed=5)
    for name in names:
        sheet = saoflow.load(name)
        for real in widths:
            yield subject(name, sheet, real, folder / f"{name}_{real}", rows, frames)


def library(folder: Path, widths: tuple[int, ...], frames: int, every: int = 1) -> tuple[list[Subject], list[str]]:
    """The sheets of the library, or each ``every``-th of them; and the names of those that do not stand alone."""
    found: list[Subject] = []
    alone: list[str] = []
    for path in sorted(LIBRARY.glob("*.yaml"))[::every]:
        declared = saoflow.load(str(path)).sheet.parameters
        needed = {p.name.text: LIBRARY_PARAMETERS.get(p.name.text, 1.0) for p in declared if p.value is None}
        sheet = saoflow.load(str(path), needed)
        try:
            sheet.check()
        except saoflow.DiagnosisError:
            alone.append(path.stem)
            continue
        found += [subject("library", sheet, w, folder / f"{path.stem}_{w}", None, frames) for w in widths]
    return found, alone


def random_sheets(folder: Path, count: int, number: int, frames: int) -> list[Subject]:
    """Sheets drawn at random, each in one of the two widths."""
    texts: list[str] = []

    @seed(number)
    @settings(
        max_examples=count,
        deadline=None,
        database=None,
        phases=(Phase.generate,),
        suppress_health_check=list(HealthCheck),
    )
    @given(sheets())
    def draw(text: str) -> None:
        texts.append(text)

    draw()
    found: list[Subject] = []
    for i, text in enumerate(texts[:count]):
        place = folder / f"random_{i}"
        place.mkdir(parents=True)
        for side, content in SIDE_SHEETS.items():
            (place / f"{side}.yaml").write_text(content, encoding="utf-8")
        (place / "s.yaml").write_text(text, encoding="utf-8")
        sheet = saoflow.load(str(place / "s.yaml"))
        made = subject(RANDOM, sheet, 64 if i % 2 else 32, place / "c", None, frames)
        found.append(made)
    return found
