"""Paper 003's findings, shortened: verdicts, and their numbers against other computations."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from verification.flights.true_airspeed import INPUT_BIASES, load_pulls, readings
from verification.papers import (
    paper_003,
    paper_003_fig5,
    paper_003_fig6,
    paper_003_fig7,
    paper_003_fig8,
    paper_003_theorem1,
    paper_003_tuning,
    paper_003_weighed,
)
from verification.papers.conditions import Factor, judged
from verification.papers.finding import Verdict
from verification.papers.mho_runs import DEGREES, EKF, FLIGHTS, WD, WOD, noise_seed, run
from verification.reference.mho import ekf, estimator
from verification.reference.mho.error_bound import NOISE_UNITS, PRINTED_UNITS
from verification.reference.mho.mho_pe import mho_pe, mho_wod
from verification.reference.mho.mho_wd import mho_wd
from verification.reference.mho.tuning import MhoTuning

MODULES = (
    *(paper_003, paper_003_fig5, paper_003_fig6, paper_003_fig7, paper_003_fig8),
    *(paper_003_theorem1, paper_003_tuning, paper_003_weighed),
)


@pytest.fixture(scope="module")
def found(tmp_path_factory):
    folder = tmp_path_factory.mktemp("papers")
    made = [finding for module in MODULES for finding in module.findings(folder, short=True)]
    assert all((folder / name).is_file() for finding in made for name in finding.pictures)
    return {f"{f.item}: {f.title}": f for f in made}


def test_the_verdicts(found):
    # With one noise seed and without biases, errors that differ by 3 % do so by chance: left to the whole run.
    by_chance = ("Fig. 6: longer is not always better", "Fig. 6: MHO-wD is best", "Section 4.3: choice of M")
    chance = [found[name] for name in by_chance]
    assert all(f.verdict in (Verdict.HOLDS, Verdict.ONLY_IF) for f in chance)
    assert {name: f.verdict for name, f in found.items() if f not in chance} == {
        "Table I: noise and weights": Verdict.ONLY_IF,
        "Fig. 2: flight data": Verdict.NOT_HERE,
        "Fig. 3: estimates with N = 2": Verdict.ONLY_IF,
        "Fig. 4: estimates with N = 15": Verdict.HOLDS,
        "Fig. 5: spectral radius": Verdict.HOLDS,
        "Fig. 6: errors of MHO-woD": Verdict.HOLDS,
        "Fig. 6: MHO-PE against the EKF": Verdict.ONLY_IF,
        "Section 2.1: complexity": Verdict.HOLDS,
        "Fig. 7: computation time": Verdict.ONLY_IF,
        "Fig. 8: fault detection": Verdict.ONLY_IF,
        "Theorem 1: bound of the error": Verdict.ONLY_IF,
        "Theorem 1: bound and horizon": Verdict.HOLDS,
        "Section 4.3: delta_Gamma": Verdict.ONLY_IF,
        "Section 4.3: delta_Xi": Verdict.ONLY_IF,
        "Section 6: the compromise": Verdict.ONLY_IF,
    }


def test_the_conditions_are_what_is_known_of_the_paper(found):
    """The EKF is worst, and MHO-PE better than it, when the inputs carry constant errors, not by Table I's noise alone."""
    assert found["Table I: noise and weights"].condition == "Q(2) is read as 1512"
    for name in ("Fig. 3: estimates with N = 2", "Fig. 6: MHO-PE against the EKF"):
        assert "constant errors" in found[name].condition
        assert "nothing else" not in found[name].condition
    assert "one long horizon" in found["Section 6: the compromise"].condition
    assert "condensed" in found["Fig. 7: computation time"].condition
    assert "standard deviations" in found["Theorem 1: bound of the error"].condition


@pytest.mark.parametrize(("variant", "method", "N"), [(EKF, None, 1), (WOD, mho_wod, 15), (WD, mho_wd, 4)])
def test_the_runs_are_the_references(variant, method, N):
    """The compiled sheets with tables against the numpy reference with functions, biased inputs, first 8 s."""
    truth, tuning = load_pulls(FLIGHTS[1]), MhoTuning(N=N)
    rows = {port: v[:100] for port, v in readings(truth, noise_seed(1, 1), biases=INPUT_BIASES).inputs().items()}
    right = ekf.run(rows, tuning) if method is None else estimator.run(rows, tuning, method)
    error = (right["alpha_hat"] - truth["alpha_true"][:100]) * DEGREES
    np.testing.assert_allclose(run(variant, N, (1,)).error[1, 1, 0, :100], error, atol=1e-3)


