"""False alarms in fault-free flight.

    python -m verification.results.false_alarms [--all]

The shipped recordings need nothing else; ``--all`` also flies the rest of the catalogue with JSBSim.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from verification.flights import FLIGHTS, Recording, load_recording, record, sensors, shipped_recordings
from verification.results.batch import Outcome, Progress, run_batch

BEYOND_BOUNDS = ("a320_beyond_350kt_5000ft",)
"""Flights of the catalogue whose wind is beyond the assumed bounds: alarms are expected there, as the paper says."""

SEEDS = (1, 2, 3)


@dataclass(frozen=True)
class Quiet:
    """One flight, over all noise seeds."""

    flight: str
    within_bounds: bool
    seeds: int
    frames: int
    false_alarms: int
    """Sensors that were confirmed faulty, over all seeds."""
    alpha_rms: float
    """Largest residual rms [deg], after the first 50 frames; the threshold is 2.9."""
    vc_rms: float
    """Likewise [kt]; the threshold is 12."""
    alpha_error: float
    """rms error of the angle of attack [deg], after the first 50 frames."""
    vc_error: float
    """rms error of the airspeed [kt]."""


def false_alarms(
    recordings: Sequence[tuple[str, Recording]],
    seeds: Sequence[int] = SEEDS,
    sheet: str = "cmhe_fte",
    progress: Progress | None = None,
) -> tuple[Quiet, ...]:
    """Fly recordings (name, truth) fault-free, once a noise seed, and count what is condemned."""
    flights = [sensors(truth, seed) for _, truth in recordings for seed in seeds]
    outcomes = run_batch(sheet, flights, progress)
    each = len(seeds)
    return tuple(_quiet(name, outcomes[i * each : (i + 1) * each]) for i, (name, _) in enumerate(recordings))


def _quiet(name: str, outcomes: Sequence[Outcome]) -> Quiet:
    settled = slice(50, None)
    return Quiet(
        name,
        name not in BEYOND_BOUNDS,
        len(outcomes),
        len(outcomes[0].vc_error),
        sum(int(o.alpha_faulty[-1].sum() + o.vc_faulty[-1].sum()) for o in outcomes),
        max(float(o.alpha_rms[settled].max()) for o in outcomes),
        max(float(o.vc_rms[settled].max()) for o in outcomes),
        float(np.sqrt(np.mean([np.mean(o.alpha_error[settled] ** 2) for o in outcomes]))),
        float(np.sqrt(np.mean([np.mean(o.vc_error[settled] ** 2) for o in outcomes]))),
    )


def shipped() -> list[tuple[str, Recording]]:
    """The shipped recordings: all of them within the assumed bounds."""
    return [(name, load_recording(name)) for name in shipped_recordings()]


def catalogue() -> list[tuple[str, Recording]]:
    """Every flight of the catalogue, the others recorded now with JSBSim."""
    names = shipped_recordings()
    return shipped() + [(plan.name, record(plan)) for plan in FLIGHTS if plan.name not in names]


def markdown(rows: Sequence[Quiet]) -> str:
    """The table in Markdown."""
    lines = [
        "| flight | frames x seeds | false alarms | largest rms, alpha (2.9 deg) | largest rms, V_c (12 kt) "
        "| rms error, alpha | rms error, V_c |",
        "|---|---|---|---|---|---|---|",
    ]
    for row in rows:
        name = row.flight if row.within_bounds else f"{row.flight} (beyond the bounds)"
        lines.append(
            f"| {name} | {row.frames} x {row.seeds} | {row.false_alarms} | {row.alpha_rms:.2f} deg "
            f"| {row.vc_rms:.2f} kt | {row.alpha_error:.3f} deg | {row.vc_error:.2f} kt |"
        )
    return "\n".join(lines)


def main() -> None:
    """Print the table."""
    print(markdown(false_alarms(catalogue() if "--all" in sys.argv[1:] else shipped())))


if __name__ == "__main__":
    main()
