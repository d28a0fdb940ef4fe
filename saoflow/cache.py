"""Compiled objects on disk, by content: safe under concurrent processes, killed writers and half-written files.

A file is written beside its place and moved there whole. Behind its content stands a seal, the SHA-256 of it; a file without
its seal (cut short, or damaged) counts as absent. What lies in the folder is loaded into this process, so a folder that
others may write to is not used.
"""

from __future__ import annotations

import contextlib
import hashlib
import os
import platform
import re
import tempfile
import time
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

_MARK = b"saoflow seal 1\n"
_SEAL = len(_MARK) + 32
MOST_FILES = 400
"""The oldest of more files are removed."""
ABANDONED = 86400.0
"""Seconds after which what another machine's process left is removed; this machine's is when its process is gone."""


@dataclass(frozen=True, slots=True)
class Folder:
    """Where objects are kept. ``problem``: why the user's cache folder is not used, or an empty text."""

    path: Path
    problem: str = ""

    def read(self, name: str) -> bytes | None:
        """The content of a file; None if there is none, or none that is whole."""
        try:
            data = (self.path / name).read_bytes()
        except OSError:
            return None
        content, seal = data[:-_SEAL], data[-_SEAL:]
        if seal != _MARK + hashlib.sha256(content).digest():
            return None
        with contextlib.suppress(OSError):
            os.utime(self.path / name)
        return content

    def write(self, name: str, content: bytes) -> Path:
        """Put a file in its place, whole. Raises OSError."""
        handle, temporary = tempfile.mkstemp(prefix=part_prefix(), dir=self.path)
        try:
            with os.fdopen(handle, "wb") as file:
                file.write(content + _MARK + hashlib.sha256(content).digest())
            os.replace(temporary, self.path / name)
        except BaseException:
            with contextlib.suppress(OSError):
                os.unlink(temporary)
            raise
        return self.path / name

    def tidy(self) -> None:
        """Remove what killed processes left, and the oldest of too many files."""
        kept: list[tuple[float, Path]] = []
        with contextlib.suppress(OSError):
            for path in self.path.iterdir():
                with contextlib.suppress(OSError):
                    age = path.stat().st_mtime
                    if path.name.startswith("part-"):
                        if time.time() - age > ABANDONED or _is_orphan(path.name):
                            _remove(path)
                    else:
                        kept.append((age, path))
        for _, path in sorted(kept)[: max(0, len(kept) - MOST_FILES)]:
            _remove(path)


def part_prefix() -> str:
    """How the names of files begin that are not whole yet: with the machine and the process that make them."""
    return f"part-{platform.node().replace(os.sep, '_')}-{os.getpid()}-"


def _is_orphan(name: str) -> bool:
    """Whether the process that made a part, on this machine, is gone."""
    owner = re.fullmatch(r"part-(.*)-(\d+)-[^-]*", name)
    if os.name != "posix" or owner is None or owner[1] != platform.node().replace(os.sep, "_"):
        return False
    try:
        os.kill(int(owner[2]), 0)
    except ProcessLookupError:
        return True
    except (OSError, OverflowError):
        pass
    return False


def cache_folder() -> Folder:
    """The user's cache folder ($XDG_CACHE_HOME/saoflow, else ~/.cache/saoflow), or one that ends with this process."""
    base = os.environ.get("XDG_CACHE_HOME", "")
    return _folder(base if os.path.isabs(base) else os.path.join(os.path.expanduser("~"), ".cache"))


@lru_cache(maxsize=8)
def _folder(base: str) -> Folder:
    path = Path(base) / "saoflow"
    try:
        path.mkdir(mode=0o700, parents=True, exist_ok=True)
        status = path.stat()
        if hasattr(os, "getuid") and (status.st_uid != os.getuid() or status.st_mode & 0o022):
            return Folder(_temporary(), f"others may write to {path}")
        handle, probe = tempfile.mkstemp(prefix=part_prefix(), dir=path)
        os.close(handle)
        os.unlink(probe)
    except OSError as error:
        return Folder(_temporary(), f"{path}: {error.strerror}")
    return Folder(path)


@lru_cache(maxsize=1)
def _temporary() -> Path:
    import atexit
    import shutil

    path = Path(tempfile.mkdtemp(prefix="saoflow-"))
    atexit.register(shutil.rmtree, path, ignore_errors=True)
    return path


def _remove(path: Path) -> None:
    import shutil

    with contextlib.suppress(OSError):
        if path.is_dir():
            shutil.rmtree(path, ignore_errors=True)
        else:
            path.unlink()
