"""What a verification found: frozen data, its verdict, and its machine-readable form."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from typing import Any

from saoflow.tables.tabulate import TableError


@dataclass(frozen=True)
class Place:
    """Where a difference was found."""

    scenario: str
    frame: int
    """Counted from the first frame of the scenario; -1: what is remembered before it."""
    recording_frame: int
    element: tuple[int, ...]
    """Indices from 0; empty for a scalar."""
    sheet: float
    reference: float

    def __str__(self) -> str:
        element = f"[{', '.join(map(str, self.element))}]" if self.element else ""
        return f"{self.scenario}, frame {self.frame}{element}: {self.sheet:.9g}, reference {self.reference:.9g}"


@dataclass(frozen=True)
class Check:
    """One compared quantity."""

    part: str
    quantity: str
    wire: str
    unit: str
    largest: float
    """The absolute difference at ``where``."""
    ratio: float
    """The largest difference relative to what is allowed: above 1 the check fails."""
    tolerance: str
    frames: int
    """In how many frames it was compared."""
    where: Place | None
    passed: bool | None
    """None: shown, without a verdict."""
    repeat: str = ""
    """Which of several quantities of one name."""

    @property
    def title(self) -> str:
        """The quantity and which of several it is."""
        return f"{self.quantity} ({self.repeat})" if self.repeat else self.quantity


@dataclass(frozen=True)
class OtherChoice:
    """A frame in which rounding let a choice fall otherwise."""

    choice: str
    where: Place
    margin: float
    excused: bool


@dataclass(frozen=True)
class OtherDecision:
    """The first frame of a scenario in which a decision of the closed loop differs."""

    output: str
    scenario: str
    frame: int
    element: tuple[int, ...]
    measure: float
    threshold: float
    unit: str
    excused: bool


@dataclass(frozen=True)
class Report:
    """All findings of one verification."""

    sheet: str
    reference: str
    frames: int
    seed: int
    scenarios: tuple[str, ...]
    checks: tuple[Check, ...]
    other_choices: tuple[OtherChoice, ...]
    other_decisions: tuple[OtherDecision, ...]
    tables: tuple[TableError, ...]
    seconds: float

    @property
    def passed(self) -> bool:
        """Whether every check with a verdict holds."""
        return all(check.passed is not False for check in self.checks)

    @property
    def failures(self) -> tuple[Check, ...]:
        """The checks that fail, in the order in which a frame computes them."""
        return tuple(check for check in self.checks if check.passed is False)

    @property
    def summary(self) -> str:
        """One line: the verdict, and where to look first."""
        if self.passed:
            count = sum(check.passed is True for check in self.checks)
            return f"{self.sheet} equals its reference: {count} checks hold in {self.frames} frames"
        first = self.failures[0]
        where = f", at {first.where}" if first.where else ""
        return (
            f"{self.sheet} differs from its reference: {len(self.failures)} of {len(self.checks)} checks fail; "
            f"first in the order of the frame: {first.title}, wire {first.wire}{where}"
        )

    def to_dict(self) -> dict[str, Any]:
        """The machine-readable form (``--json``); infinity is the text "inf"."""
        plain = {"passed": self.passed, "summary": self.summary} | asdict(self)
        result: dict[str, Any] = _json_safe(plain)
        return result


def _json_safe(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _json_safe(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_json_safe(item) for item in value]
    if isinstance(value, float) and not math.isfinite(value):
        return str(value)
    return value
