"""The picture of a comparison: accuracy and detection against operations and time a frame, with what no other beats."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from verification.comparison.compare import Comparison, Entry, pareto
from verification.papers.style import COLOURS, LIMIT, SOFT, figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure

WIDTH, ROW = 7.6, 2.15
COSTS = (("operations", "operations a frame"), ("microseconds", "us a frame in C, here"))
MOST_LABELS = 16


@dataclass(frozen=True)
class Quality:
    """What is drawn upwards: a field of `Entry`, its axis, and whether more of it is better."""

    field: str
    axis: str
    more_is_better: bool = False


QUALITIES = (
    Quality("alpha_error_faulty", "mean error of AOA [deg]"),
    Quality("vc_error_faulty", "mean error of VCAS [kt]"),
    Quality("found", "faults found [%]", True),
    Quality("delay", "mean delay [s]"),
)
"""All over the faulty runs."""


@contextmanager
def picture(comparison: Comparison) -> Iterator[Figure]:
    """The figure, drawn; save it inside."""
    with figure(WIDTH, ROW * len(QUALITIES)) as drawn:
        axes = drawn.subplots(len(QUALITIES), len(COSTS), squeeze=False)
        for row, quality in zip(axes, QUALITIES, strict=True):
            for axis, (cost, label) in zip(row, COSTS, strict=True):
                _panel(axis, comparison, cost, quality)
                if quality is QUALITIES[-1]:
                    axis.set_xlabel(label)
            row[0].set_ylabel(quality.axis)
        yield drawn


def _panel(axis: Any, comparison: Comparison, cost: str, quality: Quality) -> None:
    best = pareto(comparison.entries, cost, quality.field, quality.more_is_better)
    x, y = ([getattr(entry, name) for entry in best] for name in (cost, quality.field))
    axis.step(x, y, where="post", color=SOFT, linewidth=0.8, zorder=1)
    if comparison.budget is not None and cost == "operations":
        axis.axvline(comparison.budget, color=LIMIT, linestyle="--", linewidth=0.9)
    families = list(dict.fromkeys(entry.label.split("[")[0] for entry in comparison.entries))
    farthest = max(getattr(entry, cost) for entry in comparison.entries)
    for number, entry in enumerate(sorted(comparison.entries, key=lambda e: float(getattr(e, cost)))):
        colour = COLOURS[families.index(entry.label.split("[")[0]) % len(COLOURS)]
        face = "none" if entry.fits is False else colour
        at = getattr(entry, cost), getattr(entry, quality.field)
        if at[1] != at[1]:
            continue
        axis.plot(*at, marker="o", markersize=5, color=colour, markerfacecolor=face, linestyle="none")
        if len(comparison.entries) <= MOST_LABELS:
            side = "right" if at[0] > 0.85 * farthest else "left"
            place = (-4 if side == "right" else 4, 4 if number % 2 else -9)  # neighbours above and below
            axis.annotate(
                _short(entry), at, xytext=place, textcoords="offset points", ha=side, fontsize=6.5, color=SOFT
            )
    axis.margins(0.15)
    axis.set_xlim(left=0.0)


def _short(entry: Entry) -> str:
    """The parameters alone stand beside a variant; the table has the rest."""
    name, bracket, rest = entry.label.partition("[")
    return rest.rstrip("]") if bracket else name
