"""Which curves show a run of an air-data estimator (outputs as those of ``cmhe_fte``), in the order of the page."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from saoflow.report.contents import Arrays, Mark, Report, RunShown
from saoflow.report.panels import Curve, Dot, Level, LineStyle, Panel, Plot

DEGREES = 180.0 / np.pi
DASHED: LineStyle = (0, (3, 2))
ROMAN = ((1.0, "I"), (2.0, "II"), (3.0, "III"), (4.0, "IV"))


@dataclass(frozen=True, eq=False)
class Shown:
    """A plot with its heading and what to see in it."""

    name: str
    heading: str
    caption: str
    plot: Plot


def estimator_plots(report: Report) -> list[Shown]:
    """The plots of runs that all are estimators. Truth, inputs and limits are drawn where the report has them."""
    return [
        _airspeed(report),
        _residual(report, "vc", "kt", 1.0, report.limits.vc_threshold_kt),
        _wind(report, "wx", "Horizontal wind", "tail wind positive", report.limits.wx_bound_kt),
        *_airspeed_error(report),
        _alpha(report),
        _residual(report, "alpha", "deg", DEGREES, report.limits.alpha_threshold_deg),
        _wind(report, "wz", "Vertical wind", "positive down", report.limits.wz_bound_kt),
        _configuration(report),
    ]


def confirmations(run: RunShown, sensor: str) -> list[int | None]:
    """The frame at which each sensor ("alpha", "vc") is confirmed faulty, None for never."""
    latched = np.asarray(run.outputs[f"{sensor}_faulty"]) > 0.5
    return [int(np.argmax(column)) if column.any() else None for column in latched.T]


def _remark(report: Report, name: str) -> str:
    return f" {report.remarks[name]}" if name in report.remarks else ""


def _marks(report: Report, run: RunShown) -> tuple[Mark, ...]:
    return (*report.marks, *run.marks)


def _airspeed(report: Report) -> Shown:
    def panel(run: RunShown) -> Panel:
        curves = _given(report.inputs, "vc", "sensors", "faint", 0.7)
        curves += _given(report.truth, "vc", "truth", "truth", 0.8, DASHED)
        curves.append(Curve(run.outputs["vc_hat"], "estimate", "estimate", 1.3))
        return Panel(run.label, tuple(curves), marks=_marks(report, run))

    flown = ", what the aircraft flew," if "vc" in report.truth else ""
    return Shown(
        "airspeed",
        "Calibrated airspeed",
        f"What the three sensors read{flown} and what the estimator makes of it.",
        Plot("airspeed [kt]", tuple(panel(run) for run in report.runs), 2.1),
    )


def _airspeed_error(report: Report) -> list[Shown]:
    if "vc" not in report.truth:
        return []
    panels = tuple(
        Panel(
            run.label,
            (Curve(run.outputs["vc_hat"] - report.truth["vc"], "error", "estimate", 1.1),),
            marks=_marks(report, run),
        )
        for run in report.runs
    )
    caption = "Estimate minus truth." + _remark(report, "airspeed_error")
    return [Shown("airspeed_error", "Error of the airspeed estimate", caption, Plot("error [kt]", panels, 1.5))]


def _residual(report: Report, sensor: str, unit: str, factor: float, threshold: float | None) -> Shown:
    levels = () if threshold is None else (Level(threshold, f"threshold {threshold:g}"),)

    def panel(run: RunShown) -> Panel:
        rms = factor * np.asarray(run.outputs[f"{sensor}_rms"])
        found = confirmations(run, sensor)
        dots = tuple(Dot(float(report.time[k]), float(rms[k, i])) for i, k in enumerate(found) if k is not None)
        return Panel(run.label, (Curve(rms, "rms, 3 sensors", "estimate", 0.9),), levels, _marks(report, run), dots)

    panels = tuple(panel(run) for run in report.runs)
    # A condemned sensor's residual goes on growing; what matters happens near the threshold.
    peak = max(float(np.nanmax(curve.values)) for p in panels for curve in p.curves)
    top = peak if threshold is None else min(peak, 5.0 * threshold)
    name = {"vc": "airspeed", "alpha": "angle-of-attack"}[sensor]
    caption = f"Root mean square over the evaluation window, of each {name} sensor."
    if any(p.dots for p in panels):
        caption += " A dot marks the frame in which a sensor is confirmed faulty."
    if top < peak:
        caption += " The axis is cut where a condemned sensor's residual goes on growing."
    plot = Plot(f"residual rms [{unit}]", panels, 1.7, (-0.04 * top, 1.06 * max(top, 1.1 * (threshold or 0.0))))
    return Shown(f"{sensor}_rms", f"Residual of the {name} sensors", caption, plot)


def _wind(report: Report, name: str, heading: str, sign: str, bound: float | None) -> Shown:
    levels = (
        () if bound is None else (Level(bound, f"bound {bound:g}"), Level(-bound, f"bound \N{MINUS SIGN}{bound:g}"))
    )

    def panel(run: RunShown) -> Panel:
        curves = _given(report.truth, name, "truth", "truth", 0.8, DASHED)
        curves.append(Curve(run.outputs[f"{name}_hat"], "estimate", "estimate", 1.2))
        return Panel(run.label, tuple(curves), levels, _marks(report, run))

    caption = f"Estimate and the bounds assumed for the weather, {sign}."
    caption += _remark(report, name)
    panels = tuple(panel(run) for run in report.runs)
    return Shown(name, heading, caption, Plot("wind [kt]", panels, 1.9 if name == "wx" else 1.4))


def _alpha(report: Report) -> Shown:
    def panel(run: RunShown) -> Panel:
        curves = _given(report.inputs, "alpha", "sensors", "faint", 0.35, factor=DEGREES)
        curves.append(Curve(DEGREES * run.outputs["alpha_hat"], "estimate", "estimate", 1.1))
        curves += _given(report.truth, "alpha", "truth", "truth", 0.8, DASHED, factor=DEGREES)
        return Panel(run.label, tuple(curves), marks=_marks(report, run))

    panels = tuple(panel(run) for run in report.runs)
    caption = "Sensors, truth and estimate." if "alpha" in report.truth else "Sensors and estimate."
    return Shown("alpha", "Angle of attack", caption, Plot("angle of attack [deg]", panels, 1.5))


def _configuration(report: Report) -> Shown:
    panels = tuple(
        Panel(
            run.label,
            (Curve(np.asarray(run.outputs["configuration"]), "", "estimate", 1.6, steps=True),),
            marks=_marks(report, run),
            ticks=ROMAN,
        )
        for run in report.runs
    )
    caption = (
        "Which measurements the estimator still uses: I all, II without angle of attack, III without airspeed, "
        "IV without either (Table I of the paper)."
    )
    return Shown("configuration", "Configuration", caption, Plot("configuration", panels, 0.8, (0.6, 4.4)))


def _given(
    columns: Arrays, name: str, label: str, role: str, width: float, style: LineStyle = "-", factor: float = 1.0
) -> list[Curve]:
    """The curve of a column that the report may not have."""
    return [Curve(factor * np.asarray(columns[name]), label, role, width, style)] if name in columns else []
