"""Compiling C for this machine: finding a compiler, its flags, and what it says when it fails."""

from __future__ import annotations

import contextlib
import errno
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

ANOTHER = "try another compiler (SAOFLOW_CC=clang), or use backend `interpreter`"
ROOM = "make room there, or set XDG_CACHE_HOME to a folder with room; or use backend `interpreter`"


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
    """$SAOFLOW_CC if set; else $CC, cc, gcc, clang or the ``ziglang`` wheel, the first that runs; None if none does.

    Raises DiagnosisError E607 if the one that SAOFLOW_CC names does not run: nobody who names one wants another.
    """
    return _find(os.environ.get("SAOFLOW_CC", "").strip(), os.environ.get("CC", "").strip(), os.environ.get("PATH", ""))


@lru_cache(maxsize=8)
def _find(named: str, usual: str, _path: str) -> Compiler | None:
    if named:
        return _named(named)
    candidates: list[Sequence[str]] = [(name,) for name in ("cc", "gcc", "clang")]
    with contextlib.suppress(ValueError):  # a quote that is not closed: no compiler either
        candidates.insert(0, shlex.split(usual))
    if importlib.util.find_spec("ziglang") is not None:
        candidates.append((sys.executable, "-m", "ziglang", "cc"))
    found = (_asked(command) for command in candidates if command)
    return next((answer for answer in found if isinstance(answer, Compiler)), None)


def _named(text: str) -> Compiler:
    try:
        answer = _asked(shlex.split(text))
    except ValueError as error:
        answer = f"it cannot be split into words: {error}"
    if isinstance(answer, Compiler):
        return answer
    message, remedy = f"SAOFLOW_CC names no compiler that runs: `{text}`", "correct it, or unset it: cc, gcc or clang is taken then"
    raise DiagnosisError([Diagnosis("E607", message, cause=answer, remedy=remedy)])


def _asked(command: Sequence[str]) -> Compiler | str:
    """A compiler that tells its version, or why there is none."""
    found = shutil.which(command[0])
    if found is None:
        return f"there is no program `{command[0]}`"
    found = os.path.abspath(found)  # it is called from other folders
    try:
        told = subprocess.run(
            [found, *command[1:], "--version"], capture_output=True, text=True, errors="replace", timeout=60, stdin=subprocess.DEVNULL
        )
    except subprocess.TimeoutExpired:
        return "it does not tell its version (--version) within a minute"
    except OSError as error:
        return f"{found}: {error.strerror or error}"
    if told.returncode:
        return f"asked for its version (--version), it {ending(told.returncode)}"
    return Compiler((found, *command[1:]), told.stdout.strip())


def ending(code: int) -> str:
    """How a program with this exit code ended, as the rest of a sentence."""
    return f"ends with exit code {code}" if code > 0 else f"is killed by signal {-code}"


def complaint(said: str, code: int) -> str:
    """What a compiler that failed said, its first lines in one; without a word, how it ended."""
    lines = [line for line in said.splitlines() if line.strip()][:3]
    return "; ".join(lines) or f"it {ending(code)} and says nothing"


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


def compiled(texts: Sequence[str], compiler: Compiler, folder: Folder) -> Path:
    """The shared object of C files, from the folder or made now, several files at the same time. Raises DiagnosisError E607."""
    name = object_name(digest(*texts), compiler)
    if folder.read(name) is not None:
        return folder.path / name
    folder.tidy()
    try:
        with tempfile.TemporaryDirectory(prefix=part_prefix(), dir=folder.path) as work, _told(compiler):
            sources = [Path(work) / f"frame{k}.c" for k in range(len(texts))]
            for source, text in zip(sources, texts, strict=True):
                source.write_text(text, encoding="ascii")
            target = Path(work) / "frame.so"
            _make(sources, target, compiler, folder)
            return folder.write(name, target.read_bytes())
    except OSError as error:
        raise _failed(compiler, f"{error.strerror or error} ({folder.path})", ROOM) from None


def _make(sources: Sequence[Path], target: Path, compiler: Compiler, folder: Folder) -> None:
    whole = [*compiler.command, *compiler.flags]
    if len(sources) == 1:
        _call([[*whole, str(sources[0]), "-o", str(target)]], compiler, folder)
    else:
        objects = [source.with_suffix(".o") for source in sources]
        part = [word for word in whole if word != "-shared"]
        pairs = zip(sources, objects, strict=True)
        _call([[*part, "-c", str(source), "-o", str(made)] for source, made in pairs], compiler, folder)
        _call([[*whole, *map(str, objects), "-o", str(target)]], compiler, folder)
    wrong = wrong_library(target)
    if wrong:
        raise _failed(compiler, wrong, ANOTHER)


def _call(commands: Sequence[Sequence[str]], compiler: Compiler, folder: Folder) -> None:
    """All commands at once; what the first one says that fails."""
    # The compiler's own temporary files go beside the source: a compile that is killed leaves one folder, not more.
    place = {**os.environ, "TMPDIR": os.path.dirname(commands[0][-1])}
    with contextlib.ExitStack() as running:
        calls: list[subprocess.Popen[str]] = []
        for command in commands:
            call = running.enter_context(
                subprocess.Popen(
                    command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                    text=True, errors="replace", env=place,
                )
            )  # fmt: skip
            running.callback(call.kill)  # after an interrupt; nothing where it has ended
            calls.append(call)
        ended = [(call.communicate(), call.returncode) for call in calls]
    for (out, errors), code in ended:
        if code:
            said = complaint(errors or out, code)
            full = os.strerror(errno.ENOSPC) in said
            raise _failed(compiler, f"{said} ({folder.path})" if full else said, ROOM if full else ANOTHER)


def wrong_library(path: str | os.PathLike[str]) -> str:
    """Why a library that a compiler has just made is none for this machine; empty if it is one."""
    try:
        with open(path, "rb") as made, open(sys.executable, "rb") as ours:
            there, here = made.read(20), ours.read(20)
    except FileNotFoundError:
        return "it ends without an error, but it has written nothing"
    if not here.startswith(b"\x7fELF"):
        return ""
    if not there.startswith(b"\x7fELF"):
        return "what it has written is no shared library"
    # Width of addresses, order of bytes, and kind of machine, as the header of an ELF file tells them.
    same = there[4:6] == here[4:6] and there[18:20] == here[18:20]
    return "" if same else "it makes code for another machine"


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
