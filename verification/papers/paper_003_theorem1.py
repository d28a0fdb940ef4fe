"""Paper 003, Theorem 1 and section 4.3: the bound of the estimation error, evaluated on a flight."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cache
from itertools import pairwise
from pathlib import Path

import numpy as np

from verification.flights.true_airspeed import load_pulls, readings
from verification.papers.conditions import Factor, judged
from verification.papers.finding import Finding
from verification.papers.mho_runs import FLIGHTS, SETTLED
from verification.papers.paper_003 import PAPER
from verification.papers.style import COLOURS, figure, save
from verification.reference.mho import estimator
from verification.reference.mho.error_bound import NOISE_UNITS, PRINTED_UNITS, Bound, error_bound
from verification.reference.mho.mho_pe import mho_pe
from verification.reference.mho.tuning import MhoTuning

HORIZONS = (2, 4, 8, 15)
SHORT_HORIZONS = (2, 4)
FRAMES = 313  # 25 s: two pull-ups and a climb
SHORT_FRAMES = 130

UNITS = (PRINTED_UNITS, NOISE_UNITS)
UNIT = Factor(tuple(f"norms are taken in {scales.name}" for scales in UNITS))


@dataclass(frozen=True)
class Evaluated:
    """The bound at one horizon, in both units."""

    N: int
    bounds: tuple[Bound, Bound]


@cache
def evaluated(N: int, frames: int) -> Evaluated:
    """Run MHO-PE over the first flight with Table I's noise, by the numpy reference, which hands out every matrix."""
    truth, tuning = load_pulls(FLIGHTS[0]), MhoTuning(N=N)
    read = {port: values[:frames] for port, values in readings(truth, 1).inputs().items()}
    steps = list(estimator.steps(read, tuning, mho_pe))
    x = np.stack([truth[column][:frames] for column in ("alpha_true", "vt_true", "theta")], axis=1)
    y = np.stack([read[port] for port in ("vt", "vz", "theta")], axis=1)
    u = np.stack([read[port] for port in ("ax", "az", "q")], axis=1)
    first, second = (error_bound(steps, x, (y, u), tuning, scales, SETTLED) for scales in UNITS)
    return Evaluated(N, (first, second))


def findings(pictures: Path, *, short: bool = False) -> Iterator[Finding]:
    """Theorem 1, what it says of the horizon, and the two norms of 4.3."""
    frames, horizons = (SHORT_FRAMES, SHORT_HORIZONS) if short else (FRAMES, HORIZONS)
    found = [evaluated(N, frames) for N in horizons]
    yield _theorem(found, pictures)
    yield _grows(found)
    yield from _norms(found)


def _theorem(found: Sequence[Evaluated], pictures: Path) -> Finding:
    def claim(unit: int) -> bool:
        bounds = [one.bounds[unit] for one in found]
        return all(bound.a < 1.0 and bound.largest_error <= bound.limit for bound in bounds)

    verdict, condition = judged((UNIT,), claim)
    name = "003_theorem_1.png"
    with figure(5.0, 2.8) as drawn:
        axis = drawn.subplots()
        horizons = [one.N for one in found]
        axis.plot(horizons, [one.bounds[1].limit for one in found], "o-", color=COLOURS[1], label="bound b/(1 - a)")
        axis.plot(horizons, [one.bounds[1].largest_error for one in found], "o-", color=COLOURS[0], label="largest error")
        axis.set_yscale("log")
        axis.set_xlabel("N, transitions")
        axis.set_ylabel("error, standard deviations")
        axis.legend()
        save(drawn, pictures / name)
    lines = ["| N | norms in | a | b | bound b/(1 - a) | largest error | M has to exceed (43) | M is |", "|---:|---|" + "---:|" * 6]
    for one in found:
        for scales, bound in zip(UNITS, one.bounds, strict=True):
            limit = f"{bound.limit:.1f}" if np.isfinite(bound.limit) else "none"
            needed = f"{bound.needed_m:.3g}" if np.isfinite(bound.needed_m) else "cannot"
            cells = f"{bound.a:.3g} | {bound.b:.3g} | {limit} | {bound.largest_error:.2f} | {needed} | {bound.mu_m:.3g}"
            lines.append(f"| {one.N} | {scales.name} | {cells} |")
    text = (
        "All constants are the smallest that the run allows (`verification/reference/mho/error_bound.py`), on the first flight "
        "with Table I's noise. The printed M and W weigh rad and kt: their norms mix both, W's largest entry (theta, 3.28e5) meets "
        "F's largest (V_t dV_z/d alpha, some 300 kt/rad), and a says nothing. In standard deviations the bound exists and holds, "
        "and is conservative. The sufficient condition (43) asks for a larger M than the paper's even then; a itself needs "
        "none, because delta_Gamma is small.\n\n" + "\n".join(lines)
    )
    stated = "With suitable M and W, a < 1, and the estimation error stays below b/(1 - a)"
    return Finding(PAPER, "Theorem 1", "bound of the error", stated, verdict, condition, text, (name,))


