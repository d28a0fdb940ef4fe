"""What every diagnosis code means: cause, an example that gives it, remedy.

An explanation is the file ``examples/CODE.yaml``; what its example says stands beside it in ``examples/CODE.txt``, written
by :mod:`saoflow.authoring.catalogue` from a run of the example, never by hand.

    cause: TEXT
    remedy: TEXT
    files: {NAME: TEXT}     what the example needs
    without: PACKAGE        what must not be installed for it
    run: COMMANDS           one a line; the last one gives the diagnosis
    how: TEXT               in place of `run`, for what no command can be made to give
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from saoflow.codes import CODES

EXAMPLES = Path(__file__).parent / "examples"


@dataclass(frozen=True, slots=True)
class ExampleFile:
    """A file that an example needs."""

    name: str
    text: str


@dataclass(frozen=True, slots=True)
class Explanation:
    """One code in full."""

    code: str
    title: str
    """Its line in the registry."""
    cause: str
    remedy: str
    files: tuple[ExampleFile, ...]
    commands: tuple[str, ...]
    without: str
    """A package that is not installed in the example; empty for most."""
    how: str
    """How it comes about, if no command can be made to give it."""
    message: str
    """What the last command says."""

    @property
    def severity(self) -> str:
        """``error`` or ``warning``."""
        return "warning" if self.code.startswith("W") else "error"

    def to_dict(self) -> dict[str, object]:
        """The machine-readable form."""
        return {
            "code": self.code,
            "severity": self.severity,
            "title": self.title,
            "cause": self.cause,
            "remedy": self.remedy,
            "example": {
                "files": [{"name": file.name, "text": file.text} for file in self.files],
                "without": self.without,
                "commands": list(self.commands),
                "message": self.message,
                "how": self.how,
            },
        }


@cache
def explanation(code: str) -> Explanation:
    """The explanation of a registered code. Raises KeyError for another, OSError if its file is missing."""
    import yaml

    title = CODES[code]
    read = yaml.safe_load((EXAMPLES / f"{code}.yaml").read_text(encoding="utf-8"))
    said = EXAMPLES / f"{code}.txt"
    return Explanation(
        code,
        title,
        read["cause"].strip(),
        read["remedy"].strip(),
        tuple(ExampleFile(name, text) for name, text in read.get("files", {}).items()),
        tuple(line for line in read.get("run", "").split("\n") if line),
        read.get("without", ""),
        read.get("how", "").strip(),
        said.read_text(encoding="utf-8").rstrip("\n") if said.exists() else "",
    )


def explanations() -> Iterator[Explanation]:
    """All of them, in the order of the registry."""
    return map(explanation, CODES)
