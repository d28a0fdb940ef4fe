"""Keys under which findings about a sheet are kept: digests of everything that they depend on. Reads no sheet's meaning.

A sheet may use those beside it and the shipped ones, so the content of all of them is in its key, with saoflow's own code
and whatever else is installed. Nothing is guessed from dates alone but for saoflow's code, which nobody edits in use.
"""

from __future__ import annotations

import hashlib
import os
import sys
from functools import lru_cache
from pathlib import Path

from saoflow.diagrams.shipped import SHIPPED, shown_path

MOST_SHEETS = 300
"""A sheet in a folder of more YAML files than this is looked at anew every time."""
LARGEST = 2**23
"""Bytes that files may have to be read every time."""


def digest(*parts: str) -> str:
    """SHA-256 of texts, as 40 hexadecimal digits."""
    return hashlib.sha256("\0".join(parts).encode("utf-8", "surrogateescape")).hexdigest()[:40]


def readable_sheets(root: Path) -> list[str] | None:
    """Name and content of every file that the sheet in ``root`` may read: itself, those beside it, and the shipped ones.

    None where that is too much to read every time, or cannot be read.
    """
    try:
        beside = _beside(shown_path(root).parent)
        if beside is None or not root.is_file():
            return None
        files = (root, *beside, *sorted(SHIPPED.glob("*/*.yaml")))
        return [str(shown_path(root)), *(_content(path) for path in files)]
    except (OSError, ValueError):
        return None


def _beside(folder: Path) -> list[Path] | None:
    """The sheets in a folder, and in those folders that links in it lead to; None for too many."""
    folders, found = [folder], list[Path]()
    for place in folders:  # grows while links lead elsewhere
        for path in sorted(place.glob("*.yaml")):
            if not path.is_file():  # a pipe of that name must not be read
                continue
            found.append(path)
            leads_to = shown_path(path).parent
            if path.is_symlink() and leads_to not in folders:
                folders.append(leads_to)
        if len(found) > MOST_SHEETS:
            return None
    return found


def _content(path: Path) -> str:
    """A file's name and the digest of its content. Raises OSError, also for one that is too large to read every time."""
    with open(path, "rb") as file:
        data = file.read(LARGEST + 1)
    if len(data) > LARGEST:
        raise OSError("too large")
    return f"{path}={shown_path(path) if path.is_symlink() else ''}={hashlib.sha256(data).hexdigest()}"


@lru_cache(maxsize=1)
def code_fingerprint() -> str:
    """saoflow's code, Python, and the versions of all that is installed: what another version kept is not found."""
    root = str(SHIPPED.parent)
    files = []
    for folder, inner, names in os.walk(root):
        inner[:] = [name for name in inner if name != "__pycache__"]
        for name in names:
            status = os.stat(path := os.path.join(folder, name))
            files.append(f"{path[len(root) :]} {status.st_size} {status.st_mtime_ns}")
    return digest(sys.version, root, *sorted(files), "\1", *_installed())


def _installed() -> list[str]:
    """Names and versions of the installed distributions, as their folders say them."""
    found = set[str]()
    for place in (place or "." for place in sys.path):
        if os.path.isdir(place):
            found.update(name for name in os.listdir(place) if name.endswith((".dist-info", ".egg-info")))
    return sorted(found)
