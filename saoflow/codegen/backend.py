"""Backend ``c``: compiled frames, or a word about it where there is no compiler."""

from __future__ import annotations

from collections.abc import Collection

from saoflow.codegen.compiler import find_compiler
from saoflow.codegen.native import NativeSimulator
from saoflow.codegen.objects import ProgramSource, kept_objects, objects_of, warn_once
from saoflow.diagnosis import Diagnosis, DiagnosisError
from saoflow.scheduler.simulator import Simulator


def native_simulator(sheet: ProgramSource, real: int, probes: Collection[str], exact: bool) -> Simulator | None:
    """Frames in C, or None (and a warning) without a C compiler. Raises DiagnosisError as elaboration does, E401, and E607 (exact mode; a compile that fails)."""
    if exact:
        raise DiagnosisError(
            [
                Diagnosis(
                    "E607",
                    "exact mode does not exist in C",
                    cause="the C code has tables in place of mathematical functions",
                    remedy="use backend `interpreter`, or leave out exact",
                )
            ]
        )
    compiler = find_compiler()
    if compiler is None:
        warn_once(
            "there is no C compiler: the interpreter runs the frames, slowly",
            "none of cc, gcc, clang and the ziglang package is there or runs",
            "install a C compiler, or pip install saoflow[cc]",
        )
        return None
    objects = objects_of(sheet, real, probes, compiler)
    return NativeSimulator(objects.program, objects)


def kept_simulator(sheet: ProgramSource, real: int, probes: Collection[str]) -> Simulator | None:
    """Frames in C of a sheet that was right and within its budget before, without elaborating it again; else None."""
    compiler = find_compiler()
    objects = None if compiler is None else kept_objects(sheet, real, probes, compiler)
    return None if objects is None else NativeSimulator(objects.program, objects)
