"""Compiling C for this machine: finding a compiler, its flags, and what it says when it fails."""

from __future__ import annotations

import contextlib
import importlib.util
import os
import platform
import shlex
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

from saoflow.cache import Folder, part_prefix
from saoflow.diagnosis import Diagnosis, DiagnosisError
from saoflow.diagrams.content_key import digest

STRICT = ("-std=gnu99", "-ffp-contract=off", "-fno-fast-math", "-fPIC", "-shared", "-w")
"""Every operation rounded as written; code that loads anywhere; no warnings (``saoflow build`` is what is checked)."""


@dataclass(frozen=True, slots=True)
class Compiler:
    """How a compiler is called, and what it calls itself."""

    command: tuple[str, ...]
    version: str

    @property
    def flags(self) -> tuple[str, ...]:
        """What makes good code soon: a frame's code is long and straight, and compiled while the user waits."""
        # One pass of gcc (dead stores in machine code) takes as long as all others together on such code, for nothing.
        quick = () if self.thorough else ("-O1",) if self.is_clang else ("-O1", "-fno-dse")
        return (*quick, *(() if self.is_clang else ("-Wno-psabi",)), *(("-march=native",) if platform.machine() in ("x86_64", "AMD64") else ()), *STRICT)

    @property
    def thorough(self) -> bool:
        """The command itself names a level (``SAOFLOW_CC="clang -O2"``): it is taken, and compiles may last."""
        return any(word in ("-O2", "-O3") for word in self.command)

    @property
    def is_clang(self) -> bool:
        """clang, or zig's."""
        return "clang" in self.version or "zig" in " ".join(self.command)


def find_compiler() -> Compiler | None:
    """$SAOFLOW_CC or $CC if set, else cc, gcc, clang, else the ``ziglang`` wheel; None if there is none that runs."""
    return _find(os.environ.get("SAOFLOW_CC") or os.environ.get("CC") or "", os.environ.get("PATH", ""))


@lru_cache(maxsize=8)
def _find(chosen: str, _path: str) -> Compiler | None:
    candidates: list[tuple[str, ...]] = [tuple(shlex.split(chosen))] if chosen else []
    candidates += [(name,) for name in ("cc", "gcc", "clang")]
    if importlib.util.find_spec("ziglang") is not None:
        candidates.append((sys.executable, "-m", "ziglang", "cc"))
    for command in candidates:
        found = shutil.which(command[0])
        if found is None:
            continue
        with contextlib.suppress(OSError, subprocess.SubprocessError):
            answer = subprocess.run([found, *command[1:], "--version"], capture_output=True, text=True, timeout=60)
            if answer.returncode == 0:
                return Compiler((found, *command[1:]), answer.stdout.strip())
    return None


@lru_cache(maxsize=1)
def machine() -> str:
    """What -march=native depends on: the processor's abilities."""
    with contextlib.suppress(OSError), open("/proc/cpuinfo", encoding="utf-8", errors="replace") as file:
        lines = [line.partition(":") for line in file if line.startswith(("flags", "Features", "model name", "CPU"))]
        return f"{platform.machine()} {sorted({word for _, _, value in lines for word in value.split()})}"
    return f"{platform.machine()} {platform.processor()} {platform.node()}"


def register_bytes() -> int:
    """The width of the widest registers that flights are laid into side by side: AVX-512, AVX2, or what every machine has."""
    abilities = machine()
    if "'avx512f'" in abilities and "'avx512dq'" in abilities:
        return 64
    return 32 if "'avx2'" in abilities else 16


def object_name(source: str, compiler: Compiler) -> str:
    """The name of an object: everything that its content depends on. ``source``: the digest of its C text."""
    return f"{digest(source, *compiler.flags, *compiler.command, compiler.version, machine())}.so"


def compiled(text: str, compiler: Compiler, folder: Folder) -> Path:
    """The shared object of a C text, from the folder or made now. Raises DiagnosisError E607."""
    name = object_name(digest(text), compiler)
    if folder.read(name) is not None:
        return folder.path / name
    folder.tidy()
    try:
        with tempfile.TemporaryDirectory(prefix=part_prefix(), dir=folder.path) as work, _told(compiler):
            source, target = Path(work) / "frame.c", Path(work) / "frame.so"
            source.write_text(text, encoding="ascii")
            _call([*compiler.command, *compiler.flags, str(source), "-o", str(target)], compiler)
            return folder.write(name, target.read_bytes())
    except OSError as error:
        raise _failed(
            compiler,
            f"{error.strerror or error} ({folder.path})",
            "make room there, or set XDG_CACHE_HOME to a folder with room; or use backend `interpreter`",
        ) from None


def _call(command: Sequence[str], compiler: Compiler) -> None:
    # The compiler's own temporary files go beside the source: a compile that is killed leaves one folder, not more.
    place = {**os.environ, "TMPDIR": os.path.dirname(command[-1])}
    done = subprocess.run(
        command, capture_output=True, text=True, errors="replace", stdin=subprocess.DEVNULL, env=place
    )
    if done.returncode:
        code = done.returncode
        ended = f"ends with exit code {code}" if code > 0 else f"is killed by signal {-code}"
        said = [line for line in (done.stderr or done.stdout).splitlines() if line.strip()][:3]
        raise _failed(
            compiler,
            "; ".join(said) or f"it {ended} and says nothing",
            "try another compiler (SAOFLOW_CC=clang), or use backend `interpreter`",
        )


def _failed(compiler: Compiler, cause: str, remedy: str) -> DiagnosisError:
    message = f"the C code cannot be compiled with {' '.join(compiler.command)}"
    return DiagnosisError([Diagnosis("E607", message, cause=cause, remedy=remedy)])


@contextlib.contextmanager
def _told(compiler: Compiler) -> Iterator[None]:
    """A word on the terminal while a compile lasts longer than a second."""
    import threading

    if not sys.stderr.isatty():
        yield
        return
    done = threading.Event()

    def tell() -> None:
        if done.wait(1.0):
            return
        from rich.console import Console

        with Console(stderr=True).status(f"compiling the frame with {Path(compiler.command[0]).name} ..."):
            done.wait()

    teller = threading.Thread(target=tell, daemon=True)
    teller.start()
    try:
        yield
    finally:
        done.set()
        teller.join()
