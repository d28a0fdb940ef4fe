"""Text files in blocks of whole lines: a file of any length takes the memory of one block."""

from __future__ import annotations

import gzip
import os
from collections.abc import Iterator
from typing import IO

from saoflow.diagnosis import DiagnosisError
from saoflow.recordings.table import extension, nothing_in, unreadable

BLOCK = 1 << 21
"""Bytes that are read together; a block ends with the line that it ends in."""
MOST_LINE = 1 << 24
"""Bytes of a line, at most."""


class Text:
    """A text file, unpacked if it is compressed, line by line or by what is left of a block.

    Raises DiagnosisError E501 (not text, or a line too long), E103 (no bytes), and OSError.
    """

    def __init__(self, path: str) -> None:
        self.path = path
        self.line = 1
        """The number of the line that comes next."""
        self._size = os.stat(path).st_size
        self._disk = open(path, "rb")  # noqa: SIM115  closed by close()
        self._file: IO[bytes] = (
            gzip.GzipFile(fileobj=self._disk) if extension(path) == ".csv.gz" else self._disk  # type: ignore[assignment]
        )
        self._block = b""
        self._at = 0

    def close(self) -> None:
        """Close the file."""
        self._file.close()
        self._disk.close()

    @property
    def share(self) -> float:
        """The share of the file that is read, 0 to 1."""
        return min(1.0, self._disk.tell() / max(1, self._size))

    @property
    def left(self) -> bool:
        """Whether the present block has lines left."""
        return self._at < len(self._block)

    def more(self) -> bool:
        """Whether there is a line left; reads the next block if this one is done."""
        if self.left:
            return True
        beginning = self.line == 1 and not self._block
        block = self._file.read(BLOCK)
        if block and not block.endswith(b"\n"):
            block += self._file.readline(MOST_LINE)
            if len(block) >= MOST_LINE and not block.endswith(b"\n") and self._file.read(1):
                number = self.line + block.count(b"\n")
                cause = f"line {number} is longer than {MOST_LINE // 2**20} MiB"
                raise unreadable(self.path, cause, "save it as text with a line for each frame")
        if beginning and not block:
            raise DiagnosisError([nothing_in(self.path, "E103", "the recording is empty", "there are no bytes in it")])
        self._check(block)
        self._block, self._at = block, 0
        return bool(block)

    def next_line(self) -> bytes:
        """The next line, or no bytes at the end of the file."""
        if not self.more():
            return b""
        end = self._block.find(b"\n", self._at) + 1 or len(self._block)
        found = self._block[self._at : end]
        self._at = end
        self.line += 1
        return found

    def rest(self) -> bytes:
        """What is left of the present block, whole lines; it stays there until :meth:`skip`."""
        return self._block[self._at :] if self._at else self._block

    def skip(self) -> None:
        """Go to the end of the present block."""
        self.line += self._block.count(b"\n", self._at) + (not self._block.endswith(b"\n"))
        self._at = len(self._block)

    def _check(self, block: bytes) -> None:
        if b"\0" in block:
            line = self.line + block.count(b"\n", 0, block.index(b"\0"))
            cause = f"line {line} holds a null character: this is no text"
            raise unreadable(self.path, cause, "give it the extension of what it is")
        if not block.isascii():
            try:
                block.decode("utf-8")
            except UnicodeDecodeError as error:
                line = self.line + block.count(b"\n", 0, error.start)
                raise unreadable(
                    self.path,
                    f"line {line} holds the byte 0x{block[error.start]:02x}, which is not UTF-8 text",
                    "save the file as UTF-8 text, or give it the extension of what it is",
                ) from None


class Lines:
    """The lines of a text as a CSV reader takes them, kept for messages while their rows are at work."""

    def __init__(self, text: Text) -> None:
        self.text = text
        self.kept: list[str] = []
        self.first = text.line
        """The number of the first line that is kept."""
        self.strange = False
        """Whether a line since the last :meth:`forget` holds what ``float`` reads and we do not: ``1_000``."""

    def __iter__(self) -> Iterator[str]:
        while raw := self.text.next_line():
            line = raw.decode("utf-8-sig" if self.text.line == 2 else "utf-8")
            if not line.isascii() or "_" in line:
                self.strange = True
            self.kept.append(line)
            yield line

    def forget(self) -> None:
        """Drop the lines of the rows that are done."""
        self.first = self.text.line
        self.kept.clear()
        self.strange = False

    def line(self, number: int) -> str:
        """The text of a line that is kept."""
        index = number - self.first
        return self.kept[index].rstrip("\r\n") if 0 <= index < len(self.kept) else ""
