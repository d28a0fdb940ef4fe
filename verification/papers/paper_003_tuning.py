"""Paper 003, section 4.3: what a larger weight M of the arrival cost does."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path

import numpy as np

import saoflow
from verification.flights.true_airspeed import load_pulls, readings
from verification.papers.conditions import judged
from verification.papers.finding import Finding
from verification.papers.mho_runs import DEGREES, FLIGHTS, SETTLED, Array, batch
from verification.papers.paper_003 import NOISE, PAPER, seeds_of
from verification.reference.mho.inputs import condition
from verification.reference.mho.model import f, first_state, h
from verification.reference.mho.recording import frames
from verification.reference.mho.tuning import MhoTuning

FACTORS = (1.0, 1e2, 1e4, 1e6, 1e8)
SHORT_FACTORS = (1.0, 1e4, 1e8)

NEAR = 0.02
"""MHO-PE has become the observer: its rms distance from it is at most this share of the observer's error."""

TUNING = MhoTuning()


def pre_estimated(rows: dict[str, Array]) -> Array:
    """The Luenberger observer (5) alone: alpha at k from the measurements up to k-1, (n,) [rad]."""
    held, started, x = TUNING.nominal, False, np.zeros(3)
    found = []
    for inputs in frames(rows):
        now, started = condition(inputs, held, started, TUNING)
        held = now.held
        if now.load:
            x = first_state(now.y)
        found.append(x[0])
        x = f(x, now.u, TUNING) + TUNING.gain @ (now.y - h(x, TUNING))
    return np.array(found)


def weighed(factor: float, seeds: tuple[int, ...]) -> Array:
    """alpha of MHO-PE with M times ``factor``, (flights, noises, seeds, frames) [deg]."""
    small = factor**-0.5
    parameters = {"prior_alpha": 5.0 * small, "prior_v": 5.0 * small, "prior_theta": 5.0 * small}
    inputs, _ = batch(seeds)
    out = saoflow.load("mho_pe", parameters=parameters).simulator(backend="c").run(inputs)["alpha_hat"]
    return out.reshape(len(FLIGHTS), 2, len(seeds), -1) * DEGREES


def findings(pictures: Path, *, short: bool = False) -> Iterator[Finding]:
    """The third guideline of 4.3."""
    seeds, factors = seeds_of(short), SHORT_FACTORS if short else FACTORS
    _, truth = batch(seeds)
    runs = {factor: weighed(factor, seeds) for factor in factors}
    # One seed of the first flight without biases: the observer is a plain loop.
    rows = readings(load_pulls(FLIGHTS[0]), seeds[0]).inputs()
    alone = pre_estimated(rows) * DEGREES
    own = float(np.sqrt(np.mean((alone - truth[0] * DEGREES)[SETTLED:] ** 2)))
    distances = [float(np.sqrt(np.mean((runs[one][0, 0, 0] - alone)[SETTLED:] ** 2))) for one in factors]

    def rms(factor: float, flight: int, noise: int) -> float:
        return float(np.sqrt(np.mean((runs[factor][flight, noise] - truth[flight] * DEGREES)[:, SETTLED:] ** 2)))

    def claim(noise: int) -> bool:
        closer = all(b < a for a, b in pairwise(distances)) and distances[-1] <= NEAR * own
        worse = all(rms(factors[-1], flight, noise) > rms(factors[0], flight, noise) for flight in range(len(FLIGHTS)))
        return closer and worse

    verdict, condition_text = judged((NOISE,), claim)
    lines = ["| M times | rms distance from the observer, deg | rms error with noise, deg | with noise and biases, deg |"]
    lines.append("|---:|---:|---:|---:|")
    for factor, distance in zip(factors, distances, strict=True):
        errors = " | ".join(f"{np.mean([rms(factor, flight, noise) for flight in range(len(FLIGHTS))]):.3f}" for noise in (0, 1))
        lines.append(f"| {factor:g} | {distance:.4f} | {errors} |")
    text = (
        f"`mho_pe`, N = 4, with M multiplied; the distance is from the observer (5) alone on one run, whose own rms error is "
        f"{own:.3f} deg. The rule: the distance falls with every factor, to {NEAR:.0%} of that error, and the largest M has a larger "
        "rms error than the paper's on both flights.\n\n" + "\n".join(lines)
    )
    stated = "As M increases MHO-PE behaves closer to the pre-estimating observer, and the errors may increase"
    yield Finding(PAPER, "Section 4.3", "choice of M", stated, verdict, condition_text, text)
