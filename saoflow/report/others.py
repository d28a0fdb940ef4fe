"""Plots that any run has: its outputs one by one, the distance from a reference, and the budget of a frame."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from saoflow.report.contents import Report
from saoflow.report.estimator import Shown
from saoflow.report.panels import LEFT, WIDTH, Curve, Panel, Plot
from saoflow.report.style import LIGHT
from saoflow.scheduler.budget import BudgetReport
from saoflow.scheduler.counts import CountTree

if TYPE_CHECKING:
    from matplotlib.figure import Figure

MOST_OUTPUTS = 40
"""Plots of a run that is no estimator: the first so many outputs."""


def output_plots(report: Report) -> list[Shown]:
    """One plot an output, its elements as curves."""
    names = list(dict.fromkeys(name for run in report.runs for name in run.outputs))[:MOST_OUTPUTS]
    shown = []
    for i, name in enumerate(names):
        panels = []
        for run in report.runs:
            flat = np.asarray(run.outputs[name], dtype=np.float64).reshape(len(report.time), -1)
            panels.append(Panel(run.label, (Curve(flat, name, "estimate", 1.0),), marks=(*report.marks, *run.marks)))
        shown.append(Shown(f"output{i}", name, "", Plot(name, tuple(panels), 1.3)))
    return shown


def difference_plots(report: Report) -> list[Shown]:
    """The distance from the reference over time, on a logarithmic axis; frames without any are left out."""
    if not report.differences:
        return []
    values = np.concatenate([np.ravel(v) for one in report.differences for v in one.curves.values()])
    positive = values[np.isfinite(values) & (values > 0.0)]
    if not positive.size:
        return []
    low = float(10.0 ** np.floor(np.log10(max(np.quantile(positive, 0.01), 1e-17))))
    high = float(10.0 ** np.ceil(np.log10(positive.max())))
    panels = tuple(
        Panel(
            one.quantity,
            tuple(
                Curve(values, label, role)
                for (label, values), role in zip(one.curves.items(), ("estimate", "soft", "faint"), strict=False)
            ),
            marks=report.marks,
        )
        for one in report.differences
    )
    plot = Plot("difference", panels, 1.4, (low, max(high, 10 * low)), logarithmic=True)
    return [Shown("differences", "Distance from the numpy reference", report.difference_note, plot)]


@dataclass(frozen=True)
class BudgetRow:
    """One bar: a sub-sheet or all instances of a fold, its level in the tree, its operations a frame."""

    name: str
    level: int
    operations: int


def budget_rows(tree: CountTree, depth: int = 4, least: float = 0.02) -> list[BudgetRow]:
    """The tree as rows, costly parts first; instances of a fold are one row, small parts are summed up in one."""
    rows: list[BudgetRow] = []

    def visit(trees: Sequence[CountTree], level: int) -> None:
        groups = _grouped(trees)
        large = [group for group in groups if group.operations >= least * tree.total]
        if not large or level >= depth:
            return
        for group in sorted(large, key=lambda g: -g.operations):
            rows.append(BudgetRow(group.name, level, group.operations))
            visit(group.trees, level + 1)
        rest = [group for group in groups if group not in large]
        if rest:
            name = rest[0].name if len(rest) == 1 else f"{len(rest)} smaller"
            rows.append(BudgetRow(name, level, sum(group.operations for group in rest)))

    visit([tree], 0)
    return rows


@dataclass(frozen=True, eq=False)
class _Group:
    """Parts that are one row: ``ip[0..3]``."""

    name: str
    trees: tuple[CountTree, ...]

    @property
    def operations(self) -> int:
        return sum(tree.total for tree in self.trees)


def _grouped(trees: Sequence[CountTree]) -> list[_Group]:
    """The parts of several instances together, by name without the index of the fold."""
    found: dict[str, list[CountTree]] = {}
    for tree in trees:
        for part in tree.parts.values():
            if part.total:
                found.setdefault(re.sub(r"\[\d+\]$", "", part.name), []).append(part)
    groups = []
    for base, parts in found.items():
        indices = sorted({int(i) for part in parts for i in re.findall(r"\[(\d+)\]$", part.name)})
        span = "" if not indices else f"[{indices[0]}]" if len(indices) == 1 else f"[{indices[0]}..{indices[-1]}]"
        groups.append(_Group(base + span, tuple(parts)))
    return groups


def draw_budget(budget: BudgetReport) -> Figure:
    """Bars of operations a frame by sub-sheet, and the total against the limit. Call inside ``style``."""
    from matplotlib.figure import Figure

    limit = next((line.limit for line in budget.lines if line.kind == "operations"), None)
    rows = [BudgetRow(f"{budget.sheet}, whole frame", 0, budget.total), *budget_rows(budget.tree)]
    bar, top, bottom, left = 0.185, 0.32, 0.42, 2.35
    height = top + bar * len(rows) + bottom
    figure = Figure(figsize=(WIDTH, height))
    axes = figure.add_axes((left / WIDTH, bottom / height, (WIDTH - left - LEFT) / WIDTH, bar * len(rows) / height))
    widest = max(budget.total, limit or 0)
    axes.set_xlim(0, 1.04 * widest)
    axes.set_ylim(len(rows) - 0.4, -0.6)
    for y, row in enumerate(rows):
        colour = LIGHT["estimate"] if y == 0 or row.level == 0 else LIGHT["faint"]
        over = y == 0 and limit is not None and budget.total > limit
        axes.barh(y, row.operations, height=0.62, color=LIGHT["limit"] if over else colour, linewidth=0)
        inside = row.operations > 0.85 * widest
        text = f"{row.operations:,}".replace(",", "\N{NARROW NO-BREAK SPACE}")
        share = "" if y == 0 else f" ({100 * row.operations / budget.total:.0f} %)"
        axes.annotate(
            text + share,
            (row.operations, y),
            xytext=(-4 if inside else 4, 0),
            textcoords="offset points",
            ha="right" if inside else "left",
            va="center",
            fontsize=7.5,
            color=LIGHT["paper"] if inside else LIGHT["soft"],
        )
        axes.annotate(
            row.name,
            (0, y),
            xytext=(-6 - (left - 0.12) * 72 + 14 * row.level, 0),
            textcoords="offset points",
            ha="left",
            va="center",
            fontsize=8,
            fontweight="bold" if y == 0 else "normal",
            color=LIGHT["ink"] if row.level == 0 else LIGHT["soft"],
            annotation_clip=False,
        )
    axes.set_yticks([])
    axes.spines["left"].set_visible(False)
    axes.set_xlabel("operations a frame", labelpad=2)
    if limit is not None:
        axes.axvline(limit, color=LIGHT["limit"], linewidth=0.9, linestyle=(0, (4, 2.5)))
        axes.annotate(
            f"budget {limit:,.0f}".replace(",", "\N{NARROW NO-BREAK SPACE}"),
            (limit, 1.0),
            xycoords=("data", "axes fraction"),
            xytext=(0, 3),
            textcoords="offset points",
            ha="center",
            va="bottom",
            fontsize=7.5,
            color=LIGHT["limit"],
        )
    return figure
