"""The page of a report: HTML with styles and plots inside, nothing fetched from anywhere."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from saoflow.operations import COUNTED_KINDS
from saoflow.report.contents import Array, Arrays, Fact, Limits, Report, RunShown, TextTable
from saoflow.report.estimator import Shown, estimator_plots
from saoflow.report.icicle import draw_icicle
from saoflow.report.others import difference_plots, output_plots
from saoflow.report.panels import draw
from saoflow.report.style import css_colours, style, svg
from saoflow.whole_file import write_text

if TYPE_CHECKING:
    from saoflow.pipeline import LoadedSheet

PARAMETERS_OF_LIMITS = {
    "alpha_threshold": "alpha_threshold_deg",
    "vc_threshold": "vc_threshold_kt",
    "wx_max": "wx_bound_kt",
    "wz_max": "wz_bound_kt",
}
"""Parameters of a sheet, and the limits that they are in the plots."""


def report_of_run(sheet: LoadedSheet, inputs: Arrays, outputs: Arrays, time: Array | None = None) -> Report:
    """The report of one run of a sheet.

    ``inputs`` and ``outputs`` as the simulator takes and gives them, (frames, *shape); ``time`` (frames,) [s],
    else made from the sheet's frame period, else the number of the frame.
    """
    budget = sheet.budget()
    frames = len(next(iter(outputs.values())))
    ticks = np.arange(frames, dtype=np.float64) * (budget.period or 1.0)
    clock: Array = ticks if time is None else np.asarray(time, dtype=np.float64)
    return Report(
        title=f"{sheet.name}: {frames} frames",
        time=clock,
        runs=(RunShown(sheet.name, outputs),),
        inputs=inputs,
        limits=limits_of(sheet),
        budget=budget,
    )


def report_of_budget(sheet: LoadedSheet) -> Report:
    """The report of a sheet's budget alone: what a frame costs, and where."""
    budget = sheet.budget()
    limit = next((line.limit for line in budget.lines if line.kind == "operations"), None)
    space = "\N{NARROW NO-BREAK SPACE}"
    allowed = "" if limit is None else f" of {limit:,.0f} allowed".replace(",", space)
    text = f"{budget.total:,} operations a frame{allowed}".replace(",", space)
    fact = Fact(f"budget {sheet.name}", text, None if limit is None else not budget.over)
    return Report(title=f"{sheet.name}: the budget of a frame", time=np.zeros(0), runs=(), facts=(fact,), budget=budget)


def limits_of(sheet: LoadedSheet) -> Limits:
    """The thresholds and bounds among the parameters of a sheet, those of :data:`PARAMETERS_OF_LIMITS`."""
    found: dict[str, float] = {}
    for name, text in sheet.netlist.parameters:
        field = PARAMETERS_OF_LIMITS.get(name)
        if field is not None:
            try:
                found[field] = float(text.split()[0])
            except (ValueError, IndexError):
                continue
    return Limits(**found)


def render_report(report: Report, progress: Callable[[float], None] | None = None) -> str:
    """The whole page as text. ``progress`` is told the share of it that is done, 0 to 1."""
    import jinja2

    loader = jinja2.FileSystemLoader(Path(__file__).parent)
    environment = jinja2.Environment(loader=loader, autoescape=True, trim_blocks=True, lstrip_blocks=True)
    template = environment.get_template("page.html")
    return template.render(
        report=report,
        colours=css_colours(),
        plots=_drawn(report, progress or (lambda _: None)),
        budget_svg=_budget_svg(report),
        kinds=_kinds(report),
    )


def write_report(path: str | os.PathLike[str], report: Report, progress: Callable[[float], None] | None = None) -> None:
    """Write the page, all of it or nothing. Raises DiagnosisError E601 if the file cannot be written."""
    write_text(path, render_report(report, progress), "the report")


def _drawn(report: Report, progress: Callable[[float], None]) -> list[tuple[Shown, str]]:
    """The plots in the order of the page, each with its SVG; the budget's has no plot of its own."""
    if not report.runs:
        return []
    shown = estimator_plots(report) if all(run.is_estimator for run in report.runs) else output_plots(report)
    shown += difference_plots(report)
    drawn: list[tuple[Shown, str]] = []
    for i, one in enumerate(shown):
        with style(one.name), np.errstate(all="ignore"):  # numbers near the largest overflow in matplotlib's ticks
            drawn.append((one, svg(draw(one.plot, report.time), one.name, one.heading)))
        progress((i + 1) / (len(shown) + 1))
    progress(1.0)
    return drawn


def _budget_svg(report: Report) -> str:
    if report.budget is None:
        return ""
    with style("budget"):
        return svg(draw_icicle(report.budget), "budget", "The budget of a frame")


def _kinds(report: Report) -> TextTable | None:
    """Operations by kind as a table, with limits where the sheet states them."""
    budget = report.budget
    if budget is None:
        return None
    kinds = [kind for kind in COUNTED_KINDS if budget.tree.kinds[kind]]
    return TextTable(
        "Operations by kind",
        tuple(kinds),
        (tuple(f"{budget.tree.kinds[kind]:,}".replace(",", "\N{NARROW NO-BREAK SPACE}") for kind in kinds),),
        words=0,
    )
