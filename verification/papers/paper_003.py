"""Paper 003: Table I with the weights made from it, the flights (Fig. 2), and the estimates at N = 2 and 15 (Figs. 3, 4)."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from verification.flights.true_airspeed import INPUT_BIASES, PERIOD, load_pulls
from verification.papers.conditions import Factor, judged
from verification.papers.finding import Finding, Verdict
from verification.papers.mho_runs import (
    DEGREES,
    EKF,
    EKF_PRINTED,
    FLIGHTS,
    PE,
    PE_PLACED,
    SCENARIOS,
    WD,
    WD_PRINTED,
    WOD,
    Run,
    Variant,
    error_table,
    run,
)
from verification.papers.style import COLOURS, TRUTH, figure, save

PAPER = "003"
SEEDS = tuple(range(1, 9))
SHORT_SEEDS = (1,)

NOISE = Factor(("the sensors have Table I's noise and nothing else", "the measured inputs carry constant errors besides"))
WEIGHT = Factor(("Q(2) is that of Table I's noise", "Q(2) is the printed 1.41e5"))
GAIN = Factor(("L is that of the Riccati equation", "L places the observer's poles at 0.5"))
FILTER = (EKF, EKF_PRINTED)
DISTURBED = (WD, WD_PRINTED)
OBSERVER = (PE, PE_PLACED)

ALIKE = 1.25
"""Estimates are almost the same: no rms error is more than so many times another."""


def seeds_of(short: bool) -> tuple[int, ...]:
    """The noise seeds."""
    return SHORT_SEEDS if short else SEEDS


def findings(pictures: Path, *, short: bool = False) -> Iterator[Finding]:
    """Table I, Figs. 2 to 4."""
    yield table_i()
    yield flights(pictures)
    yield short_horizon(pictures, seeds_of(short))
    yield long_horizon(pictures, seeds_of(short))


# -- Table I

DEVIATIONS = {"A_xm": 0.3215, "A_zm": 0.3215, "q_m": 0.0140, "V_tm": 0.7775, "V_zm": 0.5832, "theta_m": 0.0017}
"""Table I: kt/s^2, kt/s^2, rad/s, kt, kt, rad."""

PRINTED = {"W(1)": 1.65, "W(2)": 2.94, "W(3)": 3.28e5, "Q(1)": 8.01e5, "Q(2)": 1.41e5, "Q(3)": 8.01e5}

ROUNDING = 0.07
"""How far a printed weight may be from the inverse square of a deviation with two digits."""


def weights() -> dict[str, float]:
    """W and Q that follow from Table I: Q's entries from the noise of the input that drives the state, times t_s."""
    d = DEVIATIONS
    sources = (d["V_tm"], d["V_zm"], d["theta_m"], PERIOD * d["q_m"], PERIOD * d["A_xm"], PERIOD * d["q_m"])
    return {name: 1.0 / source**2 for name, source in zip(PRINTED, sources, strict=True)}


def table_i() -> Finding:
    """Whether the printed weights are the inverse covariances."""
    made = weights()
    off = [name for name, value in made.items() if abs(PRINTED[name] / value - 1.0) > ROUNDING]
    lines = ["| weight | printed | from Table I | printed / made |", "|---|---:|---:|---:|"]
    lines += [f"| {n} | {PRINTED[n]:.4g} | {v:.4g} | {PRINTED[n] / v:.2f} |" for n, v in made.items()]
    text = "\n".join(lines) + (
        "\n\nQ(2) is the weight of the disturbance of V_t, which the noise of A_x and A_z makes: 0.08 s times 0.3215 kt/s^2. "
        "The sheets take 1512; `--set q_v=1.41e5` is the printed one. Both are run below and named."
    )
    condition = f"{', '.join(off)} is read as {', '.join(f'{made[n]:.4g}' for n in off)}" if off else ""
    verdict = Verdict.HOLDS if not off else Verdict.ONLY_IF
    if len(off) == len(made):
        verdict, condition = Verdict.FAILS, ""
    claim = "Q^-1 and W^-1 are the covariances of the noises of Table I"
    return Finding(PAPER, "Table I", "noise and weights", claim, verdict, condition, text)


# -- Fig. 2


def flights(pictures: Path) -> Finding:
    """The flights in the place of the paper's."""
    name = "003_fig_2.png"
    rows = []
    with figure(7.2, 4.2) as drawn:
        axes = drawn.subplots(3, 2, sharex=True)
        for column, flight in enumerate(FLIGHTS):
            truth = load_pulls(flight)
            height = np.cumsum(truth["vz"]) * PERIOD * 1852 / 3600
            shown = ((truth["alpha_true"] * DEGREES, "alpha, deg"), (height, "change of height, m"), (truth["az"], "A_z, kt/s²"))
            for axis, (values, label) in zip(axes[:, column], shown, strict=True):
                axis.plot(truth["t"], values, color=COLOURS[0], lw=0.9)
                axis.set_ylabel(label)
            axes[0, column].set_title(f"{SCENARIOS[column]}: {flight}")
            axes[2, column].set_xlabel("t, s")
            ranges = " | ".join(f"{values.min():.1f} to {values.max():.1f}" for values, _ in shown)
            rows.append(f"| {SCENARIOS[column]} | `{flight}` | {ranges} |")
        save(drawn, pictures / name)
    text = (
        "In their place: two flights recorded with JSBSim in calm air (`verification/flights/true_airspeed.py`), sampled at "
        "0.08 s. Angle of attack, height and A_z change much, as in the paper's.\n\n"
        "| | flight | alpha, deg | change of height, m | A_z, kt/s² |\n|---|---|---:|---:|---:|\n" + "\n".join(rows)
    )
    why = "the benchmark's flight data are not published"
    claim = "Angle of attack, altitude and vertical specific force change significantly in two scenarios"
    return Finding(PAPER, "Fig. 2", "flight data", claim, Verdict.NOT_HERE, why, text, (name,))


