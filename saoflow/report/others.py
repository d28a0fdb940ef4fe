"""Plots that any run has: its outputs one by one, the distance from a reference, and the budget of a frame."""

from __future__ import annotations

import re
from dataclasses import dataclass
from itertools import groupby
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
    """The distance from the reference over time, on a logarithmic axis; zeros are drawn at its foot."""
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
                Curve(np.maximum(values, low), label, role, 0.9)
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
    """One bar: a sub-sheet (or several instances of equal cost), its level in the tree, its operations a frame."""

    name: str
    level: int
    operations: int
    times: int = 1


def budget_rows(tree: CountTree, depth: int = 2, least: float = 0.005) -> list[BudgetRow]:
    """The tree as rows, costly parts first; equal instances of a fold as one; small parts are summed up in one row."""
    rows: list[BudgetRow] = []

    def visit(parts: list[tuple[str, CountTree, int]], level: int) -> None:
        small = [(name, part, n) for name, part, n in parts if part.total * n < least * tree.total]
        for name, part, n in sorted(parts, key=lambda p: -p[1].total * p[2]):
            if part.total * n < least * tree.total:
                continue
            rows.append(BudgetRow(name, level, part.total * n, n))
            below = _merged(part)
            if level + 1 < depth and len(below) > 1 and n == 1:
                visit(below, level + 1)
            elif level + 1 < depth and len(below) > 1:
                visit([(name_, part_, n_ * n) for name_, part_, n_ in below], level + 1)
        rest = sum(part.total * n for _, part, n in small)
        if rest:
            rows.append(BudgetRow(f"{len(small)} smaller" if len(small) > 1 else small[0][0], level, rest))

    visit(_merged(tree), 0)
    return rows


def _merged(tree: CountTree) -> list[tuple[str, CountTree, int]]:
    """Parts of a tree: instances of one fold with equal cost are one part, named ``ip[0..3]``."""
    parts = [part for part in tree.parts.values() if part.total]
    found = []
    for (base, _), group in groupby(parts, key=lambda p: (re.sub(r"\[\d+\]$", "", p.name), p.total)):
        same = list(group)
        first, last = same[0].name, same[-1].name
        name = first if len(same) == 1 else f"{base}[{first[len(base) + 1 : -1]}..{last[len(base) + 1 : -1]}]"
        found.append((name, same[0], len(same)))
    return found


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
        share = "" if y == 0 else f"   {100 * row.operations / budget.total:.0f} %"
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
