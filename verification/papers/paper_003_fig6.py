"""Paper 003, Fig. 6: errors of the angle of attack against the horizon."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import pairwise
from pathlib import Path

import numpy as np

from verification.papers.conditions import judged
from verification.papers.finding import Finding
from verification.papers.mho_runs import FLIGHTS, NOISES, WOD, Run, Variant, run
from verification.papers.paper_003 import (
    DISTURBED,
    FILTER,
    GAIN,
    NOISE,
    OBSERVER,
    PAPER,
    WEIGHT,
    everywhere,
    seeds_of,
)
from verification.papers.style import COLOURS, SOFT, figure, save

HORIZONS = (2, 3, 4, 5, 6, 8, 10, 12, 15, 20)
SHORT_HORIZONS = (2, 4, 15)

CONVERGED = 0.03
"""An error has converged: it changes by less than this share over the last two horizons."""

BETTER = 0.005
"""An error that is not smaller by at least this share is not called smaller."""


def findings(pictures: Path, *, short: bool = False) -> Iterator[Finding]:
    """The four claims of Fig. 6."""
    seeds, horizons = seeds_of(short), SHORT_HORIZONS if short else HORIZONS
    name = "003_fig_6.png"
    _draw(pictures / name, horizons, seeds)
    table = _table(horizons, seeds)
    yield _open_loop(horizons, seeds, table, name)
    yield _pre_estimation(horizons, seeds)
    yield _disturbed(horizons, seeds)
    yield _longer_is_not_better(horizons, seeds)


def _curve(variant: Variant, horizons: Sequence[int], seeds: tuple[int, ...], flight: int, noise: int) -> list[float]:
    return [run(variant, N, seeds).rms(flight, noise) for N in horizons]


def _open_loop(horizons: Sequence[int], seeds: tuple[int, ...], table: str, picture: str) -> Finding:
    def claim(noise: int, weight: int) -> bool:
        def test(flight: int, noise: int) -> bool:
            curve = _curve(WOD, horizons, seeds, flight, noise)
            rising = all(b > a for N, (a, b) in zip(horizons, pairwise(curve), strict=False) if N >= 4)
            return rising and curve[-1] > run(FILTER[weight], 1, seeds).rms(flight, noise)

        return everywhere(test, noise)

    verdict, condition = judged((NOISE, WEIGHT), claim)
    text = (
        "The rule: on both flights its rms error rises from each horizon to the next from N = 4 on, and is larger than the EKF's at the "
        "longest. Errors of alpha in the first scenario:\n\n" + table
    )
    stated = "The errors of MHO-woD increase with the horizon and eventually exceed the EKF's"
    return Finding(PAPER, "Fig. 6", "errors of MHO-woD", stated, verdict, condition, text, (picture,))


def _pre_estimation(horizons: Sequence[int], seeds: tuple[int, ...]) -> Finding:
    def claim(noise: int, weight: int, gain: int) -> bool:
        def test(flight: int, noise: int) -> bool:
            curve = _curve(OBSERVER[gain], horizons, seeds, flight, noise)
            return max(curve) < (1.0 - BETTER) * run(FILTER[weight], 1, seeds).rms(flight, noise)

        return everywhere(test, noise)

    def converges(noise: int, gain: int) -> bool:
        return everywhere(lambda flight, noise: _settled(OBSERVER[gain], horizons, seeds, flight, noise), noise)

    verdict, condition = judged((NOISE, WEIGHT, GAIN), claim)
    converged, where = judged((NOISE, GAIN), converges)
    text = (
        "The rule: on both flights its rms error is smaller than the EKF's at every horizon. With white noise alone it is "
        "never: the observer takes the same measurements in twice, through L and through the objective, and the filter is "
        "already the best there is. With Q(2) as printed the filter believes its prediction of V_t too much, which costs it "
        f"most when the inputs carry constant errors.\n\nThat its errors converge with the horizon (less than {CONVERGED:.0%} change "
        f"over the last two horizons): {converged}{' ' + where if where else ''}."
    )
    stated = "The errors of MHO-PE are always smaller than the EKF's"
    return Finding(PAPER, "Fig. 6", "MHO-PE against the EKF", stated, verdict, condition, text)


def _settled(variant: Variant, horizons: Sequence[int], seeds: tuple[int, ...], flight: int, noise: int) -> bool:
    if len(horizons) < 3:
        horizons = (*horizons, horizons[-1] + 1)
    before, last = (run(variant, N, seeds).rms(flight, noise) for N in horizons[-2:])
    return abs(last / before - 1.0) < CONVERGED


def _disturbed(horizons: Sequence[int], seeds: tuple[int, ...]) -> Finding:
    def claim(noise: int, weight: int, gain: int) -> bool:
        def test(flight: int, noise: int) -> bool:
            others = [_curve(v, horizons, seeds, flight, noise) for v in (OBSERVER[gain], WOD)]
            own = _curve(DISTURBED[weight], horizons, seeds, flight, noise)
            # A tie at N = 2 within half a percent counts for it.
            return all(a <= (1.0 + BETTER) * min(b) for a, *b in zip(own, *others, strict=True))

        return everywhere(test, noise)

    verdict, condition = judged((NOISE, WEIGHT, GAIN), claim)
    text = (
        "The rule: on both flights and at every horizon no other observer's rms error is smaller, but for ties within "
        f"{BETTER:.1%}. It is the only one that lets the state be disturbed as it is."
    )
    stated = "MHO-wD achieves the best performance of the observers"
    return Finding(PAPER, "Fig. 6", "MHO-wD is best", stated, verdict, condition, text)


def _longer_is_not_better(horizons: Sequence[int], seeds: tuple[int, ...]) -> Finding:
    def claim(noise: int, weight: int, gain: int) -> bool:
        def test(flight: int, noise: int) -> bool:
            curves = [_curve(v, horizons, seeds, flight, noise) for v in (OBSERVER[gain], WOD, DISTURBED[weight])]
            return all(max(curve[1:]) > (1.0 + BETTER) * min(curve) for curve in curves)

        return everywhere(test, noise)

    verdict, condition = judged((NOISE, WEIGHT, GAIN), claim)
    best = [[_best(DISTURBED[0], horizons, seeds, flight, noise) for flight in range(len(FLIGHTS))] for noise in (0, 1)]
    text = (
        "The rule: on both flights each observer has a longer horizon at which its rms error is larger than at some shorter "
        "one. What a horizon averages out in noise it loses by errors of its model: MHO-wD is best at N = "
        f"{' and '.join(map(str, best[0]))} on the two flights with noise alone, at N = {' and '.join(map(str, best[1]))} "
        "when the inputs carry constant errors."
    )
    stated = "In all three observers a longer horizon may not reduce the error"
    return Finding(PAPER, "Fig. 6", "longer is not always better", stated, verdict, condition, text)


def _best(variant: Variant, horizons: Sequence[int], seeds: tuple[int, ...], flight: int, noise: int) -> int:
    curve = _curve(variant, horizons, seeds, flight, noise)
    return horizons[int(np.argmin(curve))]


def _table(horizons: Sequence[int], seeds: tuple[int, ...]) -> str:
    variants = (*OBSERVER, WOD, *DISTURBED)
    head = [f"{variant.name}{', ' + noise if i else ''}" for i, noise in enumerate(("", "biases")) for variant in variants]
    lines = ["| N | " + " | ".join(head) + " |", "|" + "---:|" * (len(head) + 1)]
    filters = [f"{one.name}: {run(one, 1, seeds).rms(0, 0):.3f}, with biases {run(one, 1, seeds).rms(0, 1):.3f} deg" for one in FILTER]
    for N in horizons:
        cells = [f"{run(v, N, seeds).rms(0, noise):.3f}" for noise in (0, 1) for v in variants]
        lines.append(f"| {N} | " + " | ".join(cells) + " |")
    return "\n".join(lines) + "\n\n(rms, deg.) " + "; ".join(filters) + "."


def _draw(path: Path, horizons: Sequence[int], seeds: tuple[int, ...]) -> None:
    measures = ((Run.rms, "rms error of alpha, deg"), (Run.largest, "largest error, deg"))
    with figure(7.2, 4.8) as drawn:
        axes = drawn.subplots(2, 2, sharex=True)
        for noise, title in enumerate(("noise", "noise and input biases")):
            for row, (measure, label) in enumerate(measures):
                axis = axes[row, noise]
                for number, variant in enumerate((*OBSERVER, WOD, DISTURBED[0])):
                    curve = [np.mean([measure(run(variant, N, seeds), f, noise) for f in range(len(FLIGHTS))]) for N in horizons]
                    axis.plot(horizons, curve, "o-", ms=2.5, lw=1.0, color=COLOURS[number], label=variant.name)
                for variant, style in zip(FILTER, ("-", "--"), strict=True):
                    level = np.mean([measure(run(variant, 1, seeds), f, noise) for f in range(len(FLIGHTS))])
                    axis.axhline(float(level), color=SOFT, lw=1.0, ls=style, label=variant.name)
                axis.set_ylabel(label)
            axes[0, noise].set_title(title)
            axes[1, noise].set_xlabel("N, transitions")
            axes[1, noise].set_xticks(range(2, 21, 3))
        axes[0, 0].legend(ncols=1)
        save(drawn, path)


assert len(NOISES) == len(NOISE.options)