def test_an_error_of_the_inputs_goes_through_the_open_loop_as_by_hand():
    """MHO-woD fits one state to 1.2 s: with q wrong by 0.5 deg/s and nothing else, theta is seen at both ends, so that the
    newest angle is off by half of what adds up; the errors of A_x and A_z do the rest."""
    both = run(WOD, 15, (1,)).error[0, :, 0, 63:].mean(axis=1)
    assert both[0] == pytest.approx(0.0, abs=0.03)
    assert both[1] - both[0] == pytest.approx(0.5 * 0.5 * 1.2, abs=0.08)


def test_a_verdict_names_what_decides():
    factors = (Factor(("a", "b")), Factor(("c", "d")), Factor(("e", "f")))
    assert judged(factors, lambda i, j, k: True) == (Verdict.HOLDS, "")
    assert judged(factors, lambda i, j, k: False) == (Verdict.FAILS, "")
    assert judged(factors, lambda i, j, k: i == 1) == (Verdict.ONLY_IF, "b")
    assert judged(factors, lambda i, j, k: i == 1 and k == 0) == (Verdict.ONLY_IF, "b and e")
    assert judged(factors[:2], lambda i, j: i != j) == (Verdict.ONLY_IF, "a and d; or if b and c")


def test_the_degree_of_a_polynomial():
    horizons = range(2, 9)
    assert paper_003_fig7.polynomial_degree([5 for _ in horizons]) == 0
    assert paper_003_fig7.polynomial_degree([3 * N + 1 for N in horizons]) == 1
    assert paper_003_fig7.polynomial_degree([N**3 - 2 * N**2 for N in horizons]) == 3
    assert paper_003_fig7.polynomial_degree([2**N for N in horizons]) == -1


def test_sizes_of_faults_are_on_the_sides_of_the_threshold_that_they_are_listed_on():
    """The rms of the fault alone once it fills the window, by hand: a bias its size, a sine its size over root 2."""
    for case in paper_003_fig8.CASES:
        if case.fault.kind == "runaway":
            continue
        size = case.fault.amplitude / (np.sqrt(2) if case.fault.kind == "oscillation" else 1.0)
        assert bool(size > paper_003_fig8.THRESHOLD) is case.shown
    slow, fast = (3.0 * case.fault.rate for case in paper_003_fig8.CASES if case.fault.kind == "runaway")
    assert slow < 1.8 * paper_003_fig8.THRESHOLD < fast


def test_a_runaway_is_found_when_its_rms_reaches_the_threshold():
    """By hand: after n frames of a ramp of 3 deg/s the mean square over 21 is (0.24 deg)^2 (1 + 4 + ... + (n-1)^2) / 21."""
    squares = np.cumsum((0.24 * np.arange(60)) ** 2)
    n = int(np.argmax(np.sqrt(squares / 21) > paper_003_fig8.THRESHOLD))
    delays = paper_003_fig8.detect((paper_003_fig8.CASES[1].fault,), (1,)).delays
    assert len(delays) == 4
    assert np.mean(delays) == pytest.approx(0.08 * n, abs=0.1)


# -- Theorem 1


def test_the_errors_of_the_run_obey_the_recursion():
    """||e_k|| <= a ||e_k-1|| + b in standard deviations, frame by frame, and with room."""
    one = paper_003_theorem1.evaluated(2, paper_003_theorem1.SHORT_FRAMES).bounds[1]
    truth, tuning = load_pulls(FLIGHTS[0]), MhoTuning(N=2)
    rows = {port: v[:130] for port, v in readings(truth, 1).inputs().items()}
    x = np.stack([truth[column][:130] for column in ("alpha_true", "vt_true", "theta")], axis=1)
    steps = list(estimator.steps(rows, tuning, mho_pe))
    errors = [np.linalg.norm((x[k - 2] - steps[k].solution.x[0]) / NOISE_UNITS.x) for k in range(63, 130)]
    assert max(errors) == pytest.approx(one.largest_error)
    assert all(b <= one.a * a + one.b for a, b in pairwise(errors))
    assert one.limit == pytest.approx(one.b / (1 - one.a))


def test_constants_of_the_bound_against_direct_formulas():
    """delta_L, delta_W and mu_M by hand; kappa_h below the curvature of V_t sin(alpha - theta), (V + 2)/2 in rad and kt."""
    one = paper_003_theorem1.evaluated(2, paper_003_theorem1.SHORT_FRAMES).bounds[0]
    tuning = MhoTuning()
    assert one.delta_l == pytest.approx(np.linalg.norm(tuning.gain, 2))
    assert one.delta_w == pytest.approx(3.283e5, rel=1e-3)
    assert one.mu_m == pytest.approx(0.04)
    assert 0 < one.kappa_h < 180
    assert one.delta_f > 300  # V_t itself stands in C
    assert one.a > 1
    assert PRINTED_UNITS.x == (1.0, 1.0, 1.0)
