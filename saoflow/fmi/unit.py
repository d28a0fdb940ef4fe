"""A functional mock-up unit of a sheet: its files, made in memory, then written as one."""

from __future__ import annotations

import hashlib
import io
import math
import os
import zipfile
from dataclasses import dataclass
from importlib import resources
from pathlib import Path
from typing import TYPE_CHECKING

from saoflow.codegen.build import hash_of
from saoflow.codegen.generate import About, generate
from saoflow.codegen.interface import Interface
from saoflow.codegen.printer import print_file
from saoflow.diagnosis import Diagnosis, DiagnosisError
from saoflow.fmi.binary import compile_binary, this_platform
from saoflow.fmi.description import Facts, build_description, model_description
from saoflow.fmi.model_c import model_header
from saoflow.fmi.variables import Variable, scalars, variables
from saoflow.whole_file import write_whole

if TYPE_CHECKING:
    from saoflow.pipeline import LoadedSheet

VERSIONS = (3, 2)
_WRAPPER = {2: ("fmi2-api.h", "fmi2-unit.c"), 3: ("fmi3-api.h", "fmi3-unit.c", "fmi3-refusals.h")}
_SHARED = ("fmi-memory.h", "fmi-unit.h")
_DATE = (1980, 1, 1, 0, 0, 0)
"""Of every file in the archive: the same sheet gives the same bytes."""


@dataclass(frozen=True, slots=True)
class Unit:
    """A unit that is not yet written. ``files``: path in the archive and content; ``period`` in s."""

    name: str
    identifier: str
    version: int
    period: float
    token: str
    variables: tuple[Variable, ...]
    files: tuple[tuple[str, bytes], ...]
    platform: str | None
    """The folder of the binary, or None if there is none."""

    def count(self, causality: str, variability: str = "discrete") -> int:
        """How many variables of a kind."""
        return sum(1 for v in self.variables if (v.causality, v.variability) == (causality, variability))


def build_unit(
    sheet: LoadedSheet,
    version: int = 3,
    *,
    real: int = 64,
    period: float | None = None,
    scalar: bool = False,
    binary: bool = True,
    optimisation: str = "-O2",
) -> Unit:
    """The co-simulation unit of a sheet for FMI 3.0 (``version`` 3) or 2.0 (2).

    ``period``: the frame period in s of a sheet whose budget states none. ``scalar``: elements of vectors and matrices
    as scalars in FMI 3.0 too (FMI 2.0 knows no others). ``binary``: compile for this machine; without a compiler the
    unit holds sources only (``Unit.platform`` is None). Raises DiagnosisError E107, E401, E601, E603, E607.
    """
    if version not in VERSIONS or real not in (32, 64):
        wrong, allowed = ("version", "3 and 2") if version not in VERSIONS else ("real", "64 and 32")
        value = version if version not in VERSIONS else real
        raise DiagnosisError(
            [Diagnosis("E603", f"{wrong} cannot be {value}", cause=f"units have {allowed}", remedy="use one of them")]
        )
    frame = frame_period(sheet, period)
    sheet.budget().raise_if_over()
    program = sheet.program(real)
    code = generate(program, About(sheet.sheet.doc, hash_of(sheet.netlist.sources), ()))
    core = {file.name: print_file(file).text.encode("ascii") for file in (code.header, code.source)}
    found = variables(sheet, program, code.interface)
    if scalar or version == 2:
        found = tuple(part for variable in found for part in scalars(variable))
    facts = Facts(
        version,
        sheet.name,
        code.interface.prefix,
        sheet.sheet.doc,
        f"saoflow {_tool_version()}",
        frame,
        (code.source.name, _WRAPPER[version][1]),
    )
    token = _token(facts, found, core)
    sources = core | _wrapper(version, code.interface, found, frame, token)
    files = {
        "modelDescription.xml": model_description(facts, found, token),
        **{f"sources/{name}": content for name, content in sources.items()},
    }
    if version == 3:
        files["sources/buildDescription.xml"] = build_description(facts)
    here = _binary(sources, facts, optimisation) if binary else None
    if here is not None:
        files[here[0]] = here[1]
    return Unit(
        sheet.name,
        facts.identifier,
        version,
        frame,
        token,
        found,
        tuple(files.items()),
        None if here is None else here[0].split("/")[1],
    )


