"""The flagship with Step 3 in every second frame: what that costs and saves.

    python -m verification.results.half_rate

prints the tables of docs/multirate.md. The variant is cmhe_fte with its block `step3` using the sheet `step3_half_rate`.
Two of them on one computer, in alternate frames, are what half the rate is for.
"""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import numpy as np

import saoflow
from saoflow.diagrams.store import SHIPPED
from verification.flights import Fault, load_recording, sensors
from verification.results.batch import DEGREES, first_frame

FLIGHTS = ("a320_calm_350kt_5000ft", "a320_wind_350kt_5000ft", "787_ramps_300kt_15000ft")
SETTLED = 100
"""Frames of the start that errors leave out."""

PORTS = ("alpha", "vc", "vg", "vz", "theta", "q", "ax", "az", "z")
SHAPES = {"alpha": "[3]", "vc": "[3]"}


@contextmanager
def variant() -> Iterator[Path]:
    """The path of cmhe_fte with Step 3 at half rate."""
    text = (SHIPPED / "cmhe_fte" / "cmhe_fte.yaml").read_text(encoding="utf-8")
    for old, new in (
        ("sheet: cmhe_fte\n", "sheet: cmhe_fte_half_rate\n"),
        ("\nparameters:\n", "\nparameters:\n  phase: 0\n"),
        ("{step3: {", "{step3_half_rate: {"),
    ):
        assert text.count(old) == 1
        text = text.replace(old, new)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "cmhe_fte_half_rate.yaml"
        path.write_text(text, encoding="utf-8")
        (Path(folder) / "two_channels.yaml").write_text(two_channels(), encoding="utf-8")
        yield path


@dataclass(frozen=True)
class Errors:
    """Fault-free errors on one flight: root mean squares and largest, deg and kt; false alarms."""

    alpha_rms: float
    alpha_most: float
    vc_rms: float
    vc_most: float
    false_alarms: int


def errors(sheet: saoflow.LoadedSheet, flight: str, seed: int = 1) -> Errors:
    """Fly one shipped recording without faults."""
    truth = load_recording(flight)
    out = sheet.simulator(backend="c").run(sensors(truth, seed).inputs())
    alpha = np.abs((out["alpha_hat"] - truth["alpha_true"])[SETTLED:]) * DEGREES
    vc = np.abs((out["vc_hat"] - truth["vc_true"])[SETTLED:])
    alarms = int(out["alpha_faulty"][-1].sum() + out["vc_faulty"][-1].sum())
    rms = [float(np.sqrt(np.mean(e**2))) for e in (alpha, vc)]
    return Errors(rms[0], float(alpha.max()), rms[1], float(vc.max()), alarms)


def delay(sheet: saoflow.LoadedSheet, seed: int = 1) -> float:
    """Seconds until three airspeed sensors that run away together are all isolated (Fig. 4 of paper 004)."""
    truth = load_recording(FLIGHTS[0])
    fault = Fault("runaway", "vc", rate=-15.0, onset=20.0)
    out = sheet.simulator(backend="c").run(sensors(truth, seed, faults=[fault]).inputs())
    last = first_frame(out["vc_faulty"] > 0.5, 3)
    return float("nan") if last is None else last * truth.period - fault.onset


def two_channels() -> str:
    """A sheet with two channels, each with its own sensors; Step 3 of the one runs in even frames, of the other in odd."""
    inputs = [f"  {name}_{c}: {{shape: {SHAPES.get(name, '[]')}}}" for c in ("left", "right") for name in PORTS]
    blocks = [
        f"  {c}: {{cmhe_fte_half_rate: {{{', '.join(f'{name}: {name}_{c}' for name in PORTS)}}}, phase: {phase}}}"
        for phase, c in enumerate(("left", "right"))
    ]
    outputs = "outputs: {left: left.alpha_hat, right: right.alpha_hat}"
    return "\n".join(["sheet: two_channels", "inputs:", *inputs, "blocks:", *blocks, outputs, ""])


def main() -> None:
    """Print the tables."""
    with variant() as path:
        sheets = {"cmhe_fte": saoflow.load("cmhe_fte"), "Step 3 at half rate": saoflow.load(str(path))}
        print("| | operations, dearest frame | operations, mean | three airspeeds run away: isolated after |")
        print("|---|---|---|---|")
        for name, sheet in sheets.items():
            budget = sheet.budget()
            mean = np.mean(budget.frames) if budget.frames else budget.total
            print(f"| {name} | {budget.total} | {mean:.0f} | {delay(sheet):.2f} s |")
        two = saoflow.load(str(path.with_name("two_channels.yaml"))).budget()
        print(f"| two such channels, in alternate frames | {two.total} | {np.mean(two.frames):.0f} | |")
        print()
        print("| flight, fault-free | | alpha rms, largest, deg | V_c rms, largest, kt | false alarms |")
        print("|---|---|---|---|---|")
        for flight in FLIGHTS:
            for name, sheet in sheets.items():
                e = errors(sheet, flight)
                alpha, vc = f"{e.alpha_rms:.3f}, {e.alpha_most:.2f}", f"{e.vc_rms:.2f}, {e.vc_most:.1f}"
                print(f"| {flight} | {name} | {alpha} | {vc} | {e.false_alarms} |")


if __name__ == "__main__":
    main()
