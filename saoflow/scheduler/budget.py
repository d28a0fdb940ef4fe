"""Budgets: what a frame costs against what it may cost."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

from saoflow.diagnosis import Diagnosis, DiagnosisError, Note, Position
from saoflow.diagrams.netlist import Netlist
from saoflow.operations import COUNTED_KINDS, Kind
from saoflow.scheduler.counts import CountTree, count, frame_loads
from saoflow.scheduler.program import FrameProgram, RunRate
from saoflow.scheduler.rate_frames import frame_of


@dataclass(frozen=True, slots=True)
class BudgetLine:
    """One limit: a kind of operation, or ``operations`` for the total. ``limit`` None: not limited."""

    kind: str
    used: int
    limit: float | None

    @property
    def over(self) -> bool:
        """Whether the frame exceeds the limit."""
        return self.limit is not None and self.used > self.limit


@dataclass(frozen=True, slots=True)
class TableCost:
    """What a look-up costs inside: the points of its table and the steps of a binary search."""

    name: str
    points: int
    uses: int
    """How many look-ups a frame does."""
    search_steps: int
    """Comparisons of a binary search for the interval, along all axes."""


@dataclass(frozen=True, slots=True, eq=False)
class BudgetReport:
    """Operations of one frame by kind and by sub-sheet. ``str`` gives the table for a terminal."""

    sheet: str
    lines: tuple[BudgetLine, ...]
    tree: CountTree
    period: float | None
    state_slots: int
    procedures: int
    tables: tuple[TableCost, ...]
    position: Position | None
    frames: tuple[int, ...] = ()
    """Operations of every frame of the hyperperiod; the tree is that of the dearest. Empty: all frames are alike."""
    rates: tuple[RunRate, ...] = ()
    """What runs at a rate of its own."""

    @property
    def worst(self) -> int:
        """The dearest frame of the hyperperiod, from 0; its first, if several cost the same."""
        return self.frames.index(max(self.frames)) if self.frames else 0

    @property
    def total(self) -> int:
        """All counted operations of a frame."""
        return self.tree.total

    @property
    def over(self) -> bool:
        """Whether any limit is exceeded."""
        return any(line.over for line in self.lines)

    def raise_if_over(self) -> None:
        """Raise DiagnosisError E401, naming the sub-sheets that cost most, if a limit is exceeded."""
        found = [self._diagnosis(line) for line in self.lines if line.over]
        if found:
            raise DiagnosisError(found)

    def _diagnosis(self, line: BudgetLine) -> Diagnosis:
        assert line.limit is not None
        what = "operations" if line.kind == "operations" else f"`{line.kind}` operations"
        costly = sorted(self.tree.parts.values(), key=lambda part: -_of(part, line.kind))[:3]
        notes = tuple(Note(f"{part.name} costs {_of(part, line.kind)}") for part in costly if _of(part, line.kind))
        return Diagnosis(
            "E401",
            f"a frame of `{self.sheet}` is over budget: {line.used} {what}, {line.limit:g} allowed",
            self.position,
            f"{line.used - line.limit:g} too many",
            "make the costly sub-sheets cheaper, or raise the budget; `saoflow budget` shows which costs what",
            notes=notes,
        )

    def rows(self, depth: int = 3) -> Iterator[tuple[int, CountTree]]:
        """The sub-sheets down to a depth, each with its level; instances of a fold one by one."""
        stack = [(0, self.tree)]
        while stack:
            level, tree = stack.pop()
            yield level, tree
            if level < depth:
                stack.extend((level + 1, part) for part in reversed(tree.parts.values()) if part.total)

    def to_dict(self) -> dict[str, object]:
        """The machine-readable form."""
        return {
            "sheet": self.sheet,
            "operations": self.total,
            "over": self.over,
            "period_s": self.period,
            "lines": [{"kind": x.kind, "used": x.used, "limit": x.limit, "over": x.over} for x in self.lines],
            "tree": self.tree.to_dict(),
            "frames": list(self.frames),
            "rates": [{"path": r.path, "every": r.every, "offset": r.offset, "balanced": r.balanced} for r in self.rates],
            "state_slots": self.state_slots,
            "procedures": self.procedures,
            "tables": [
                {"name": t.name, "points": t.points, "uses": t.uses, "search_steps": t.search_steps}
                for t in self.tables
            ],
        }

    def __str__(self) -> str:
        which = f" in frame {self.worst}, the dearest of {len(self.frames)}" if self.frames else " a frame"
        out = [f"{self.sheet}: {self.total} operations{which}"]
        for line in self.lines:
            limit = "" if line.limit is None else f" of {line.limit:g}{'  OVER BUDGET' if line.over else ''}"
            out.append(f"  {line.kind:<12}{line.used:>8}{limit}")
        out.append("by sub-sheet:")
        out += [f"  {'  ' * level}{tree.name:<{36 - 2 * level}}{tree.total:>8}" for level, tree in self.rows(2)]
        return "\n".join(out)


def _of(tree: CountTree, kind: str) -> int:
    return tree.total if kind == "operations" else tree.kinds[kind]


def budget_report(program: FrameProgram, netlist: Netlist) -> BudgetReport:
    """Count a program against the budget of its root sheet."""
    loads, rates = frame_loads(program), program.rates
    frames = loads["operations"]
    program = frame_of(program, frames.index(max(frames)))
    tree = count(program)
    declared = netlist.root.structure.budget
    limits = dict(declared.limits) if declared is not None else {}
    kinds = ["operations", *(kind for kind in COUNTED_KINDS if kind in loads or kind in limits)]
    lines = tuple(BudgetLine(kind, max(loads.get(kind, [0])), limits.get(kind)) for kind in kinds)
    uses = [0] * len(program.tables)
    for body, times in _times(program):
        for op in body:
            uses[op] += times
    tables = tuple(
        TableCost(
            table.name,
            int(table.values.size),
            n,
            sum(max(0, math.ceil(math.log2(len(axis)))) for axis in table.breakpoints),
        )
        for table, n in zip(program.tables, uses, strict=True)
    )
    return BudgetReport(
        program.sheet,
        lines,
        tree,
        None if declared is None else declared.period,
        len(program.states),
        len(program.procedures),
        tables,
        None if declared is None else declared.position,
        tuple(frames) if rates else (),
        rates,
    )


def _times(program: FrameProgram) -> Iterator[tuple[list[int], int]]:
    """The tables that each body looks up, and how often a frame runs the body."""
    bodies = program.bodies
    times = [0] * len(program.procedures) + [1] * len(program.groups)
    for i in range(len(bodies) - 1, -1, -1):
        for op in bodies[i].operations:
            if op.kind is Kind.CALL:
                times[op.detail] += times[i]
    for body, n in zip(bodies, times, strict=True):
        yield [op.detail for op in body.operations if op.kind is Kind.LOOKUP], n
