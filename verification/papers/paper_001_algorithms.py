"""Paper 001: the model of Section V, and what its Sections III and IV say about the algorithms, measured on it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import pairwise
from pathlib import Path

import numpy as np

from verification.papers.cstr_runs import (
    NAMES,
    Horizon,
    Refusals,
    Updates,
    operations,
    refusals,
    rms,
    run_sheets,
    updates,
)
from verification.papers.finding import Finding, Verdict
from verification.papers.style import COLOURS, LIMIT, figure, save
from verification.plants.cstr import COOL, HOT
from verification.reference.cstr.reactor import jacobian, right_hand_side
from verification.reference.cstr.sensitivity import PRINTED
from verification.reference.cstr.tuning import Tuning

PAPER = "001"
TUNING = Tuning()

PRINTED_ALPHA = 1.95e4

NEARLY = 0.05
"""Nearly all: all but this share."""

STATIONARY = 1e-6
"""A gradient of J/2 below this is rounding: J's weights are 1e3 to 1e4."""

GOOD = 0.1
"""A good approximation: the update leaves at most this fraction of the distance to the exact solution."""

QUICK = 0.5
"""A quick update: at most this fraction of the minimisation's operations."""


def findings(pictures: Path, *, short: bool = False) -> Iterator[Finding]:
    """The model, the eigenvalue of Theorem 1, and Algorithm 2 step by step; short: fewer and shorter runs."""
    seeds, steps = (range(1, 2), 60) if short else (range(1, 5), 250)
    yield model()
    yield eigenvalue()
    found = updates(seeds, steps, TUNING)
    yield prediction(found)
    yield neighbourhood(found, pictures)
    yield gain(*(refusals(seeds, steps, TUNING, sign) for sign in (1.0, PRINTED)))
    runs = run_sheets(range(1, 17) if short else range(1, 51), TUNING.N)
    yield boundary(runs)
    yield unaffected(runs)
    yield quick((2, 3, 5, 10))


def model() -> Finding:
    """Section V: the printed model."""
    rows, balanced, stable = [], True, True
    for point in (HOT, COOL):
        x = np.array([point.concentration, point.temperature])
        right = right_hand_side(x, point.flow, TUNING)
        heat = TUNING.alpha * point.flow * (x[1] - TUNING.x_cw)
        printed = -right - np.array([0.0, heat * (1.0 - PRINTED_ALPHA / TUNING.alpha)])
        eigenvalues = np.linalg.eigvals(jacobian(x, point.flow, TUNING))
        balanced &= bool(np.abs(printed).max() < 1e-3)
        stable &= bool((-eigenvalues).real.max() < 0.0)
        rows.append(
            f"| ({x[0]:g}, {x[1]:g}), u = {point.flow:g} | {np.abs(right).max():.1e} | {np.abs(printed).max():.1e} | "
            f"{eigenvalues.real.max():.3f} | {(-eigenvalues).real.max():.3f} |"
        )
    verdict = Verdict.HOLDS if balanced and stable else Verdict.FAILS
    text = (
        "The set-points of Hicks and Ray's reactor, from which the model is taken. Largest |dx/dtau|, and largest real part of an "
        "eigenvalue of the linearised reactor, with alpha = 1.95e-4:\n\n"
        "| set-point | ours | as printed | eigenvalue, ours | eigenvalue, printed signs |\n|---|---|---|---|---|\n"
        + "\n".join(rows)
        + "\n\nBoth printed right-hand sides have the sign of reversed time: every stable set-point repels. alpha = 1.95e4 "
        "is 1e8 times too large, and theta is not given; 20 balances both set-points. The right ones are dx1/dtau = (1 - x1)/theta - r, "
        "dx2/dtau = (x_f - x2)/theta + r - alpha u (x2 - x_cw), r = k_0 x1 exp(-E_a/x2)."
    )
    claim = "the printed right-hand sides with alpha = 1.95e4 are those of a reactor that a controller holds at a set-point"
    return Finding(PAPER, "Section V", "the model as printed", claim, verdict, "", text)


