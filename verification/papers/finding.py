"""One claim of a paper, what was measured, and the verdict."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum


class Verdict(StrEnum):
    """What became of a claim. Computed from measured numbers by the code that makes the finding, never typed in."""

    HOLDS = "holds"
    ONLY_IF = "holds only if"
    FAILS = "does not hold"
    NOT_HERE = "cannot be made here"


@dataclass(frozen=True)
class Finding:
    """A figure, table or theorem of a paper beside what saoflow measured.

    Raises ValueError where a condition is missing (:attr:`Verdict.ONLY_IF`, :attr:`Verdict.NOT_HERE`) or has no place.
    """

    paper: str
    """Three digits, "003"."""
    item: str
    """As the paper calls it: "Fig. 4", "Table I", "Theorem 1"."""
    title: str
    """A few words."""
    claim: str
    """The paper's claim, in our words."""
    verdict: Verdict
    condition: str
    """What must hold (:attr:`Verdict.ONLY_IF`), or why it cannot be made (:attr:`Verdict.NOT_HERE`); else empty."""
    text: str
    """Markdown: what was run, the numbers and tables, why it comes out so. No heading above level 4."""
    pictures: tuple[str, ...] = ()
    """Names of files written into the document's folder."""

    def __post_init__(self) -> None:
        wanted = self.verdict in (Verdict.ONLY_IF, Verdict.NOT_HERE)
        if wanted != bool(self.condition):
            raise ValueError(
                f"{self.paper} {self.item}: `{self.verdict}` {'needs a' if wanted else 'has no'} condition"
            )

    @property
    def judgement(self) -> str:
        """Verdict and condition as one phrase."""
        if self.verdict is Verdict.NOT_HERE:
            return f"{self.verdict}: {self.condition}"
        return f"{self.verdict} {self.condition}".rstrip()
