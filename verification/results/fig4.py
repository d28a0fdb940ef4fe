"""The paper's Fig. 4: all three airspeed sensors run away at -15 kt/s, 350 kt, 5000 ft, calm.

What can be compared with the paper: CMHE-FTE condemns the three sensors within seconds, because the wind that would
explain the fault is beyond its bound; UMHE-FTE and EKF-FTE take the fault for wind and follow it.

    python -m verification.results.fig4 [--seeds 1 2 3]
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from verification.flights import Fault, load_recording, sensors
from verification.results.batch import first_frame, run_batch

SEEDS = (1, 2, 3)
FLIGHT = "a320_calm_350kt_5000ft"
FAULT = Fault("runaway", "vc", which=(1, 2, 3), rate=-15.0, onset=20.0)
WITHIN_S = 6.0
"""The paper: CMHE-FTE detects within 6 s of onset."""
NOT_WITHIN = 370
"""The paper: UMHE-FTE does not detect within the 370 samples (17.76 s) that Fig. 4 shows."""


@dataclass(frozen=True)
class Fig4:
    """One sheet on one noise seed."""

    sheet: str
    seed: int
    delay_frames: int | None
    """From onset to the confirmation of the last of the three sensors; None: never."""
    first_frames: int | None
    """From onset to the confirmation of the first of them."""
    wrong: int
    """Healthy sensors that were confirmed faulty."""
    alpha_error: float
    """Largest error of the angle of attack from onset to 370 frames later [deg]."""
    vc_error: float
    """Largest error of the airspeed in that time [kt]."""


def fig4(sheet: str, seeds: Sequence[int] = SEEDS) -> tuple[Fig4, ...]:
    """Fly Fig. 4 through a sheet, once a noise seed."""
    truth = load_recording(FLIGHT)
    onset = FAULT.onset_frame(truth.period)
    flights = [sensors(truth.part(0.0, 45.0), seed, faults=[FAULT]) for seed in seeds]
    found = []
    for seed, outcome in zip(seeds, run_batch(sheet, flights), strict=True):
        last = first_frame(outcome.vc_faulty, 3)
        first = first_frame(outcome.vc_faulty, 1)
        shown = slice(onset, onset + NOT_WITHIN)
        found.append(
            Fig4(
                sheet,
                seed,
                None if last is None else last - onset,
                None if first is None else first - onset,
                int(outcome.alpha_faulty[-1].sum()) + int(outcome.vc_faulty[onset - 1].sum()),
                float(np.abs(outcome.alpha_error[shown]).max()),
                float(np.abs(outcome.vc_error[shown]).max()),
            )
        )
    return tuple(found)


def main(arguments: Sequence[str] | None = None) -> None:
    """Print the three sheets."""
    parser = argparse.ArgumentParser(prog="python -m verification.results.fig4", description="Fig. 4.")
    parser.add_argument("--seeds", type=int, nargs="+", default=SEEDS, help="of the noise")
    seeds = parser.parse_args(arguments).seeds
    period = load_recording(FLIGHT).period
    for sheet in ("cmhe_fte", "umhe_fte", "ekf_fte"):
        for one in fig4(sheet, seeds):
            if one.delay_frames is None:
                delay = "not detected in 25 s"
            else:
                delay = f"detected {one.delay_frames} frames ({one.delay_frames * period:.2f} s) after onset"
            errors = f"largest errors in 370 frames {one.alpha_error:.2f} deg, {one.vc_error:.2f} kt"
            print(f"{sheet}, seed {one.seed}: {delay}; {one.wrong} healthy sensors condemned; {errors}")


if __name__ == "__main__":
    main()
