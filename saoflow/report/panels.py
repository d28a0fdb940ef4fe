"""Panels of curves over time: one figure a quantity, one panel a run, all with the same time axis.

Curves are labelled where they end, in a gutter at the right of each panel, so no legend is needed.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from saoflow.report.contents import Array, Mark
from saoflow.report.style import LIGHT

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

WIDTH, LEFT, GUTTER, TOP, BOTTOM = 10.0, 0.62, 0.98, 0.34, 0.42
"""Inches: the same in every figure, so that instants stand below each other."""


TEXT = {"faint": "soft"}
"""Words need more contrast than lines."""

LineStyle = str | tuple[float, tuple[float, ...]]


@dataclass(frozen=True, eq=False)
class Curve:
    """``values`` (frames,) or (frames, several), with a label at the end and a role of :data:`LIGHT`.

    ``style`` is matplotlib's line style; ``steps`` draws a stair.
    """

    values: Array
    label: str
    role: str
    width: float = 1.1
    style: LineStyle = "-"
    steps: bool = False


@dataclass(frozen=True)
class Level:
    """A horizontal line across the panel: a threshold or a bound."""

    value: float
    label: str


@dataclass(frozen=True)
class Dot:
    """A point worth noticing."""

    time: float
    value: float


@dataclass(frozen=True, eq=False)
class Panel:
    """One run's picture of one quantity."""

    title: str
    curves: tuple[Curve, ...]
    levels: tuple[Level, ...] = ()
    marks: tuple[Mark, ...] = ()
    dots: tuple[Dot, ...] = ()
    ticks: tuple[tuple[float, str], ...] = ()
    """Values with a name of their own instead of numbers."""


@dataclass(frozen=True, eq=False)
class Plot:
    """One figure: a quantity with its unit, the panels side by side, the height of a panel [in]."""

    quantity: str
    panels: tuple[Panel, ...]
    height: float = 1.7
    y_limits: tuple[float, float] | None = None
    logarithmic: bool = False


def draw(plot: Plot, time: Array) -> Figure:
    """The figure of one plot; ``time`` (frames,) [s]. Call inside :func:`saoflow.report.style.style`."""
    from matplotlib.figure import Figure

    height = TOP + plot.height + BOTTOM
    figure = Figure(figsize=(WIDTH, height))
    columns = len(plot.panels)
    width = (WIDTH - LEFT - GUTTER * columns) / columns
    limits = limits_of_plot(plot)
    for i, panel in enumerate(plot.panels):
        left = LEFT + i * (width + GUTTER)
        box = (left / WIDTH, BOTTOM / height, width / WIDTH, plot.height / height)
        axes = figure.add_axes(box)
        draw_panel(axes, panel, time, limits, plot.logarithmic)
        if i == 0:
            axes.set_ylabel(plot.quantity)
        else:
            axes.tick_params(labelleft=bool(panel.ticks))
    return figure


def draw_panel(axes: Axes, panel: Panel, time: Array, limits: tuple[float, float], logarithmic: bool = False) -> None:
    """One panel on its axes."""
    begin, end = float(time[0]), float(time[-1])
    axes.set_xlim(begin, end if end != begin else begin + 1.0)
    if logarithmic:
        axes.set_yscale("log")
    axes.set_ylim(*limits)
    axes.set_xlabel("time [s]", labelpad=2)
    axes.set_title(panel.title, loc="left", color=LIGHT["ink"], fontweight="bold", pad=14 if panel.marks else 5)
    labels: list[tuple[float, str, str]] = []
    for level in panel.levels:
        axes.axhline(level.value, color=LIGHT["limit"], linewidth=0.8, linestyle=(0, (4, 2.5)))
        labels.append((level.value, level.label, "limit"))
    for curve in panel.curves:
        _curve(axes, curve, time, logarithmic)
        left = None if logarithmic else _leaves(curve, limits)
        if curve.label and left is not None:
            _label_where_it_leaves(axes, curve, float(time[left]), limits)
        elif curve.label:
            labels.append((_end(curve, logarithmic), curve.label, curve.role))
    for dot in panel.dots:
        axes.plot([dot.time], [dot.value], "o", markersize=4.2, color=LIGHT["limit"], zorder=5)
    if panel.ticks:
        axes.set_yticks([value for value, _ in panel.ticks], [text for _, text in panel.ticks])
    _marks(axes, panel.marks, time)
    _end_labels(axes, labels, limits, logarithmic)


def _curve(axes: Axes, curve: Curve, time: Array, logarithmic: bool) -> None:
    values = curve.values if curve.values.ndim == 2 else curve.values[:, None]
    if logarithmic:
        # Many values are exactly zero, so that a line would mostly show its way down to them.
        shown = np.where(values > 0.0, values, np.nan)
        axes.plot(time, shown, ".", markersize=2.2, markeredgewidth=0, color=LIGHT[curve.role])
        return
    for column in values.T:
        axes.plot(
            time,
            column,
            color=LIGHT[curve.role],
            linewidth=curve.width,
            linestyle=curve.style,
            drawstyle="steps-post" if curve.steps else "default",
        )


