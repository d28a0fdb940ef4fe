"""cppcheck with its MISRA C:2012 addon; accepted findings are listed with reasons in ``docs/misra_accepted.txt``.

Each line there is ``rule | pattern | reason``: a finding of that rule is accepted when the pattern (a regular expression)
is found in the line of code that it is about. Any other finding fails; an entry that accepts nothing any more is named.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from verification.cleanliness.checks import Found
from verification.cleanliness.subjects import Subject
from verification.cleanliness.tools import run

ACCEPTED = Path(__file__).resolve().parents[2] / "docs" / "misra_accepted.txt"


@dataclass(frozen=True, slots=True)
class Accepted:
    """A finding that is accepted, and why."""

    rule: str
    pattern: str
    reason: str
    line: int


def read_accepted(path: Path = ACCEPTED) -> list[Accepted]:
    """The list. Raises ValueError with the line that is not ``rule | pattern | reason``."""
    entries: list[Accepted] = []
    for number, text in enumerate(path.read_text(encoding="utf-8").splitlines(), 1):
        if not text.strip() or text.startswith("#"):
            continue
        parts = [part.strip() for part in text.split(" | ")]
        if len(parts) != 3 or not all(parts):
            raise ValueError(f"{path}:{number}: write `rule | pattern | reason`, not: {text}")
        try:
            re.compile(parts[1])
        except re.error as problem:
            raise ValueError(f"{path}:{number}: the pattern {parts[1]!r} is not valid: {problem}") from None
        entries.append(Accepted(parts[0], parts[1], parts[2], number))
    return entries


class Misra:
    """One run of the addon over several sheets; remembers which entries of the list were needed."""

    def __init__(self, entries: Iterable[Accepted]) -> None:
        self.entries = list(entries)
        self.needed: set[Accepted] = set()

    def look(self, subject: Subject) -> Found:
        """Every finding of cppcheck in one sheet's source and header."""
        command = (
            "cppcheck",
            "--std=c99",
            "--addon=misra",
            "--enable=style",
            "--check-level=reduced",
            "--performance-valueflow-max-time=0",
            "--suppress=missingIncludeSystem",
            "--quiet",
            "--template={file}:{line}:{severity}:{id}:{message}",
            subject.source.name,
        )
        done = run(command, subject.folder)
        if done.code:
            return Found(done.complaint())
        return self.judge(done.err, subject.folder, subject.drawn)

    def judge(self, said: str, folder: Path, drawn: bool = False) -> Found:
        """What of cppcheck's words is not accepted. ``folder`` holds the files that they are about.

        ``drawn``: the sheet is a random one. Such sheets compare wires with themselves and the like, and the C does as the
        sheet says, so that cppcheck's remarks on style are left aside; its errors, warnings and MISRA are not.
        """
        lines: dict[str, list[str]] = {}
        findings: list[str] = []
        accepted = 0
        for text in dict.fromkeys(said.splitlines()):
            parts = text.split(":", 4)
            if len(parts) != 5 or not parts[1].isdigit():
                if text.strip():
                    findings.append(text)
                continue
            file, number, severity, rule, message = parts
            if drawn and severity == "style" and not rule.startswith("misra"):
                continue
            if file and file not in lines:
                lines[file] = (folder / file).read_text(encoding="ascii").splitlines()
            code = lines[file][int(number) - 1] if file and int(number) else ""
            entry = next((e for e in self.entries if e.rule == rule and re.search(e.pattern, code)), None)
            if entry is None:
                findings.append(f"{file}:{number}: {rule}: {_brief(message)}: {code.strip()[:100]}")
            else:
                self.needed.add(entry)
                accepted += 1
        return Found(findings, f"{accepted} accepted", accepted)

    def unneeded(self) -> list[Accepted]:
        """Entries that accepted nothing."""
        return [e for e in self.entries if e not in self.needed]


def _brief(message: str) -> str:
    """Without the hint at the texts of the rules, which are not free to be shipped."""
    return message.partition(" (use --rule-texts")[0]
