"""Standard output and error, whose failures are told from those of every other file."""

from __future__ import annotations

import io
import os
import sys
from typing import TYPE_CHECKING, TextIO

if TYPE_CHECKING:
    from _typeshed import ReadableBuffer


class StreamError(OSError):
    """A standard stream cannot be written: its disk is full, for example."""

    def __init__(self, stream: int, cause: OSError) -> None:
        super().__init__(cause.errno, cause.strerror)
        self.stream = stream
        """1 for standard output, 2 for standard error."""


class _Raw(io.FileIO):
    def write(self, data: ReadableBuffer, /) -> int:
        try:
            return super().write(data)
        except BrokenPipeError:
            raise
        except OSError as error:
            raise StreamError(self.fileno(), error) from None


def guard() -> None:
    """Put streams in place that raise :class:`StreamError`. One that the shell has closed (``>&-``) takes all and holds nothing."""
    sys.stdout, sys.stderr = _guarded(sys.stdout, 1), _guarded(sys.stderr, 2)


def _guarded(stream: TextIO | None, number: int) -> TextIO:
    if stream is None:
        return open(os.devnull, "w", encoding="utf-8")
    raw = _Raw(number, "w", closefd=False)
    lines = number == 2 or stream.isatty()
    errors = stream.errors
    if errors in ("strict", "surrogateescape"):
        # A terminal that lacks our bars and arrows shows question marks; names of files pass as they are.
        errors = "surrogateescape" if stream.encoding.lower().replace("-", "") == "utf8" else "replace"
    return io.TextIOWrapper(io.BufferedWriter(raw), encoding=stream.encoding, errors=errors, line_buffering=lines)


def silence(number: int) -> None:
    """What is still to be written to a stream goes nowhere, so that Python can end in peace."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), number)