def frame_period(sheet: LoadedSheet, given: float | None = None) -> float:
    """The frame period in s: of the sheet's budget, else as given. Raises DiagnosisError E107, E603."""
    structure = sheet.netlist.root.structure
    budget = structure.budget
    stated = budget.period if budget is not None else None
    if given is not None and not (math.isfinite(given) and given > 0):
        raise DiagnosisError(
            [
                Diagnosis(
                    "E603",
                    f"a frame period cannot be {given:g} s",
                    cause="it is a finite number of seconds above zero",
                    remedy="write --period 0.05, for example",
                )
            ]
        )
    if stated is None and given is None:
        position = budget.position if budget is not None else structure.position
        raise DiagnosisError(
            [
                Diagnosis(
                    "E107",
                    f"`{sheet.name}` states no frame period",
                    position,
                    "a unit of FMI steps in seconds, and a frame of this sheet has no length",
                    "add `budget: {period: 0.05}` to the sheet, in s, or give --period",
                    source_line=sheet.netlist.sources.line(position),
                )
            ]
        )
    if stated is None or given is None or given == stated:
        return stated if stated is not None else float(given or 0.0)
    assert budget is not None
    raise DiagnosisError(
        [
            Diagnosis(
                "E603",
                f"the frame period of `{sheet.name}` is {stated:g} s, not {given:g} s",
                budget.position,
                "the sheet states it, and its numbers may depend on it",
                "leave out --period, or change the sheet",
                source_line=sheet.netlist.sources.line(budget.position),
            )
        ]
    )


def write_unit(unit: Unit, path: str | Path) -> Path:
    """Write the archive: the whole file, or none; only a unit may be replaced. Raises DiagnosisError E601."""
    target = check_target(path)
    archive = io.BytesIO()
    with zipfile.ZipFile(archive, "w", zipfile.ZIP_DEFLATED) as file:
        for name, content in unit.files:
            entry = zipfile.ZipInfo(name, _DATE)
            entry.compress_type = zipfile.ZIP_DEFLATED
            entry.external_attr = (0o755 if name.startswith("binaries/") else 0o644) << 16
            file.writestr(entry, content)
    try:
        write_whole(target, archive.getvalue())
    except OSError as error:
        raise _unwritable(path, error.strerror or str(error), "make room, or name another file") from None
    return target


def check_target(path: str | Path) -> Path:
    """Refuse now a file that could not be written later, or that is no unit. Raises DiagnosisError E601."""
    target = Path(os.path.realpath(path))
    if not target.name.endswith(".fmu"):
        raise _unwritable(path, "the name of a unit ends in .fmu", f"write -o {target.name}.fmu")
    if target.is_dir():
        raise _unwritable(path, "it is a folder", "name a file")
    if not target.parent.is_dir():
        raise _unwritable(path, f"there is no folder `{Path(path).parent}`", "make the folder first, or name another")
    if target.exists() and not _is_unit(target):
        raise _unwritable(path, "the file is there and is no unit", "name another file, or remove this one")
    if not os.access(target.parent, os.W_OK) or (target.exists() and not os.access(target, os.W_OK)):
        raise _unwritable(path, "it may not be written to", "name a file in a folder that you may write to")
    return target


def _is_unit(path: Path) -> bool:
    try:
        with zipfile.ZipFile(path) as file:
            return "modelDescription.xml" in file.namelist()
    except (OSError, zipfile.BadZipFile):
        return False


def _unwritable(path: str | Path, cause: str, remedy: str) -> DiagnosisError:
    return DiagnosisError([Diagnosis("E601", f"{path}: cannot be written", None, cause, remedy)])


# -- the parts


def _wrapper(
    version: int, interface: Interface, found: tuple[Variable, ...], period: float, token: str
) -> dict[str, bytes]:
    folder = resources.files("saoflow.fmi").joinpath("c")
    files = {name: folder.joinpath(name).read_bytes() for name in (*_SHARED, *_WRAPPER[version])}
    return {"fmi-model.h": model_header(interface, found, period, token).encode("ascii"), **files}


def _binary(sources: dict[str, bytes], facts: Facts, optimisation: str) -> tuple[str, bytes] | None:
    """Path and content of the binary; None without a compiler, or on a machine that FMI has no name for."""
    from saoflow.codegen.compiler import find_compiler

    here, compiler = this_platform(), find_compiler()
    if here is None or compiler is None:
        return None
    return here.path(facts.version, facts.identifier), compile_binary(sources, facts.sources, compiler, optimisation)


def _token(facts: Facts, found: tuple[Variable, ...], core: dict[str, bytes]) -> str:
    """The same for the same description and code; another for any other."""
    check = hashlib.sha256(model_description(facts, found, ""))
    for name in sorted(core):
        check.update(core[name])
    text = check.hexdigest()
    return f"{{{text[:8]}-{text[8:12]}-{text[12:16]}-{text[16:20]}-{text[20:32]}}}"


def _tool_version() -> str:
    from importlib.metadata import PackageNotFoundError, version

    try:
        return version("saoflow")
    except PackageNotFoundError:
        return "(not installed)"
