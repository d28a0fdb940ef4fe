"""The picture of the README, made from a run of the demonstration: ``python -m verification.demo.picture``.

Airspeed, residual and horizontal wind, CMHE-FTE beside UMHE-FTE, as in Fig. 4 of paper 004.
"""

from __future__ import annotations

import argparse
import io
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from saoflow.report.estimator import estimator_plots
from saoflow.report.panels import BOTTOM, GUTTER, LEFT, TOP, WIDTH, draw_panel, limits_of_plot
from saoflow.report.style import LIGHT, style
from saoflow.whole_file import write_whole
from verification.demo.files import page_of
from verification.demo.result import DemoResult
from verification.demo.run import run_demo
from verification.demo.scenario import Scenario

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SHOWN = ("airspeed", "vc_rms", "wx")
HEIGHT = 1.55
"""Inches of a panel."""


def picture(result: DemoResult) -> Figure:
    """The figure: a row for each quantity of :data:`SHOWN`, a column for each estimator. Call inside ``style``."""
    from matplotlib.figure import Figure

    report = page_of(result, Path("out"))
    plots = {shown.name: shown.plot for shown in estimator_plots(report)}
    row = HEIGHT + 0.22
    height = TOP + row * len(SHOWN) + BOTTOM
    width = (WIDTH - LEFT - 2 * GUTTER) / 2
    figure = Figure(figsize=(WIDTH, height), facecolor=LIGHT["paper"])
    for i, name in enumerate(SHOWN):
        plot = plots[name]
        for j, panel in enumerate(plot.panels):
            left, bottom = LEFT + j * (width + GUTTER), height - TOP - HEIGHT - i * row
            axes = figure.add_axes((left / WIDTH, bottom / height, width / WIDTH, HEIGHT / height))
            axes.set_facecolor("none")
            if i:
                # What the vertical lines are stands above the first row.
                panel = replace(panel, title="", marks=tuple(replace(mark, text="") for mark in panel.marks))
            draw_panel(axes, panel, report.time, limits_of_plot(plot))
            if i < len(SHOWN) - 1:
                axes.set_xlabel("")
                axes.tick_params(labelbottom=False)
            if j:
                axes.tick_params(labelleft=False)
            else:
                axes.set_ylabel(plot.quantity)
    return figure


def write_picture(result: DemoResult, path: str | Path) -> None:
    """Write the picture as PNG, all of it or nothing."""
    drawn = io.BytesIO()
    with style("picture"):
        picture(result).savefig(drawn, format="png", dpi=150, metadata={"Software": None})
    write_whole(path, drawn.getvalue())


def main() -> None:
    """Run the demonstration and write its picture."""
    parser = argparse.ArgumentParser(description="The README's picture, from a run of the demonstration.")
    parser.add_argument("-o", "--output", default="docs/demo.png")
    write_picture(run_demo(Scenario()), parser.parse_args().output)


if __name__ == "__main__":
    main()
