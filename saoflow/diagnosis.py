"""Diagnoses: what saoflow says when something is wrong, where, why, and what to do about it.

Every diagnosis has a stable code from the registry below. A stage collects all that it can find
(:class:`Diagnoses`) and raises them together as one :class:`DiagnosisError`.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field

from saoflow.codes import CODES


@dataclass(frozen=True, slots=True)
class Position:
    """A place in a text file: 1-based line and column, and how many characters are meant."""

    file: str
    line: int
    column: int
    length: int = 1

    def __str__(self) -> str:
        return f"{self.file}:{self.line}:{self.column}"


@dataclass(frozen=True, slots=True)
class Note:
    """A further place that helps to understand a diagnosis (a step of a loop, an earlier definition)."""

    text: str
    position: Position | None = None


@dataclass(frozen=True, slots=True)
class Diagnosis:
    """One finding: a registered code, where, what, why, and the way out."""

    code: str
    message: str
    position: Position | None = None
    cause: str = ""
    remedy: str = ""
    label: str = ""
    """What stands beside the caret."""
    notes: tuple[Note, ...] = ()
    source_line: str | None = None
    """The text of the line at ``position``, where it is known."""

    def __post_init__(self) -> None:
        if self.code not in CODES:
            raise KeyError(f"diagnosis code {self.code} is not registered")

    @property
    def severity(self) -> str:
        """``error`` or ``warning``, by the first letter of the code."""
        return "warning" if self.code.startswith("W") else "error"

    def render(self) -> str:
        """The diagnosis as the command line prints it, without a trailing newline."""
        head = f"{self.position}: " if self.position else ""
        lines = [f"{head}{self.severity}[{self.code}]: {self.message}"]
        if self.position and self.source_line is not None:
            number = str(self.position.line)
            text, column = _window(self.source_line, self.position.column)
            marked = text[column - 1 : column - 1 + self.position.length]
            caret = "^" * max(1, len(_blank(marked)))
            lines.append(f" {number} | {text}")
            lines.append(f" {' ' * len(number)} | {_blank(text[: column - 1])}{caret} {self.label}".rstrip())
        if self.cause:
            lines.append(f"    = cause: {self.cause}")
        for note in self.notes:
            place = f" ({note.position})" if note.position else ""
            lines.append(f"    = note: {note.text}{place}")
        if self.remedy:
            lines.append(f"    = remedy: {self.remedy}")
        return "\n".join(lines)

    def to_dict(self) -> dict[str, object]:
        """The machine-readable form (``--json``)."""
        where = self.position
        return {
            "code": self.code,
            "severity": self.severity,
            "message": self.message,
            "file": where.file if where else None,
            "line": where.line if where else None,
            "column": where.column if where else None,
            "length": where.length if where else None,
            "cause": self.cause,
            "remedy": self.remedy,
            "notes": [
                {"text": note.text, "position": str(note.position) if note.position else None} for note in self.notes
            ],
        }


def _window(text: str, column: int, width: int = 160) -> tuple[str, int]:
    """Cut a very long line to the part around ``column``; returns the part and the column inside it."""
    start = max(0, column - width // 2) if len(text) > width else 0
    # A tab is a space, and no control character of a file reaches the terminal.
    shown = "".join(c if c.isprintable() else " " if c == "\t" else "\N{REPLACEMENT CHARACTER}" for c in text[start : start + width])
    return shown, column - start


def _blank(text: str) -> str:
    """Spaces as wide as a text: letters of some alphabets take two columns, combining marks none."""
    if text.isascii():
        return " " * len(text)
    from rich.cells import cell_len

    return " " * cell_len(text)


class DiagnosisError(Exception):
    """Raised at the end of a stage that found errors; carries all of them, in order of position."""

    def __init__(self, diagnoses: Sequence[Diagnosis]) -> None:
        self.diagnoses = tuple(diagnoses)
        super().__init__("\n".join(d.render() for d in self.diagnoses))


def refusal(code: str, message: str, *, cause: str, remedy: str) -> DiagnosisError:
    """The exception of one diagnosis without a position, to be raised."""
    return DiagnosisError([Diagnosis(code, message, cause=cause, remedy=remedy)])


def unknown_name(code: str, message: str, name: str, known: Sequence[str], *, what: str, otherwise: str) -> DiagnosisError:
    """The exception of a name that is none of those known, to be raised. ``what`` they are; ``otherwise``: without a near one."""
    remedy = did_you_mean(name, known) or otherwise
    return refusal(code, message, cause=f"{what} are {', '.join(known)}", remedy=remedy)


@dataclass(slots=True)
class Diagnoses:
    """Collects what a stage finds, so that it can report everything at once."""

    _found: dict[Diagnosis, None] = field(default_factory=dict)

    def add(self, diagnosis: Diagnosis) -> None:
        """Remember one finding; the same finding at the same place is kept once."""
        self._found.setdefault(diagnosis)

    def extend(self, diagnoses: Iterable[Diagnosis]) -> None:
        """Remember several findings."""
        for diagnosis in diagnoses:
            self.add(diagnosis)

    @property
    def found(self) -> list[Diagnosis]:
        """All of them, in order of finding."""
        return list(self._found)

    @property
    def errors(self) -> list[Diagnosis]:
        """Those that are errors, not warnings."""
        return [d for d in self._found if d.severity == "error"]

    def raise_if_errors(self) -> None:
        """Raise :class:`DiagnosisError` with everything found if any of it is an error."""
        if self.errors:
            raise DiagnosisError(in_order(self.found))


def in_order(diagnoses: Iterable[Diagnosis]) -> list[Diagnosis]:
    """Sort by file, line and column; those without a position come last."""

    def key(d: Diagnosis) -> tuple[bool, str, int, int]:
        p = d.position
        return (p is None, p.file if p else "", p.line if p else 0, p.column if p else 0)

    return sorted(diagnoses, key=key)


def did_you_mean(word: str, candidates: Iterable[str]) -> str:
    """``did you mean `x`?`` for the nearest candidate, or for one that the word begins; else an empty string."""
    import difflib

    names = sorted(set(candidates))
    near = difflib.get_close_matches(word, names, n=3, cutoff=0.6)
    # Of candidates that are equally near, the one that begins alike.
    ratio = {name: round(difflib.SequenceMatcher(None, word, name).ratio(), 6) for name in near}
    near.sort(key=lambda name: (-ratio[name], -_alike(word, name)))
    if not near:
        near = [name for name in names if name.lower() == word.lower()][:1]
    if not near and len(word) > 2:
        near = [name for name in names if name.lower().startswith(word.lower())][:1]
    return f"did you mean `{near[0]}`?" if near else ""


def _alike(a: str, b: str) -> int:
    """How many characters two words have in common at their beginning."""
    return next((i for i, (x, y) in enumerate(zip(a, b, strict=False)) if x != y), min(len(a), len(b)))