def eigenvalue() -> Finding:
    """Theorem 1 and Corollary 1: the eigenvalue a(p, delta)."""
    generator = np.random.default_rng(1)
    printed, right = [], []
    for c1, c2, c3, k_f, p, delta in generator.uniform(0.1, 3.0, (100, 6)):
        share = p / (p + c3 * delta)
        A = np.array([[c1 * p, c1 * k_f * p], [c2 * share, c2 * k_f * share]])
        largest = float(np.abs(np.linalg.eigvals(A)).max())
        printed.append(abs(c1 * p + c2 * share - largest))
        right.append(abs(c1 * p + c2 * k_f * share - largest))
    verdict = Verdict.HOLDS if max(printed) < 1e-9 else Verdict.FAILS
    text = (
        f"For 100 random sets of constants, k_f, p and delta the printed a differs from the larger eigenvalue of A(p, delta) by up to "
        f"{max(printed):.2f}; c1 p + c2 k_f p/(p + c3 delta) by up to {max(right):.0e}. A has rank one, so that is its trace. With k_f the "
        "paper's remark is right that a more contractive system allows a larger p. The bounds (12) and (13) "
        "cannot be evaluated: the constants c1 to c11 are called suitable and not given."
    )
    claim = "the eigenvalues of A(p, delta) are 0 and a = c1 p + c2 p/(p + c3 delta)"
    return Finding(PAPER, "Theorem 1", "the eigenvalue behind the stability condition (15)", claim, verdict, "", text)


def prediction(found: Updates) -> Finding:
    """Proposition 1."""
    largest = float(found.stationary.max())
    verdict = Verdict.HOLDS if largest < STATIONARY and found.curvature.min() > 0.0 else Verdict.FAILS
    text = (
        f"In {len(found.held)} windows, solved to rounding, the largest free element of the gradient of J/2 of the longer problem at the "
        f"prediction is {largest:.0e}, and the free part of its Hessian is positive definite in "
        f"{np.mean(found.curvature > 0.0):.0%} of them. It has to be: the new sample's disturbance and innovation are both zero there, so it adds "
        "nothing to the gradient. IPOPT, started there, stays "
        "(`tests/verification/reference/cstr/test_cstr_reference.py::test_proposition_1_the_prediction_solves_the_longer_problem`)."
    )
    claim = "the optimal estimates and their one-step-ahead prediction solve the problem (23) with the predicted output"
    return Finding(PAPER, "Proposition 1", "the prediction is optimal", claim, verdict, "", text)


