"""The operations of a frame as an icicle: a slab per sub-sheet, below the slab of the sheet that uses it, as wide as its cost."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from saoflow.report.panels import WIDTH
from saoflow.report.style import LIGHT
from saoflow.scheduler.budget import BudgetReport
from saoflow.scheduler.counts import CountTree

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

SLAB, GAP = 0.27, 0.018
"""Height of a slab and of the gap below it [in]."""
LETTER = 3.9
"""Width of a letter of a slab's text [pt], with some to spare."""


@dataclass(frozen=True, slots=True)
class Slab:
    """A sub-sheet or block, or all instances of a fold: its level, where it begins, and its operations a frame."""

    name: str
    level: int
    start: int
    operations: int
    group: int
    """Which part of the root it belongs to, the costliest first."""
    small: bool = False
    """Several small parts in one."""


def slabs(tree: CountTree, depth: int = 6, least: float = 0.004) -> list[Slab]:
    """The tree as slabs: costly parts first, instances of a fold in one, parts below ``least`` of the frame in one."""
    found = [Slab(tree.name, 0, 0, tree.total, -1)]

    def visit(trees: Sequence[CountTree], level: int, start: int, group: int) -> None:
        if level > depth:
            return
        parts = sorted(_grouped(trees), key=lambda part: -part.operations)
        large = [part for part in parts if part.operations >= least * tree.total]
        for number, part in enumerate(large):
            own = number if group < 0 else group
            found.append(Slab(part.name, level, start, part.operations, own))
            visit(part.trees, level + 1, start, own)
            start += part.operations
        rest = parts[len(large) :]
        if rest and large:
            operations = sum(part.operations for part in rest)
            own = len(large) if group < 0 else group
            found.append(Slab(f"{len(rest)} smaller", level, start, operations, own, True))

    visit([tree], 1, 0, -1)
    return found


@dataclass(frozen=True, eq=False)
class _Part:
    """Parts of one name, without the index of the fold: ``ip[0..3]``."""

    name: str
    trees: tuple[CountTree, ...]

    @property
    def operations(self) -> int:
        return sum(tree.total for tree in self.trees)


def _grouped(trees: Sequence[CountTree]) -> list[_Part]:
    found: dict[str, list[CountTree]] = {}
    for tree in trees:
        for part in tree.parts.values():
            if part.total:
                found.setdefault(re.sub(r"\[\d+\]$", "", part.name), []).append(part)
    parts = []
    for base, members in found.items():
        indices = sorted({int(i) for part in members for i in re.findall(r"\[(\d+)\]$", part.name)})
        span = "" if not indices else f"[{indices[0]}]" if len(indices) == 1 else f"[{indices[0]}..{indices[-1]}]"
        parts.append(_Part(base + span, tuple(members)))
    return parts


def draw_icicle(budget: BudgetReport) -> Figure:
    """The icicle of a frame, against the budget if the sheet states one. Call inside ``style``."""
    from matplotlib.figure import Figure

    limit = next((line.limit for line in budget.lines if line.kind == "operations"), None)
    shown = slabs(budget.tree)
    levels = 1 + max(slab.level for slab in shown)
    top, bottom, side = 0.26, 0.40, 0.10
    height = top + bottom + levels * (SLAB + GAP)
    figure = Figure(figsize=(WIDTH, height))
    axes = figure.add_axes((side / WIDTH, bottom / height, 1 - 2 * side / WIDTH, 1 - (top + bottom) / height))
    widest = max(budget.total, limit or 0, 1)
    axes.set_xlim(0, widest * 1.002)
    axes.set_ylim(levels * (SLAB + GAP), 0)
    points = (WIDTH - 2 * side) * 72 / (widest * 1.002)
    for slab in shown:
        _draw(axes, slab, points, over=slab.level == 0 and limit is not None and budget.total > limit)
    if limit is not None:
        _draw_limit(axes, budget.total, limit)
    axes.set_yticks([])
    axes.spines["left"].set_visible(False)
    axes.set_xlabel("operations a frame", labelpad=2)
    return figure


def _draw(axes: Axes, slab: Slab, points: float, over: bool) -> None:
    y = slab.level * (SLAB + GAP)
    colour = LIGHT["limit"] if over else LIGHT["faint"] if slab.small else LIGHT["estimate"]
    strength = 0.85 if slab.level == 0 else 0.30 if slab.small else 0.22 + 0.34 / (1 + slab.group)
    axes.barh(
        y + SLAB / 2,
        max(slab.operations - 1.2 / points, 0.4 / points),
        left=slab.start,
        height=SLAB,
        color=colour,
        alpha=strength,
        linewidth=0,
    )
    number = f"{slab.operations:,}".replace(",", "\N{NARROW NO-BREAK SPACE}")
    room = slab.operations * points - 6
    letters = int(room / LETTER)
    brief = slab.name[: letters - 1] + "…" if letters >= 5 else ""
    text = next((t for t in (f"{slab.name}  {number}", slab.name) if len(t) <= letters), brief)
    if text:
        axes.annotate(
            text,
            (slab.start, y + SLAB / 2),
            xytext=(3, 0),
            textcoords="offset points",
            va="center",
            fontsize=7.0,
            fontweight="bold" if slab.level == 0 else "normal",
            color=LIGHT["paper"] if slab.level == 0 else LIGHT["ink"],
        )


def _draw_limit(axes: Axes, total: int, limit: float) -> None:
    text = f"budget {limit:,.0f}".replace(",", "\N{NARROW NO-BREAK SPACE}")
    if total < limit:
        axes.barh(SLAB / 2, limit - total, left=total, height=SLAB, color="none", edgecolor=LIGHT["faint"], linewidth=0.6)
        free = f"{limit - total:,.0f} free".replace(",", "\N{NARROW NO-BREAK SPACE}")
        axes.annotate(
            free, ((total + limit) / 2, SLAB / 2), ha="center", va="center", fontsize=7.0, color=LIGHT["soft"]
        )
    axes.axvline(limit, color=LIGHT["limit"], linewidth=0.9, linestyle=(0, (4, 2.5)))
    axes.annotate(
        text,
        (limit, 1.0),
        xycoords=("data", "axes fraction"),
        xytext=(0, 3),
        textcoords="offset points",
        ha="right" if limit >= total else "center",
        va="bottom",
        fontsize=7.5,
        color=LIGHT["limit"],
    )
