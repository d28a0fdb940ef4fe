"""What a frame of built C costs, as its header, its README and ``saoflow build`` tell it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from saoflow.operations import COUNTED_KINDS
from saoflow.scheduler.budget import BudgetReport


@dataclass(frozen=True, slots=True)
class Cost:
    """Operations by kind of the dearest frame; ``frames``: of every frame until the rates repeat, empty if all are alike."""

    kinds: Mapping[str, int]
    frames: tuple[int, ...]

    @property
    def total(self) -> int:
        """All operations of the dearest frame."""
        return sum(self.kinds.values())

    @property
    def which(self) -> str:
        """Which frame is meant, to be put behind a number; empty if all are alike."""
        if not self.frames:
            return ""
        return f" in the dearest of {len(self.frames)} frames, {sum(self.frames) / len(self.frames):.1f} in the mean"

    @property
    def headline(self) -> str:
        """``5 operations a frame``, with which of them."""
        return f"{self.total} operation{'' if self.total == 1 else 's'}{self.which or ' a frame'}"


def cost_of(report: BudgetReport) -> Cost:
    """The cost that the budget is held against."""
    kinds = report.tree.kinds
    return Cost({kind: kinds[kind] for kind in COUNTED_KINDS if kinds[kind]}, report.frames)