def neighbourhood(found: Updates, pictures: Path) -> Finding:
    """Theorem 4 and what follows (26): where the linear update is good."""
    size, free = np.abs(found.innovation), ~found.held
    edges = np.quantile(size, [0.0, 0.25, 0.5, 0.75, 0.9, 1.0])
    bins = [(size >= a) & (size <= b) for a, b in pairwise(edges)]
    inside = [found.left(rows & free) for rows in bins]
    near_good, grows = inside[0] <= GOOD, max(inside[2:]) > 2.0 * inside[0]
    change_hurts = found.worse(found.changed) > found.worse(~found.changed)
    verdict = Verdict.HOLDS if near_good and grows and change_hurts else Verdict.FAILS
    with figure(6.4, 3.0) as drawn:
        axes = drawn.subplots()
        for rows, colour, label in (
            (~found.changed, COLOURS[0], "the same components on a bound"),
            (found.changed, COLOURS[1], "others on a bound in the exact solution"),
        ):
            axes.plot(np.abs(found.before[rows]), np.abs(found.after[rows]), ".", color=colour, markersize=3, label=label)
        end = float(np.abs(found.before).max())
        axes.plot([1e-6, end], [1e-6, end], color=LIMIT, linestyle="--", linewidth=0.8)
        axes.set(xscale="log", yscale="log", xlim=(1e-5, 2 * end), ylim=(1e-8, 2 * end))
        axes.set_xlabel("distance of the prediction from the exact solution; dashed: no gain")
        axes.set_ylabel("distance of the update")
        axes.legend(loc="upper left")
        save(drawn, pictures / "001_updates.png")
    table = "\n".join(
        f"| {a:.3f} to {b:.3f} | {rms(found.before[rows]):.4f} | {found.left(rows & free):.2f} | "
        f"{found.worse(rows & free):.0%} | {found.left(rows):.2f} | {found.worse(rows):.0%} |"
        for (a, b), rows in zip(pairwise(edges), bins, strict=True)
    )
    text = (
        f"{len(free)} windows of N + 2 samples, N = {TUNING.N}, each also solved exactly. Distance of the present concentration from the exact solution, rms: of the "
        "prediction, and what the update leaves of it; share of windows that it takes farther away.\n\n"
        "| innovation | prediction | left, none held | farther | left, all | farther |\n|---|---|---|---|---|---|\n"
        f"{table}\n\n"
        f"Where no component is held the update leaves {found.left(free):.2f}. In {np.mean(found.held):.0%} of the windows a concentration of "
        f"the reference lies on its bound 0 and is held: there it leaves {found.left(found.held):.2f} and goes farther away in "
        f"{found.worse(found.held):.0%}. In {np.mean(found.changed):.0%} of all windows the exact solution has other components on a bound than the "
        f"reference (in {np.mean(found.changed[found.held]):.0%} of those with a held one): the update leaves {found.left(found.changed):.2f} and goes farther "
        f"in {found.worse(found.changed):.0%}, against {found.left(~found.changed):.2f} and {found.worse(~found.changed):.0%} where the active set stays. "
        "A linear formula cannot know that the new output frees a component. Moving held components as (26) "
        f"is printed and projecting (Remark 1) leaves {found.left(found.held, plain=True):.2f} where one is held, but goes farther away in "
        f"{found.worse(found.held, plain=True):.0%} of those windows."
    )
    claim = "the linear update (26) is good near the predicted output, and can be worse than none far from it, in particular if the active set changes"
    return Finding(PAPER, "Theorem 4", "where the linear update is good", claim, verdict, "", text, ("001_updates.png",))


def gain(right: Refusals, printed: Refusals) -> Finding:
    """The gain K_t below (26)."""
    verdict = Verdict.HOLDS if printed.failed <= NEARLY else Verdict.FAILS
    rows = "\n".join(
        f"| {name} | {made.failed:.1%} | {made.concentration:.4f} | {made.temperature:.4f} |"
        for name, made in (("with a minus sign", right), ("as printed", printed))
    )
    text = (
        f"Share of {right.windows} updates, (24) and (25) satisfied, that fail test (27), and rms errors of what is put out:\n\n"
        f"| K_t | fail | concentration | temperature |\n|---|---|---|---|\n{rows}\n\n"
        "K_t is minus the inverse Hessian times the mixed derivative, by the implicit function theorem. Without the minus every update goes the "
        "wrong way, the test of step 3 refuses it, and Algorithm 2 becomes pure prediction. Nothing fails openly, and the "
        "concentration that Fig. 1 shows does not tell the two apart; the temperature, which is measured, does."
    )
    claim = "K_t is the inverse Hessian times the mixed derivative by states and y_t"
    return Finding(PAPER, "(26)", "the sign of K_t", claim, verdict, "", text)


