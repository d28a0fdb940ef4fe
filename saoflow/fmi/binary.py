"""The binary of a unit for this machine."""

from __future__ import annotations

import errno
import os
import platform
import subprocess
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from saoflow.codegen.compiler import Compiler, complaint, wrong_library
from saoflow.diagnosis import Diagnosis, DiagnosisError

FLAGS = ("-std=c99", "-ffp-contract=off", "-fno-fast-math", "-fPIC", "-shared", "-fvisibility=hidden")
"""Every operation rounded as written, and no instruction that another machine of this kind lacks."""


@dataclass(frozen=True, slots=True)
class Platform:
    """A kind of machine, by its folder in FMI 3.0 and in FMI 2.0, and how its shared libraries end."""

    folder_3: str
    folder_2: str
    suffix: str

    def path(self, version: int, identifier: str) -> str:
        """Where the binary lies in the unit."""
        return f"binaries/{self.folder_2 if version == 2 else self.folder_3}/{identifier}{self.suffix}"


_SYSTEMS = {"Linux": ("linux", ".so"), "Darwin": ("darwin", ".dylib"), "Windows": ("windows", ".dll")}
_MACHINES = {"x86_64": "x86_64", "AMD64": "x86_64", "aarch64": "aarch64", "arm64": "aarch64", "ARM64": "aarch64"}
_FOLDERS_2 = {
    "x86_64-linux": "linux64",
    "x86_64-windows": "win64",
    "x86_64-darwin": "darwin64",
    "aarch64-darwin": "darwin64",
}


def this_platform() -> Platform | None:
    """This machine; None if FMI has no name for it."""
    system, machine = _SYSTEMS.get(platform.system()), _MACHINES.get(platform.machine())
    if system is None or machine is None:
        return None
    folder = f"{machine}-{system[0]}"
    return Platform(folder, _FOLDERS_2.get(folder, folder), system[1])


def compile_binary(
    files: Mapping[str, bytes], sources: Sequence[str], compiler: Compiler, optimisation: str = "-O2"
) -> bytes:
    """The shared library of the sources (names in ``files``). Raises DiagnosisError E607, E601."""
    try:
        with tempfile.TemporaryDirectory(prefix="saoflow-fmu-") as folder:
            for name, content in files.items():
                (Path(folder) / name).write_bytes(content)
            target = Path(folder) / "unit.binary"
            command = [*compiler.command, *FLAGS, optimisation, *sources, "-o", target.name]
            done = subprocess.run(
                command, cwd=folder, capture_output=True, text=True, errors="replace", stdin=subprocess.DEVNULL
            )
            if os.strerror(errno.ENOSPC) in done.stderr:
                raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), folder)
            if done.returncode:
                raise _failed(compiler, complaint(done.stderr or done.stdout, done.returncode))
            wrong = wrong_library(target)
            if wrong:
                raise _failed(compiler, wrong)
            return target.read_bytes()
    except OSError as error:
        where = error.filename or tempfile.gettempdir()
        raise DiagnosisError(
            [
                Diagnosis(
                    "E601",
                    "the binary of the unit cannot be made",
                    cause=f"{where}: {error.strerror or error}",
                    remedy="make room there, set TMPDIR to another folder, or leave the binary out with --source-only",
                )
            ]
        ) from None


def _failed(compiler: Compiler, cause: str) -> DiagnosisError:
    return DiagnosisError(
        [
            Diagnosis(
                "E607",
                f"the C code of the unit cannot be compiled with {' '.join(compiler.command)}",
                cause=cause,
                remedy="try another compiler (SAOFLOW_CC=clang), or leave the binary out with --source-only",
            )
        ]
    )
