"""Paper 003's estimators over its flights: many noise seeds side by side, errors of the angle of attack."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray

import saoflow
from saoflow.pipeline import LoadedSheet
from verification.flights.true_airspeed import INPUT_BIASES, NO_BIASES, PULLS, load_pulls, readings
from verification.reference.mho.gain import level_flight, placed_gain
from verification.reference.mho.tuning import Q_V_PRINTED, MhoTuning

Array = NDArray[np.float64]

SETTLED = 63
"""Frames that are left out at the start of a run: 5 s."""

DEGREES = 180.0 / np.pi

FLIGHTS = tuple(plan.name for plan in PULLS)
SCENARIOS = ("Scenario 1", "Scenario 2")
"""Our flights, in the order of :data:`FLIGHTS`, in the place of the paper's."""

NOISES = ("Table I's noise", "and input biases")
"""White noise alone; and constant errors of A_x, A_z, q besides."""


@dataclass(frozen=True)
class Variant:
    """A sheet with one choice of what the paper leaves open or prints wrongly."""

    name: str
    sheet: str
    printed_q: bool = False
    placed: bool = False
    """L by pole placement instead of the Riccati equation."""

    def loaded(self, N: int) -> LoadedSheet:
        """The sheet at a horizon; the filter has none."""
        parameters: dict[str, object] = {} if self.sheet == "ekf" else {"N": N}
        if self.printed_q:
            parameters["q_v"] = Q_V_PRINTED
        if self.placed:
            L = placed_gain(MhoTuning(), *level_flight())
            parameters |= {f"L_{port}": [float(v) for v in L[:, j]] for j, port in enumerate(("vt", "vz", "theta"))}
        return saoflow.load(self.sheet, parameters=parameters)


EKF = Variant("EKF", "ekf")
EKF_PRINTED = Variant("EKF, Q(2) as printed", "ekf", printed_q=True)
PE = Variant("MHO-PE", "mho_pe")
PE_PLACED = Variant("MHO-PE, poles at 0.5", "mho_pe", placed=True)
WOD = Variant("MHO-woD", "mho_wod")
WD = Variant("MHO-wD", "mho_wd")
WD_PRINTED = Variant("MHO-wD, Q(2) as printed", "mho_wd", printed_q=True)
FILTERS = (EKF, EKF_PRINTED)
OBSERVERS = (PE, PE_PLACED, WOD, WD, WD_PRINTED)


@dataclass(frozen=True, eq=False)
class Run:
    """One variant at one horizon over all flights, noises and seeds."""

    variant: Variant
    N: int
    error: Array  # (flights, noises, seeds, frames) [deg]: estimate minus truth

    def rms(self, flight: int, noise: int) -> float:
        """Root mean square error of alpha over all seeds, settled [deg]."""
        return float(np.sqrt(np.mean(self.error[flight, noise, :, SETTLED:] ** 2)))

    def largest(self, flight: int, noise: int) -> float:
        """Largest absolute error in a run, the mean over the seeds, settled [deg]."""
        return float(np.abs(self.error[flight, noise, :, SETTLED:]).max(axis=1).mean())


def noise_seed(flight: int, seed: int) -> int:
    """The seed of a flight's noise: no two flights have the same."""
    return 1000 * flight + seed


@cache
def batch(seeds: tuple[int, ...]) -> tuple[dict[str, Array], Array]:
    """The readings of all flights, noises and seeds, flattened to one axis of runs, and the truth of alpha (flights, n)."""
    flights = [load_pulls(name) for name in FLIGHTS]
    rows = [
        readings(truth, noise_seed(flight, seed), biases=biases).inputs()
        for flight, truth in enumerate(flights)
        for biases in (NO_BIASES, INPUT_BIASES)
        for seed in seeds
    ]
    inputs = {port: np.stack([row[port] for row in rows]) for port in ("vt", "vz", "theta", "q", "ax", "az")}
    return inputs, np.stack([truth["alpha_true"] for truth in flights])


@cache
def run(variant: Variant, N: int, seeds: tuple[int, ...]) -> Run:
    """Fly one variant; compiled where there is a C compiler (the bits are the interpreter's)."""
    inputs, truth = batch(seeds)
    found = variant.loaded(N).simulator(backend="c").run(inputs)["alpha_hat"]
    shaped = found.reshape(len(FLIGHTS), len(NOISES), len(seeds), -1)
    return Run(variant, N, (shaped - truth[:, None, None, :]) * DEGREES)


def error_table(runs: Sequence[Run]) -> str:
    """Markdown: rms and mean largest error of alpha by flight and noise."""
    head = [f"{scenario}, {noise}" for scenario in SCENARIOS for noise in ("noise", "noise and biases")]
    lines = ["| rms / largest error of alpha, deg | " + " | ".join(head) + " |", "|---|" + "---:|" * len(head)]
    for one in runs:
        cells = [
            f"{one.rms(flight, noise):.3f} / {one.largest(flight, noise):.2f}"
            for flight in range(len(FLIGHTS))
            for noise in range(len(NOISES))
        ]
        lines.append(f"| {one.variant.name} | " + " | ".join(cells) + " |")
    return "\n".join(lines)
