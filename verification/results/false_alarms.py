"""False alarms in fault-free flight.

    python -m verification.results.false_alarms [--all]
    python -m verification.results.false_alarms --flights a320_calm_350kt_5000ft --seeds 1 --seconds 30

The shipped recordings need nothing else; ``--all`` also flies the rest of the catalogue with JSBSim. The second form is a
look at some of it.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from verification.flights import FLIGHTS, Recording, load_recording, record, sensors, shipped_recordings
from verification.results.batch import Outcome, Progress, run_batch

BEYOND_BOUNDS = ("a320_beyond_350kt_5000ft",)
"""Flights of the catalogue whose wind is beyond the assumed bounds: alarms are expected there, as the paper says."""

SEEDS = (1, 2, 3)
LEAST_SECONDS = 5.0
"""Errors are counted after the first 50 frames, 2.4 s."""


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
    return [*shipped(), *_recorded(plan.name for plan in FLIGHTS)]


def _recorded(names: Iterable[str]) -> list[tuple[str, Recording]]:
    """Of these flights those that are not shipped, flown now."""
    kept, wanted = shipped_recordings(), list(names)
    return [(plan.name, record(plan)) for plan in FLIGHTS if plan.name in wanted and plan.name not in kept]


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


def main(arguments: Sequence[str] | None = None) -> None:
    """Print the table."""
    known = [plan.name for plan in FLIGHTS]
    parser = argparse.ArgumentParser(prog="python -m verification.results.false_alarms", description="False alarms.")
    parser.add_argument("--all", action="store_true", help="every flight of the catalogue; JSBSim flies those not shipped")
    parser.add_argument("--flights", nargs="+", metavar="NAME", choices=known, help="these alone")
    parser.add_argument("--seeds", type=int, nargs="+", default=SEEDS, help="of the noise")
    parser.add_argument("--seconds", type=float, help="of each flight, from its start")
    given = parser.parse_args(arguments)
    names = given.flights or (known if given.all else shipped_recordings())
    if given.seconds is not None and not LEAST_SECONDS <= given.seconds < float("inf"):
        parser.error(f"--seconds {given.seconds:g} is hardly more than the start-up: write at least {LEAST_SECONDS:g}")
    flights = [(name, truth) for name, truth in shipped() if name in names] + _recorded(names)
    if given.seconds is not None:
        flights = [(name, truth.part(0.0, given.seconds)) for name, truth in flights]
    print(markdown(false_alarms(flights, given.seeds)))


if __name__ == "__main__":
    main()
