"""The table of Table II's faults on the flights, in Markdown, misses included.

python -m verification.results.fault_table -o docs/fault_table.md
python -m verification.results.fault_table --flights a320_calm_350kt_5000ft --seeds 1 --seconds 20    # a look
"""

from __future__ import annotations

import argparse
import math
import os
import sys
from collections.abc import Callable, Sequence
from pathlib import Path

from saoflow.whole_file import write_whole
from verification.flights import KINDS, shipped_recordings
from verification.results.faults import (
    DURATION,
    LEVELS,
    ONSET,
    SEEDS,
    SENSORS,
    WHICH,
    Result,
    Trial,
    run_trials,
    trials,
)

FLIGHTS = ("a320_calm_350kt_5000ft", "a320_wind_350kt_5000ft")
"""Level and calm; and manoeuvres in changing wind. Both A320, 350 kt, 5000 ft."""


def introduction(seeds: int = len(SEEDS), duration: float = DURATION) -> str:
    """What stands above the tables, for so many noise seeds, each flown for so many seconds."""
    return f"""\
# The faults of Table II on the flights

Written by `python -m verification.results.fault_table -o docs/fault_table.md`; a shortened version is a test
(`tests/verification/results/test_fault_table.py`).

Every fault type of Table II of paper 004, at the low, the geometrically middle and the high end of its range, on one,
two and three sensors of a kind, each with {seeds} noise seeds (bias, jamming and runaway negative with the second).
Sensor noise as in Table I of paper 003, completed; onset at {ONSET:g} s, {duration - ONSET:g} s watched after it. The
readings do not feed back into the aircraft: ours is an open loop.

A cell reads: runs in which all faulty sensors were confirmed, of all runs; mean delay from onset to the confirmation of
the last of them; largest error of the faulty quantity's estimate after onset, over all runs, found or not. In bold: not
always found. "+ n wrong": so many healthy sensors were confirmed, over all runs.

What cannot be found, whatever the code: faults below the thresholds (2.9 deg, 12 kt rms); three sensors that move
together as a wind inside its bounds would make them; angles of attack at a tenth of their value where that is below the
threshold. Two sensors that agree on a wrong value can outvote the healthy one.

What this tuning does not find: the same moderate bias on all three angles of attack (3.5 deg here), which it takes for
vertical wind. A tighter one finds it, and condemns healthy sensors in vertical gusts.

Once all three airspeed sensors are lost, the airspeed comes from the last wind estimate and errs by what the wind changes
from then on: in the second flight by up to 50 kt.
"""


def table(results: Sequence[Result]) -> str:
    """One row for each sensor, kind and level, one column for each number of faulty sensors; Markdown."""
    lines = [
        "| sensor | fault | value | one sensor | two sensors | three sensors |",
        "|---|---|---|---|---|---|",
    ]
    for sensor in SENSORS:
        for kind in KINDS:
            for level in (*LEVELS, ""):
                row = [r for r in results if _key(r.trial) == (sensor, kind, level)]
                if row:
                    cells = [_cell([r for r in row if len(r.trial.fault.which) == len(w)]) for w in WHICH]
                    value = f"{level}: {_value(row[0].trial)}" if level else _value(row[0].trial)
                    lines.append(f"| {sensor} | {kind.replace('_', ' ')} | {value} | {' | '.join(cells)} |")
    return "\n".join(lines)


def _key(trial: Trial) -> tuple[str, str, str]:
    return trial.fault.sensor, trial.fault.kind, trial.level


def _value(trial: Trial) -> str:
    fault = trial.fault
    unit = "deg" if fault.sensor == "alpha" else "kt"
    if fault.kind == "non_return_to_zero":
        return f"x {fault.amplitude:g}"
    if fault.kind == "runaway":
        return f"{abs(fault.rate or 0.0):.3g} {unit}/s"
    text = f"{abs(fault.amplitude or 0.0):.3g} {unit}"
    return f"{text}, {fault.frequency:.2g} Hz" if fault.frequency else text