def boundary(runs: Horizon) -> Finding:
    """(24) and (25), and the boundary of X."""
    first = runs.N + 1
    at_bound = runs.at_bound("cstr_mhe")
    shares = {sheet: _accepted(runs, sheet, first) for sheet in ("cstr_ahead", "cstr_ahead_no_est")}
    ordinary = at_bound <= NEARLY
    verdict = Verdict.HOLDS if ordinary else Verdict.ONLY_IF
    condition = "" if ordinary else f"no component lies on a bound of X, which {at_bound:.0%} of the windows here do"
    text = (
        f"N = {runs.N}, {len(runs.x)} runs. A concentration of the window lies on its bound 0 in {at_bound:.1%} of the windows, "
        f"{runs.at_bound('cstr_mhe_no_est'):.1%} without noises. The gradient is not zero there and "
        "(24) fails, although the estimate is optimal. The sheets hold such components: (24) and (25) are asked of the others only, "
        "the update leaves the held ones where they are, and is projected onto X. Then "
        + ", ".join(f"{NAMES[sheet]} takes {share:.1%} of its updates" for sheet, share in shares.items())
        + ". Away from a minimum the Hessian is indefinite, as a rule "
        "(`test_the_hessian_is_not_positive_definite_everywhere`), so the passes use Gauss-Newton's."
    )
    claim = "the second-order conditions of a minimum are (24) and (25)"
    return Finding(PAPER, "(24), (25)", "at the boundary of X", claim, verdict, condition, text)


def _accepted(runs: Horizon, sheet: str, first: int) -> float:
    accepted = runs.by_sheet[sheet].accepted
    assert accepted is not None
    return float(np.mean(accepted[:, first:]))


def unaffected(runs: Horizon) -> Finding:
    """Remark 2."""
    pairs = (("cstr_mhe", "cstr_ahead"), ("cstr_mhe_no_est", "cstr_ahead_no_est"))
    differ = sum(int(np.sum(runs.by_sheet[a].window != runs.by_sheet[b].window)) for a, b in pairs)
    verdict = Verdict.HOLDS if differ == 0 else Verdict.FAILS
    count = sum(runs.by_sheet[a].window.size for a, _ in pairs)
    text = (
        f"The windows that Algorithm 2 minimises and Algorithm 1's, with and without noises: {differ} of {count} numbers differ in any "
        "bit. The update only ever decides what is put out."
    )
    claim = "the estimation recursion is unaffected by the linear update"
    return Finding(PAPER, "Remark 2", "the recursion is unaffected", claim, verdict, "", text)


def quick(lengths: Sequence[int]) -> Finding:
    """Section IV: the update is quick."""
    counted = {(sheet, N): operations(sheet, N) for sheet in ("cstr_ahead", "cstr_ahead_no_est") for N in lengths}
    share = max(found.waiting / found.minimisation for found in counted.values())
    verdict = Verdict.HOLDS if share <= QUICK else Verdict.FAILS
    rows = "\n".join(
        f"| {NAMES[sheet]} | {N} | {found.exact} | {found.frame} | {found.minimisation} | {found.ahead} | {found.waiting} | "
        f"{found.waiting / found.minimisation:.0%} |"
        for (sheet, N), found in counted.items()
    )
    text = (
        "Operations a frame, counted from what runs (`saoflow budget cstr_ahead`). The minimisation is a fixed number of passes, 4 with noises "
        "and 10 without; the update is all of steps 2 and 3 with its tests, and at most the last count has to wait for y_t: derivatives and held components do not.\n\n"
        "| | N | a frame of Algorithm 1 | of Algorithm 2 | its minimisation | its update | of that after y_t | share of the minimisation |\n"
        "|---|---|---|---|---|---|---|---|\n"
        f"{rows}\n\n"
        f"One of the four passes with N = 3 costs {counted['cstr_ahead', 3].minimisation // 4} operations, less than the whole update: that linearises a window "
        "one sample longer, and evaluates its cost once more for test (27). The minimisation knows the structure, too: both grow linearly with N. What the "
        "update saves is the wait for several passes."
    )
    claim = "a quick sensitivity calculation replaces the minimisation when the output arrives"
    return Finding(PAPER, "Section IV", "the cost of the update", claim, verdict, "", text)