def _end(curve: Curve, logarithmic: bool) -> float:
    """Where the curve ends: the last finite value, the mean of several; of scattered dots their middle."""
    if logarithmic:
        positive = curve.values[curve.values > 0.0]
        return float(np.median(positive)) if positive.size else 0.0
    values = _middle(curve)
    finite = values[np.isfinite(values)]
    return float(finite[-1]) if finite.size else 0.0


def _middle(curve: Curve) -> Array:
    """The curve, or the mean of those of several that are finite; NaN where none is."""
    values = curve.values.reshape(len(curve.values), -1)
    finite = np.isfinite(values)
    count = finite.sum(axis=1)
    mean: Array = np.where(count > 0, np.where(finite, values, 0.0).sum(axis=1) / np.maximum(count, 1), np.nan)
    return mean


def _leaves(curve: Curve, limits: tuple[float, float]) -> int | None:
    """The frame from which the curve is outside the axis to its end; None if it ends inside."""
    values = _middle(curve)
    inside = np.flatnonzero((values >= limits[0]) & (values <= limits[1]))
    return None if not inside.size or inside[-1] == len(values) - 1 else int(inside[-1])


def _label_where_it_leaves(axes: Axes, curve: Curve, time: float, limits: tuple[float, float]) -> None:
    axes.annotate(
        curve.label,
        (time, limits[1]),
        xytext=(6, -2),
        textcoords="offset points",
        ha="left",
        va="top",
        fontsize=7.5,
        color=LIGHT[TEXT.get(curve.role, curve.role)],
    )


def _marks(axes: Axes, marks: Sequence[Mark], time: Array) -> None:
    """Vertical lines with words above the panel; words that would meet go left and right of their lines."""
    span = float(time[-1] - time[0]) or 1.0
    for i, mark in enumerate(sorted(marks, key=lambda m: m.time)):
        axes.axvline(mark.time, color=LIGHT["soft"], linewidth=0.6, zorder=1)
        crowded = i + 1 < len(marks) and sorted(m.time for m in marks)[i + 1] - mark.time < 0.22 * span
        late = mark.time - float(time[0]) > 0.8 * span
        axes.annotate(
            mark.text,
            (mark.time, 1.0),
            xycoords=("data", "axes fraction"),
            xytext=(-2 if crowded or late else 2, 3),
            textcoords="offset points",
            ha="right" if crowded or late else "left",
            va="bottom",
            fontsize=7,
            color=LIGHT["soft"],
        )


def _end_labels(
    axes: Axes, labels: list[tuple[float, str, str]], limits: tuple[float, float], logarithmic: bool
) -> None:
    """Labels beside the right edge at the height of what they name, moved apart where they would touch."""
    if not labels:
        return
    points = axes.bbox.height / axes.figure.dpi * 72
    scale = np.log10 if logarithmic else np.asarray
    low, high = (float(scale(limit)) for limit in limits)
    wanted = sorted(
        ((float(scale(min(max(y, limits[0]), limits[1]))) - low) / (high - low) * points, text, role)
        for y, text, role in labels
    )
    for y, (target, text, role) in zip(spread([w[0] for w in wanted]), wanted, strict=True):
        axes.annotate(
            text,
            (1.0, target / points),
            xycoords="axes fraction",
            xytext=(5, y - target),
            textcoords="offset points",
            ha="left",
            va="center",
            fontsize=7.5,
            color=LIGHT[TEXT.get(role, role)],
        )


def spread(positions: list[float], gap: float = 10.5) -> list[float]:
    """Rising positions [points] moved until they are ``gap`` apart."""
    placed = list(positions)
    for _ in range(60):
        moved = False
        for i in range(len(placed) - 1):
            short = gap - (placed[i + 1] - placed[i])
            if short > 1e-6:
                placed[i] -= short / 2
                placed[i + 1] += short / 2
                moved = True
        if not moved:
            break
    return placed


def limits_of_plot(plot: Plot) -> tuple[float, float]:
    """The plot's own limits, or room for every curve and level of all panels."""
    if plot.y_limits is not None:
        return plot.y_limits
    parts = [np.ravel(curve.values) for panel in plot.panels for curve in panel.curves]
    parts += [np.array([level.value for panel in plot.panels for level in panel.levels])]
    values = np.concatenate(parts)
    values = values[np.isfinite(values)]
    if not values.size:
        return 0.0, 1.0
    low, high = float(values.min()), float(values.max())
    margin = 0.06 * (high - low) or max(abs(high), 1.0) * 0.06
    return low - margin, high + margin