def _cell(results: Sequence[Result]) -> str:
    if not results:
        return ""
    delays = [r.delay_s for r in results if r.delay_s is not None]
    alpha = results[0].trial.fault.sensor == "alpha"
    error = max(r.alpha_error if alpha else r.vc_error for r in results)
    count = f"{len(delays)}/{len(results)}"
    text = count if len(delays) == len(results) else f"**{count}**"
    if delays:
        text += f" in {sum(delays) / len(delays):.2f} s"
    text += f"; {error:.2f} deg" if alpha else f"; {error:.1f} kt"
    wrong = sum(r.wrong for r in results)
    return text + (f" + {wrong} wrong" if wrong else "")


def summary(results: Sequence[Result]) -> str:
    """Counts over the whole table, in one sentence."""
    found, wrong = sum(r.found for r in results), sum(r.wrong > 0 for r in results)
    by_number = []
    for which, number in zip(WHICH, ("one", "two", "three"), strict=True):
        mine = [r for r in results if len(r.trial.fault.which) == len(which)]
        by_number.append(f"{sum(r.found for r in mine)} of {len(mine)} on {number}")
    return (
        f"All faulty sensors were confirmed in {found} of {len(results)} runs ({', '.join(by_number)} sensors); "
        f"a healthy sensor was confirmed in {wrong}."
    )


def document(
    flights: Sequence[str] = FLIGHTS,
    seeds: Sequence[int] = SEEDS,
    duration: float = DURATION,
    kinds: Sequence[str] = KINDS,
    progress: Callable[[str, float], None] | None = None,
) -> str:
    """The whole document: introduction, and for each flight a summary and the table. ``duration`` [s] of each run."""
    chosen = [trial for trial in trials(seeds) if trial.fault.kind in kinds]
    parts = [introduction(len(seeds), duration)]
    for flight in flights:

        def tell(done: float, flight: str = flight) -> None:
            if progress is not None:
                progress(flight, done)

        results = run_trials(flight, chosen, duration=duration, progress=tell)
        parts.append(f"## {flight}\n\n{summary(results)}\n\n{table(results)}\n")
    return "\n".join(parts)


def main(arguments: Sequence[str] | None = None) -> int:
    """Write the document, all of it or nothing."""
    parser = argparse.ArgumentParser(prog="python -m verification.results.fault_table", description=__doc__)
    parser.add_argument("-o", "--output", type=Path, help="file to write; without it the table is printed")
    parser.add_argument("--flights", nargs="+", metavar="NAME", choices=shipped_recordings(), default=FLIGHTS, help="these")
    parser.add_argument("--seeds", type=int, nargs="+", default=SEEDS, help="of the noise")
    parser.add_argument("--kinds", nargs="+", metavar="KIND", choices=KINDS, default=KINDS, help="of faults")
    parser.add_argument("--seconds", type=float, default=DURATION, help=f"of each run; the onset is at {ONSET:g} s")
    given = parser.parse_args(arguments)
    output: Path | None = given.output
    if not ONSET < given.seconds < math.inf:
        parser.error(f"--seconds {given.seconds:g} ends before the onset at {ONSET:g} s: write more")
    if output is not None and (output.is_dir() or not os.access(output.resolve().parent, os.W_OK)):
        parser.error(f"{output} cannot be written: name a file in a folder that exists and that you may write to")
    text = _with_progress_bar(given.flights, given.seeds, given.seconds, given.kinds)
    if output is None:
        print(text)
        return 0
    write_whole(output, text.encode("utf-8"))
    return 0


def _with_progress_bar(flights: Sequence[str], seeds: Sequence[int], duration: float, kinds: Sequence[str]) -> str:
    from rich.console import Console
    from rich.progress import Progress

    console = Console(stderr=True)
    with Progress(console=console, transient=True, disable=not console.is_terminal) as bar:
        tasks = {flight: bar.add_task(flight, total=1.0) for flight in flights}

        def tell(flight: str, done: float) -> None:
            bar.update(tasks[flight], completed=done)

        return document(flights, seeds, duration, kinds, tell)


if __name__ == "__main__":
    sys.exit(main())
