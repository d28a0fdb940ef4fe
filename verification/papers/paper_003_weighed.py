"""Paper 003, conclusions: accuracy against cost of all its estimators."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from verification.papers.conditions import Factor, judged
from verification.papers.finding import Finding
from verification.papers.mho_runs import FLIGHTS, WOD, Variant, run
from verification.papers.paper_003 import DISTURBED, FILTER, GAIN, NOISE, OBSERVER, PAPER, WEIGHT, seeds_of
from verification.papers.paper_003_fig6 import HORIZONS, SHORT_HORIZONS
from verification.papers.style import COLOURS, figure, save
from verification.results.horizon_operations import cost, filter_operations

READING = Factor(
    ("MHO-PE, MHO-wD and MHO-woD are compared at one long horizon", "every estimator may choose its horizon")
)

TICKS = (200, 500, 1000, 2000, 5000)


@dataclass(frozen=True)
class Choice:
    """One estimator at one horizon."""

    variant: Variant
    N: int | None
    operations: int
    errors: tuple[float, float]
    """rms error of alpha with noise, and with biases besides, the mean over the flights [deg]."""

    @property
    def name(self) -> str:
        """As the text calls it."""
        return self.variant.name if self.N is None else f"{self.variant.name}, N = {self.N}"

    def beats(self, other: Choice, noise: int) -> bool:
        """Cheaper and more accurate."""
        return self.operations < other.operations and self.errors[noise] < other.errors[noise]


def choices(variants: Sequence[Variant], horizons: Sequence[int], seeds: tuple[int, ...]) -> list[Choice]:
    """Every variant at every horizon."""
    found = []
    for variant in variants:
        for N in (None,) if variant in FILTER else horizons:
            one = run(variant, N or 1, seeds)
            errors = [float(np.mean([one.rms(flight, noise) for flight in range(len(FLIGHTS))])) for noise in (0, 1)]
            operations = filter_operations() if N is None else cost(variant.sheet, N).operations
            found.append(Choice(variant, N, operations, (errors[0], errors[1])))
    return found


def findings(pictures: Path, *, short: bool = False) -> Iterator[Finding]:
    """The compromise."""
    seeds, horizons = seeds_of(short), SHORT_HORIZONS if short else HORIZONS
    found = choices((*FILTER, *OBSERVER, WOD, *DISTURBED), horizons, seeds)

    def claim(reading: int, noise: int, weight: int, gain: int) -> bool:
        if reading == 0:
            own, open_loop, disturbed = (
                next(one for one in found if one.variant == variant and horizons[-1] == one.N)
                for variant in (OBSERVER[gain], WOD, DISTURBED[weight])
            )
            return own.operations < disturbed.operations and own.errors[noise] < open_loop.errors[noise]
        rivals = [one for one in found if one.variant in (FILTER[weight], WOD, DISTURBED[weight])]
        mine = [one for one in found if one.variant == OBSERVER[gain]]
        return any(not any(rival.beats(one, noise) for rival in rivals) for one in mine)

    verdict, condition = judged((READING, NOISE, WEIGHT, GAIN), claim)
    name = "003_weighed.png"
    _draw(pictures / name, found)
    lines = ["| with | not beaten in both cost and error: operations, rms error in deg |", "|---|---|"]
    for noise, title in enumerate(("noise", "noise and biases")):
        best = sorted((one for one in found if not any(other.beats(one, noise) for other in found)), key=lambda one: one.operations)
        row = "; ".join(f"{one.name}: {one.operations}, {one.errors[noise]:.3f}" for one in best)
        lines.append(f"| {title} | {row} |")
    text = (
        f"Every estimator at every horizon of Fig. 6, MHO-wD as a block-tridiagonal system. Two readings: at N = {horizons[-1]} "
        "MHO-PE costs less than MHO-wD and errs less than MHO-woD; or, MHO-PE has a horizon at which no other estimator, at "
        "whatever horizon, has both fewer operations and a smaller rms error.\n\n" + "\n".join(lines)
        + "\n\nWhere the prediction over a long horizon is the trouble, a short horizon is the cheaper cure: MHO-woD at N = 2 costs "
        "two thirds of MHO-PE at N = 2, and errs less."
    )
    stated = "MHO-PE achieves a good compromise between performance and computation, compared to EKF, MHO-wD and MHO-woD"
    yield Finding(PAPER, "Section 6", "the compromise", stated, verdict, condition, text, (name,))


def _draw(path: Path, found: Sequence[Choice]) -> None:
    shown = (OBSERVER[0], OBSERVER[1], WOD, DISTURBED[0])
    with figure(7.2, 3.2) as drawn:
        for noise, (axis, title) in enumerate(zip(drawn.subplots(1, 2), ("noise", "noise and input biases"), strict=True)):
            for number, variant in enumerate(shown):
                rows = [one for one in found if one.variant == variant]
                x, y = [one.operations for one in rows], [one.errors[noise] for one in rows]
                axis.plot(x, y, "o-", ms=2.5, lw=0.8, color=COLOURS[number], label=variant.name)
            for variant, mark in zip(FILTER, ("*", "x"), strict=True):
                one = next(c for c in found if c.variant == variant)
                axis.plot([one.operations], [one.errors[noise]], mark, ms=7, color=COLOURS[4], label=variant.name)
            axis.set_xscale("log")
            axis.set_xticks(TICKS, [str(tick) for tick in TICKS])
            axis.minorticks_off()
            axis.set_title(title)
            axis.set_xlabel("operations a frame")
            axis.set_ylabel("rms error of alpha, deg")
        drawn.axes[0].legend()
        save(drawn, path)
