"""Plots that any run has: its outputs one by one, and the distance from a reference."""

from __future__ import annotations

import numpy as np

from saoflow.report.contents import Report
from saoflow.report.estimator import Shown
from saoflow.report.panels import Curve, Panel, Plot

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
