"""The picture of a campaign: how soon faults are found, which are, and from what size on."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from verification.campaigns.metrics import SheetMetrics, is_detectable
from verification.campaigns.row import Row
from verification.campaigns.summary import TUNING
from verification.campaigns.tables import NAMES
from verification.papers.style import COLOURS, LIMIT, SOFT, figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure

WIDTH, HEIGHT = 7.6, 4.9
SIZED = ("bias", "jamming", "oscillation")
"""Kinds whose amplitude can be held against the threshold."""
EDGES = tuple(2.0 ** (i / 2.0) for i in range(-6, 9))
"""Of amplitude over threshold, 1/8 to 16."""
FEWEST = 3
"""Faults that a point of a curve stands for, at least."""
MOST_POINTS = 400


@dataclass
class Seen:
    """What is gathered of one sheet, row by row."""

    delays: dict[str, list[float]] = field(default_factory=lambda: {sensor: [] for sensor in NAMES})
    """Of faults that must be found and were [s]."""
    must: dict[str, int] = field(default_factory=lambda: dict.fromkeys(NAMES, 0))
    sizes: np.ndarray = field(default_factory=lambda: np.zeros((3, len(EDGES) - 1, 2), dtype=np.int64))
    """By number of sensors and size: faults, and those found."""

    def add(self, row: Row) -> None:
        """Take in one run; one with a wind beyond the bounds, or that failed, is left out."""
        if row.failure or not row.wind_inside:
            return
        for sensor in NAMES:
            if not row.hit(sensor):
                continue
            if is_detectable(row, sensor):
                self.must[sensor] += 1
                if not row.missed(sensor):
                    self.delays[sensor].append(row.delay(sensor))
            kind, amplitude = (
                (row.alpha_kind, row.alpha_amplitude) if sensor == "alpha" else (row.vc_kind, row.vc_amplitude)
            )
            if kind in SIZED:
                threshold = TUNING.alpha_threshold if sensor == "alpha" else TUNING.vc_threshold
                place = int(np.searchsorted(EDGES, abs(amplitude) / threshold)) - 1
                if 0 <= place < len(EDGES) - 1:
                    self.sizes[len(row.hit(sensor)) - 1, place] += (1, not row.missed(sensor))


def seen_in(rows: Iterable[Row]) -> dict[str, Seen]:
    """By sheet, in order of their first runs."""
    found: dict[str, Seen] = {}
    for row in rows:
        found.setdefault(row.sheet, Seen()).add(row)
    return found


@contextmanager
def picture(metrics: Sequence[SheetMetrics], seen: dict[str, Seen]) -> Iterator[Figure]:
    """The figure, four panels for each sheet, drawn; save it inside."""
    with figure(WIDTH, HEIGHT * len(metrics)) as drawn:
        axes = drawn.subplots(2 * len(metrics), 2, squeeze=False)
        for i, sheet in enumerate(metrics):
            title = sheet.sheet if len(metrics) > 1 else ""
            (delays, sizes), bars = axes[2 * i], axes[2 * i + 1]
            _delays(delays, seen[sheet.sheet], title)
            _sizes(sizes, seen[sheet.sheet])
            for axis, sensor in zip(bars, NAMES, strict=True):
                _kinds(axis, sheet, sensor)
        yield drawn


def _delays(axis: Any, seen: Seen, title: str) -> None:
    for colour, (sensor, name) in zip(COLOURS, NAMES.items(), strict=False):
        delays = np.sort(seen.delays[sensor])
        if len(delays):
            share = 100.0 * np.arange(1, len(delays) + 1) / seen.must[sensor]
            few = np.unique(np.linspace(0, len(delays) - 1, MOST_POINTS).astype(int))
            axis.step(
                np.maximum(delays[few], 0.02),
                share[few],
                where="post",
                color=colour,
                label=f"{name} ({seen.must[sensor]})",
            )
    axis.set_xscale("log")
    axis.set_ylim(0.0, 102.0)
    axis.set_xlabel("delay [s]")
    axis.set_ylabel("of those that must be found [%]")
    axis.set_title(f"{title}: found within" if title else "Found within", loc="left")
    if seen.delays["alpha"] or seen.delays["vc"]:
        axis.legend(loc="lower right")


def _sizes(axis: Any, seen: Seen) -> None:
    centres = np.sqrt(np.array(EDGES[1:]) * np.array(EDGES[:-1]))
    for number, marker in ((1, "o"), (2, "s"), (3, "^")):
        faults, found = seen.sizes[number - 1].T
        there = faults >= FEWEST
        if there.any():
            label = f"{number} sensor{'s' if number > 1 else ''}"
            axis.plot(
                centres[there], 100.0 * found[there] / faults[there], marker=marker, markersize=3.5, color=COLOURS[number - 1],
                label=label,
            )  # fmt: skip
    axis.axvline(1.0, color=LIMIT, linestyle="--", linewidth=0.9)
    axis.set_xscale("log", base=2)
    axis.set_ylim(0.0, 102.0)
    axis.set_xlabel("amplitude over threshold")
    axis.set_ylabel("found [%]")
    axis.set_title("Bias, jamming, oscillation: found", loc="left")
    if axis.lines and len(axis.lines) > 1:
        axis.legend(loc="lower right")


def _kinds(axis: Any, sheet: SheetMetrics, sensor: str) -> None:
    groups = [group for group in sheet.kinds if group.name.endswith(f" {sensor}") and group.runs]
    names = [group.name.split()[0].replace("_", " ") for group in groups]
    figures = [group.figures(sensor) for group in groups]
    parts = (
        ("found", [f.hit - f.missed for f in figures], COLOURS[0]),
        ("missed, need not be found", [f.missed - f.detectable_missed for f in figures], SOFT),
        ("missed, must be found", [f.detectable_missed for f in figures], LIMIT),
    )
    left = np.zeros(len(groups))
    for label, counts, colour in parts:
        shares = np.array([100.0 * n / max(f.hit, 1) for n, f in zip(counts, figures, strict=True)])
        axis.barh(names, shares, left=left, color=colour, height=0.62, label=label)
        left += shares
    axis.invert_yaxis()
    axis.set_xlim(0.0, 100.0)
    axis.set_xlabel("runs [%]")
    axis.set_title(NAMES[sensor], loc="left")
    axis.grid(False, axis="y")
    if sensor == "vc":
        axis.tick_params(labelleft=False)  # the kinds stand at the panel beside it
    if sensor == "vc" and groups:
        axis.legend(loc="upper center", bbox_to_anchor=(0.0, -0.24), ncols=3)


def is_empty(seen: dict[str, Seen]) -> bool:
    """Whether there is nothing to draw: no run with a fault."""
    return not any(sum(s.must.values()) or int(s.sizes.sum()) for s in seen.values())
