"""Writing a file whole or not at all."""

from __future__ import annotations

import contextlib
import errno
import os
import shlex
from pathlib import Path

from saoflow.diagnosis import refusal


def write_whole(path: str | os.PathLike[str], content: bytes) -> None:
    """Write beside the file, then give it its name; nothing is left behind if that fails. Raises OSError."""
    target = Path(path)
    if not target.name:
        raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR))
    temporary = target.with_name(f".{target.name}.{os.getpid()}.part")
    try:
        temporary.write_bytes(content)
        os.replace(temporary, target)
    finally:
        with contextlib.suppress(OSError):
            temporary.unlink()


def write_text(path: str | os.PathLike[str], text: str, what: str) -> None:
    """Write a text whole; ``what`` names it in the diagnosis. Raises DiagnosisError E601 if it cannot be written."""
    target = Path(path)
    try:
        write_whole(target, text.encode("utf-8"))
    except OSError as error:
        raise refusal(
            "E601",
            f"{target}: {what} cannot be written",
            cause=error.strerror or str(error),
            remedy=remedy_of(error, "name a file in a folder that exists and that you may write to"),
        ) from None


def check_ending(path: str | os.PathLike[str], ending: str, what: str, remedy: str = "") -> None:
    """Raise DiagnosisError E601 for a file whose name belongs to another kind: a sheet is not overwritten by its page."""
    target = Path(path)
    if target.suffix.lower() != ending:
        better = remedy or f"write {shlex.quote(str(target.with_suffix(ending)))}" if target.name else "name a file"
        raise refusal("E601", f"{path}: cannot be written", cause=f"the name of {what} ends in {ending}", remedy=better)


def remedy_of(error: OSError, otherwise: str) -> str:
    """What to do about a file that cannot be written: a full disk needs room, not another name."""
    return "make room, or write to another disk" if error.errno in (errno.ENOSPC, errno.EDQUOT) else otherwise
