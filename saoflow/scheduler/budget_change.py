"""What changed between two budgets, and where: by kind, and by sub-sheet and block."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from saoflow.operations import COUNTED_KINDS
from saoflow.scheduler.budget import BudgetReport
from saoflow.scheduler.counts import CountTree


@dataclass(frozen=True, slots=True)
class KindChange:
    """Operations of one kind, or ``operations`` for the total, with the limit that now holds."""

    kind: str
    before: int
    after: int
    limit: float | None


@dataclass(frozen=True, slots=True)
class PartChange:
    """A sub-sheet or block that costs more or less than before; 0 where it is not there."""

    path: str
    level: int
    before: int
    after: int


@dataclass(frozen=True, slots=True, eq=False)
class BudgetChange:
    """Two budgets side by side. ``before`` is what is compared with."""

    before: BudgetReport
    after: BudgetReport
    before_name: str
    kinds: tuple[KindChange, ...]
    parts: tuple[PartChange, ...]
    """Changed parts, each followed by the changed parts inside it, larger changes first."""

    @property
    def same(self) -> bool:
        """Whether nothing costs more or less."""
        return not self.parts and all(kind.before == kind.after for kind in self.kinds)

    def to_dict(self) -> dict[str, object]:
        """The machine-readable form."""
        return {
            "sheet": self.after.sheet,
            "before": self.before_name,
            "operations_before": self.before.total,
            "operations": self.after.total,
            "over": self.after.over,
            "same": self.same,
            "kinds": [{"kind": k.kind, "before": k.before, "after": k.after, "limit": k.limit} for k in self.kinds],
            "parts": [{"path": p.path, "before": p.before, "after": p.after} for p in self.parts],
        }


def compare_budgets(before: BudgetReport, after: BudgetReport, before_name: str, depth: int = 4) -> BudgetChange:
    """Compare two budgets; parts down to a depth."""
    old = {line.kind: line.used for line in before.lines}
    new = {line.kind: line for line in after.lines}
    kinds = []
    for kind in ("operations", *COUNTED_KINDS):
        if kind in old or kind in new:
            line = new.get(kind)
            kinds.append(KindChange(kind, old.get(kind, 0), line.used if line else 0, line.limit if line else None))
    parts = tuple(_changed(before.tree, after.tree, "", 0, depth))
    return BudgetChange(before, after, before_name, tuple(kinds), parts)


def _changed(before: CountTree, after: CountTree, path: str, level: int, depth: int) -> Iterator[PartChange]:
    if level >= depth:
        return
    pairs = []
    for name in dict.fromkeys((*after.parts, *before.parts)):
        old, new = before.parts.get(name) or CountTree(name), after.parts.get(name) or CountTree(name)
        if old.kinds != new.kinds:
            pairs.append((old, new))
    for old, new in sorted(pairs, key=lambda pair: -abs(pair[1].total - pair[0].total)):
        here = f"{path}.{new.name}" if path else new.name
        yield PartChange(here, level, old.total, new.total)
        yield from _changed(old, new, here, level + 1, depth)