# -- Figs. 3 and 4

SHOWN = (28.0, 44.0)
"""What the pictures show of a flight [s]: a push-over and a pull-up; a climb."""


def _draw(pictures: Path, name: str, N: int, variants: Sequence[Variant], seeds: tuple[int, ...], noise: int) -> None:
    with figure(7.2, 4.6) as drawn:
        axes = drawn.subplots(2, 2, sharex=True)
        for column, flight in enumerate(FLIGHTS):
            truth = load_pulls(flight)
            part = slice(round(SHOWN[0] / PERIOD), round(SHOWN[1] / PERIOD))
            t, alpha, upper, lower = truth["t"][part], truth["alpha_true"][part] * DEGREES, axes[0, column], axes[1, column]
            for number, variant in enumerate(variants):
                error = run(variant, N, seeds).error[column, noise, 0, part]
                upper.plot(t, alpha + error, color=COLOURS[number], lw=0.8, label=variant.name)
                lower.plot(t, error, color=COLOURS[number], lw=0.8)
            upper.plot(t, alpha, color=TRUTH, lw=0.8, label="truth")
            upper.set_title(SCENARIOS[column])
            upper.set_ylabel("alpha, deg")
            lower.set_ylabel("error of alpha, deg")
            lower.set_xlabel("t, s")
            lower.set_ylim(-0.6, 1.0)
        axes[0, 1].legend(ncols=2)
        save(drawn, pictures / name)


def everywhere(test: object, noise: int) -> bool:
    """Whether ``test(flight, noise)`` holds on every flight."""
    assert callable(test)
    return all(test(flight, noise) for flight in range(len(FLIGHTS)))


def short_horizon(pictures: Path, seeds: tuple[int, ...]) -> Finding:
    """Fig. 3."""
    N = 2

    def claim(noise: int, weight: int, gain: int) -> bool:
        of_filter = run(FILTER[weight], 1, seeds)
        observers = [run(v, N, seeds) for v in (OBSERVER[gain], WOD, DISTURBED[weight])]

        def test(flight: int, noise: int) -> bool:
            rms = [one.rms(flight, noise) for one in observers]
            return of_filter.rms(flight, noise) > max(rms) and max(rms) <= ALIKE * min(rms)

        return everywhere(test, noise)

    verdict, condition = judged((NOISE, WEIGHT, GAIN), claim)
    name = "003_fig_3.png"
    _draw(pictures, name, N, (EKF, PE, WOD, WD), seeds, noise=1)
    text = (
        f"{len(seeds)} noise seeds on each flight; the picture shows one, with the input errors "
        "(0.4 kt/s² on A_x and A_z, 0.5 deg/s on q). " + _rule(f"no observer's rms error is more than {ALIKE} times another's")
        + "\n\n" + error_table(_all(N, seeds))
        + "\n\nWith white noise alone the filter comes close to the best linear estimator there is, and nothing that forgets all but "
        "three samples beats it. Constant errors of the inputs are outside its assumptions: it carries them along in its "
        "covariance, while a short horizon begins anew from a wide arrival cost in every frame."
    )
    stated = "At N = 2 the EKF is worst in both scenarios, and the three observers are almost the same"
    return Finding(PAPER, "Fig. 3", "estimates with N = 2", stated, verdict, condition, text, (name,))


def long_horizon(pictures: Path, seeds: tuple[int, ...]) -> Finding:
    """Fig. 4."""
    N = 15

    def claim(noise: int, weight: int) -> bool:
        of_filter, observer = run(FILTER[weight], 1, seeds), run(WOD, N, seeds)
        return everywhere(lambda flight, noise: observer.rms(flight, noise) > of_filter.rms(flight, noise), noise)

    verdict, condition = judged((NOISE, WEIGHT), claim)
    name = "003_fig_4.png"
    _draw(pictures, name, N, (EKF, PE, WOD, WD), seeds, noise=1)
    text = (
        "As Fig. 3, N = 15.\n\n" + error_table(_all(N, seeds))
        + f"\n\nMHO-woD believes its prediction over {N * PERIOD:.1f} s: the noise of q alone, added up, is "
        f"{PERIOD * DEVIATIONS['q_m'] * DEGREES * N**0.5:.2f} deg by then, and a constant error of q of "
        f"{INPUT_BIASES.q * DEGREES:.1f} deg/s is {INPUT_BIASES.q * DEGREES * N * PERIOD:.1f} deg."
    )
    stated = "At N = 15 the observer without disturbance estimates (MHO-woD) is even worse than the EKF"
    return Finding(PAPER, "Fig. 4", "estimates with N = 15", stated, verdict, condition, text, (name,))


def _rule(more: str) -> str:
    return f"The rule: on both flights the filter's rms error of alpha is larger than every observer's, and {more}."


def _all(N: int, seeds: tuple[int, ...]) -> list[Run]:
    return [run(v, 1, seeds) for v in FILTER] + [run(v, N, seeds) for v in (*OBSERVER, WOD, *DISTURBED)]
