"""The pictures of paper 004's figures."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from verification.flights import load_recording
from verification.papers.air_data_runs import (
    BOUND,
    DEGREES,
    NAMES,
    SHEETS,
    SLOW,
    THRESHOLDS,
    WIND,
    WX_MAX,
    Rate,
    Robustness,
    Runaway,
    jammed,
    run,
)
from verification.papers.style import COLOURS, LIMIT, SOFT, TRUTH, figure, save
from verification.results.fig4 import NOT_WITHIN

COLOUR = dict(zip(SHEETS, COLOURS, strict=False))


def draw_fig_3(rows: Sequence[Robustness], pictures: Path) -> None:
    """The wind, and the largest residuals of every sheet in every scenario."""
    at = {(r.scenario, r.sheet): r for r in rows}
    scenarios, shown = (list(dict.fromkeys(getattr(r, key) for r in rows)) for key in ("scenario", "sheet"))
    with figure(7.6, 2.6) as drawn:
        winds, *panels = drawn.subplots(1, 3)
        truth = load_recording(WIND)
        time = np.arange(len(truth)) * truth.period
        winds.plot(time, truth["wx_true"], color=COLOURS[3], label="W_x")
        winds.plot(time, truth["wz_true"], "--", color=COLOURS[3], linewidth=0.8, label="W_z")
        winds.axhline(BOUND, color=LIMIT, linestyle=":", linewidth=0.8)
        winds.set_xlabel("t [s]; dotted: the bound of scenario 3")
        winds.set_ylabel("wind of scenarios 2 and 3 [kt]")
        winds.legend(loc="lower right")
        for axes, quantity, unit in zip(panels, ("alpha", "vc"), ("deg", "kt"), strict=True):
            for i, sheet in enumerate(shown):
                values = [getattr(at[s, sheet], quantity) for s in scenarios]
                axes.bar(np.arange(3) + 0.27 * (i - 1), values, 0.25, color=COLOUR[sheet], label=NAMES[sheet])
            axes.axhline(THRESHOLDS[quantity], color=LIMIT, linestyle="--", linewidth=0.8)
            axes.set_xticks(range(3), [s.split(":")[0] for s in scenarios])
            axes.set_xlabel("wind scenario")
            axes.set_ylabel(f"largest rms, {'AOA' if quantity == 'alpha' else 'airspeed'} [{unit}]")
        panels[1].legend()
        save(drawn, pictures / "004_fig_3.png")


def draw_fig_4(flown: dict[str, Runaway], pictures: Path) -> None:
    """Sensors, errors of V_c, wind and residuals of the first seed."""
    one = flown["cmhe_fte"]
    shown = slice(one.onset - 80, one.onset + NOT_WITHIN)
    time = (np.arange(one.out["wx_hat"].shape[1]) * one.period)[shown]
    with figure(7.4, 4.6) as drawn:
        (sensed, error), (wind, residual) = drawn.subplots(2, 2, sharex=True)
        sensed.plot(time, one.readings[0, shown], color=SOFT, linewidth=0.7)
        sensed.plot(time, one.vc_true[shown], color=TRUTH)
        sensed.set_ylabel("airspeed: sensors, true [kt]")
        for sheet, run in flown.items():
            error.plot(time, run.vc_error[0, shown], color=COLOUR[sheet], label=NAMES[sheet])
            wind.plot(time, run.out["wx_hat"][0, shown], color=COLOUR[sheet])
            residual.plot(time, run.out["vc_rms"][0, shown].mean(axis=1), color=COLOUR[sheet])
            delay = run.delays[0]
            if delay is not None and delay < NOT_WITHIN:
                residual.axvline((run.onset + delay) * run.period, color=COLOUR[sheet], linestyle=":", linewidth=1.0)
        error.set_ylabel("error of airspeed [kt]")
        error.legend()
        wind.axhline(WX_MAX, color=LIMIT, linestyle="--", linewidth=0.8)
        wind.set_ylabel("estimated W_x [kt]; true: 0")
        residual.axhline(THRESHOLDS["vc"], color=LIMIT, linestyle="--", linewidth=0.8)
        residual.set_ylim(0.0, 40.0)
        residual.set_ylabel("residual rms [kt]; dotted: isolated")
        for axes in (wind, residual):
            axes.set_xlabel("t [s]")
        save(drawn, pictures / "004_fig_4.png")


def draw_fig_6a(pictures: Path) -> None:
    """One flight on which the jammed sensors are found, late: readings, truth, estimate and isolation."""
    truth = load_recording(SLOW)
    readings = jammed(truth, (-2.0, -10.0))
    out = run("cmhe_fte", [readings])
    time, sensed = np.arange(len(truth)) * truth.period, readings.inputs()
    with figure(7.4, 2.7) as drawn:
        for axes, sensor, unit, scale in zip(
            drawn.subplots(1, 2), ("alpha", "vc"), ("deg", "kt"), (DEGREES, 1.0), strict=True
        ):
            axes.plot(time, sensed[sensor][:, 2] * scale, color=SOFT, linewidth=0.3, alpha=0.6, label="healthy sensor")
            axes.plot(
                time, sensed[sensor][:, :2] * scale, color=COLOURS[1], linewidth=0.9, label=("jammed sensors", None)
            )
            axes.plot(time, out[f"{sensor}_hat"][0] * scale, color=COLOURS[0], linewidth=0.9, label="estimate")
            axes.plot(time, truth[f"{sensor}_true"] * scale, color=TRUTH, linewidth=0.7, label="true")
            for row in out[f"{sensor}_faulty"][0].T:
                if row.any():
                    axes.axvline(np.argmax(row > 0.5) * truth.period, color=LIMIT, linestyle=":", linewidth=1.0)
            axes.set_xlabel("t [s]; dotted: isolated")
            axes.set_ylabel(f"{'AOA' if sensor == 'alpha' else 'airspeed'} [{unit}]")
        drawn.axes[1].legend()
        save(drawn, pictures / "004_fig_6a.png")


def draw_rates(measured: Sequence[Rate], path: Path, curves: Sequence[tuple[str, str, float]]) -> None:
    """Residual against rate, a curve for each (scenario, sheet, q_w)."""
    dashes = ("-", "--", ":")
    with figure(6.0, 2.8) as drawn:
        axes = drawn.subplots()
        seen: dict[str, int] = {}
        for scenario, sheet, q in curves:
            points = sorted((r.rate, r.rms) for r in measured if (r.scenario, r.sheet, r.q_w) == (scenario, sheet, q))
            style = dashes[seen.get(sheet, 0)]
            seen[sheet] = seen.get(sheet, 0) + 1
            label = f"{NAMES[sheet]}, {scenario}" if len({c[0] for c in curves}) > 1 else f"{NAMES[sheet]}, q_w = {q:g}"
            axes.plot(*zip(*points, strict=True), style, marker="o", markersize=3, color=COLOUR[sheet], label=label)
        axes.set_xlabel("rate of the runaway [kt/s]")
        axes.set_ylabel("mean residual rms [kt]")
        axes.legend()
        save(drawn, path)