def _grows(found: Sequence[Evaluated]) -> Finding:
    def claim(unit: int) -> bool:
        return all(later.bounds[unit].b > one.bounds[unit].b for one, later in pairwise(found))

    verdict, condition = judged((UNIT,), claim)
    values = "; ".join(
        f"{scales.name}: " + ", ".join(f"{one.bounds[i].b:.3g}" for one in found) for i, scales in enumerate(UNITS)
    )
    horizons = ", ".join(str(one.N) for one in found)
    errors = ", ".join(f"{one.bounds[1].largest_error:.2f}" for one in found)
    text = f"b at N = {horizons}: {values}. The largest error itself, in standard deviations: {errors}; it does not follow the bound."
    stated = "b, and with it the bound, grows monotonically with the horizon"
    return Finding(PAPER, "Theorem 1", "bound and horizon", stated, verdict, condition, text)


SEEN = Factor(("the horizon measures every direction of the state, as in flight", "it measures one direction alone"))


def gamma_of_one_direction() -> float:
    """The norm of Gamma where one sum of two states is measured, very well, and M weighs them as 1 to a million."""
    M, F = np.diag([1.0, 1e6]), np.array([[1.0, 1.0]])
    return float(np.linalg.norm(np.linalg.solve(M + 1e12 * F.T @ F, M), 2))


def _norms(found: Sequence[Evaluated]) -> Iterator[Finding]:
    def gamma(seen: int, unit: int) -> bool:
        if seen == 1:
            return gamma_of_one_direction() < 1.0
        return all(one.bounds[unit].delta_gamma < 1.0 for one in found)

    verdict, condition = judged((SEEN, UNIT), gamma)
    text = (
        _values("delta_gamma", found) + " Every horizon of a flight measures the whole state well. (28) itself bounds the "
        f"spectral radius, not the norm: where one direction alone is measured the norm is {gamma_of_one_direction():.2f}."
    )
    yield Finding(PAPER, "Section 4.3", "delta_Gamma", "delta_Gamma < 1 according to (28)", verdict, condition, text)

    verdict, condition = judged((UNIT,), lambda unit: all(one.bounds[unit].delta_xi < 1.0 for one in found))
    text = (
        _values("delta_xi", found) + " In pull-ups the row of V_t, in kt per rad, makes the norm exceed 1 although the spectral "
        "radius never does (Fig. 5). Then (42) and (43) say nothing."
    )
    stated = "delta_Xi < 1 due to the pre-stabilising observer"
    yield Finding(PAPER, "Section 4.3", "delta_Xi", stated, verdict, condition, text)


def _values(symbol: str, found: Sequence[Evaluated]) -> str:
    rows = (
        f"{scales.name}: " + ", ".join(f"{getattr(one.bounds[i], symbol):.3g}" for one in found)
        for i, scales in enumerate(UNITS)
    )
    return f"At N = {', '.join(str(one.N) for one in found)}, {'; '.join(rows)}."
