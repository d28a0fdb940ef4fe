"""Paper 003, Fig. 8: detection of faults of the angle-of-attack sensor by MHO-PE."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

import saoflow
from verification.flights.faults import Fault
from verification.flights.true_airspeed import INPUT_BIASES, NO_BIASES, PERIOD, PORTS, load_pulls, readings
from verification.papers.finding import Finding, Verdict
from verification.papers.mho_runs import DEGREES, FLIGHTS, SCENARIOS, Array, noise_seed
from verification.papers.paper_003 import PAPER, seeds_of
from verification.papers.style import COLOURS, LIMIT, figure, save

ONSET = 30.0
"""When a fault begins [s]."""

WITHIN = 3.0
"""A fault is detected: within so many seconds of its onset."""

THRESHOLD = 0.0454 * DEGREES
"""Of the rms [deg]."""


@dataclass(frozen=True)
class Case:
    """A fault; ``shown``: of the kinds and sizes that the claim is judged by."""

    name: str
    fault: Fault
    shown: bool


CASES = (
    Case("runaway, 1 deg/s", Fault("runaway", "alpha", (1,), rate=1.0, onset=ONSET), False),
    Case("runaway, 3 deg/s", Fault("runaway", "alpha", (1,), rate=3.0, onset=ONSET), True),
    Case("oscillation, 3 deg, 0.5 Hz", Fault("oscillation", "alpha", (1,), amplitude=3.0, frequency=0.5, onset=ONSET), False),
    Case("oscillation, 6 deg, 0.5 Hz", Fault("oscillation", "alpha", (1,), amplitude=6.0, frequency=0.5, onset=ONSET), True),
    Case("bias, 2 deg", Fault("bias", "alpha", (1,), amplitude=2.0, onset=ONSET), False),
    Case("bias, 5 deg", Fault("bias", "alpha", (1,), amplitude=5.0, onset=ONSET), True),
)


@dataclass(frozen=True, eq=False)
class Detected:
    """All runs of one case: flights, noises and seeds on one axis."""

    rms: Array  # (runs, frames) [deg]
    faulty: Array  # (runs, frames) 0 or 1

    @property
    def alarms_before(self) -> int:
        """Runs with an alarm before the onset."""
        return int(self.faulty[:, : round(ONSET / PERIOD)].any(axis=1).sum())

    @property
    def delays(self) -> list[float]:
        """Seconds from the onset to the first alarm in each run that has one."""
        after = self.faulty[:, round(ONSET / PERIOD) :] > 0.5
        return [float(np.argmax(row)) * PERIOD for row in after if row.any()]


def detect(faults: tuple[Fault, ...], seeds: tuple[int, ...]) -> Detected:
    """Run all flights, with noise alone and with input biases."""
    rows = [
        readings(load_pulls(name), noise_seed(flight, seed), biases=biases, faults=faults).inputs()
        for flight, name in enumerate(FLIGHTS)
        for biases in (NO_BIASES, INPUT_BIASES)
        for seed in seeds
    ]
    simulator = saoflow.load("mho_fault_detection").simulator(backend="c")
    out = simulator.run({port: np.stack([row[port] for row in rows]) for port in PORTS})
    return Detected(out["alpha_rms"] * DEGREES, out["alpha_faulty"])


def findings(pictures: Path, *, short: bool = False) -> Iterator[Finding]:
    """Fig. 8."""
    seeds = seeds_of(short)
    healthy = detect((), seeds)
    found = {case.name: detect((case.fault,), seeds) for case in CASES}
    count = len(healthy.rms)
    lines = ["| fault | detected | delay, s: mean / largest | alarms before |", "|---|---:|---:|---:|"]
    for case in CASES:
        one = found[case.name]
        delays = f"{np.mean(one.delays):.2f} / {max(one.delays):.2f}" if one.delays else ""
        lines.append(f"| {case.name} | {len(one.delays)} of {count} | {delays} | {one.alarms_before} |")
    lines.append(f"| none | {int(healthy.faulty.any(axis=1).sum())} of {count} | | |")
    name = "003_fig_8.png"
    _draw(pictures / name, found)
    shown = [found[case.name] for case in CASES if case.shown]
    all_found = all(len(one.delays) == count and max(one.delays) <= WITHIN for one in shown)
    quiet = not healthy.faulty.any() and not any(one.alarms_before for one in found.values())
    small = [case.name for case in CASES if not case.shown and len(found[case.name].delays) < count]
    verdict, condition = Verdict.FAILS, ""
    if all_found and quiet:
        verdict = Verdict.ONLY_IF if small else Verdict.HOLDS
        condition = f"the fault's own rms over 21 samples exceeds the threshold of {THRESHOLD:.1f} deg" if small else ""
    text = (
        f"`mho_fault_detection`: N = 4, N_e = 20, threshold 0.0454 rad. Both flights, noise alone and with input biases, "
        f"{len(seeds)} seeds: {count} runs of each fault from t = {ONSET:g} s on. The paper does not say how large its faults are. "
        f"The rule: each kind at a size above the threshold is detected in every run within {WITHIN:g} s, and there is no alarm "
        f"without a fault; the smaller sizes tell whether that is a condition. The largest rms without a fault is "
        f"{healthy.rms.max():.2f} deg.\n\n" + "\n".join(lines)
        + "\n\nA bias below 2.6 deg, and an oscillation below 3.7 deg, cannot be found by this threshold whatever the estimator."
    )
    claim = "MHO-PE with N = 4, N_e = 20 and a threshold of 0.0454 detects runaway, oscillation and bias"
    yield Finding(PAPER, "Fig. 8", "fault detection", claim, verdict, condition, text, (name,))


def _draw(path: Path, found: dict[str, Detected]) -> None:
    shown = [case for case in CASES if case.shown]
    with figure(7.2, 2.6) as drawn:
        for axis, case in zip(drawn.subplots(1, len(shown), sharey=True), shown, strict=True):
            one = found[case.name]
            t = np.arange(one.rms.shape[1]) * PERIOD
            part = slice(round((ONSET - 5) / PERIOD), round((ONSET + 10) / PERIOD))
            for flight, scenario in enumerate(SCENARIOS):
                row = one.rms[flight * len(one.rms) // 2]
                axis.plot(t[part], row[part], color=COLOURS[flight], lw=0.9, label=scenario)
            axis.axhline(THRESHOLD, color=LIMIT, ls="--", lw=0.9)
            axis.set_title(case.name)
            axis.set_xlabel("t, s")
            axis.set_ylim(0, 8)
        drawn.axes[0].set_ylabel("rms of the residual, deg")
        drawn.axes[0].legend()
        save(drawn, path)
