"""Paper 001's findings, shortened: verdicts and key numbers against what can be said without them."""

from __future__ import annotations

import numpy as np
import pytest

from verification.papers import paper_001, paper_001_algorithms
from verification.papers.cstr_runs import Estimated, Horizon, Operations, Refusals, Updates, operations, rms, run_sheets
from verification.papers.finding import Verdict
from verification.plants.cstr import simulate
from verification.reference.cstr.estimator import ALGORITHM_1, frames
from verification.reference.cstr.tuning import Tuning


@pytest.fixture(scope="module")
def found(tmp_path_factory):
    folder = tmp_path_factory.mktemp("papers")
    modules = (paper_001, paper_001_algorithms)
    made = [finding for module in modules for finding in module.findings(folder, short=True)]
    assert all((folder / name).stat().st_size < 150_000 for finding in made for name in finding.pictures)
    return {f"{f.item}: {f.title}": f for f in made}


def test_the_verdicts(found):
    assert {name: f.verdict for name, f in found.items()} == {
        "Fig. 1, top: estimating the disturbances": Verdict.HOLDS,
        "Fig. 1, top: at the beginning": Verdict.ONLY_IF,
        "Fig. 1, bottom: one step ahead against exact": Verdict.HOLDS,
        "Fig. 2: longer windows": Verdict.HOLDS,
        "Fig. 2: with and without noises": Verdict.ONLY_IF,
        "Fig. 2: N = 3": Verdict.ONLY_IF,
        "Section V: the model as printed": Verdict.FAILS,
        "Theorem 1: the eigenvalue behind the stability condition (15)": Verdict.FAILS,
        "Proposition 1: the prediction is optimal": Verdict.HOLDS,
        "Theorem 4: where the linear update is good": Verdict.HOLDS,
        "(26): the sign of K_t": Verdict.FAILS,
        "(24), (25): at the boundary of X": Verdict.ONLY_IF,
        "Remark 2: the recursion is unaffected": Verdict.HOLDS,
        "Section IV: the cost of the update": Verdict.HOLDS,
    }
    assert "(0.1367" not in found["Fig. 1, top: at the beginning"].condition


def horizon(N, errors):
    """Sheets whose concentrations are wrong by known numbers."""
    x = np.full((2, 40, 2), 0.2)
    by_sheet = {}
    for sheet, error in errors.items():
        x_hat = x + np.array([error, 0.0])
        by_sheet[sheet] = Estimated(x_hat, np.full((2, 40, N + 1, 2), 0.1), np.ones((2, 40), bool), np.ones((2, 40), bool))
    return Horizon(N, x, by_sheet)


def test_verdicts_follow_the_numbers(tmp_path):
    """The same rules on made-up estimators, which agree with the paper or do not."""
    like = {"cstr_mhe": 0.02, "cstr_mhe_no_est": 0.04, "cstr_ahead": 0.021, "cstr_ahead_no_est": 0.05}
    later = like | {"cstr_ahead": 0.0201}
    assert paper_001.noises_help(horizon(3, like)).verdict is Verdict.HOLDS
    assert paper_001.noises_help(horizon(3, like | {"cstr_mhe": 0.05})).verdict is Verdict.FAILS
    assert paper_001.one_step_ahead(horizon(3, like), tmp_path).verdict is Verdict.HOLDS
    assert paper_001.one_step_ahead(horizon(3, like | {"cstr_ahead": 0.03}), tmp_path).verdict is Verdict.FAILS
    assert paper_001.longer_windows([horizon(3, like), horizon(6, later)], tmp_path).verdict is Verdict.HOLDS
    assert paper_001.longer_windows([horizon(3, later), horizon(6, like)], tmp_path).verdict is Verdict.FAILS
    assert paper_001.nearer_with_noises([horizon(3, like), horizon(6, later)]).verdict is Verdict.HOLDS
    same = like | {"cstr_ahead": 0.03, "cstr_ahead_no_est": 0.041}
    assert paper_001.nearer_with_noises([horizon(3, same)]).verdict is Verdict.FAILS
    assert paper_001.nearer_with_noises([horizon(3, like), horizon(6, same)]).condition == "N is 3"
    assert paper_001.three_suffice([horizon(3, like), horizon(6, later)]).verdict is Verdict.HOLDS
    better = horizon(6, {sheet: error / 3 for sheet, error in like.items()})
    assert paper_001.three_suffice([horizon(3, like), better]).verdict is Verdict.ONLY_IF
    good, bad = Refusals(0.01, 0.05, 0.01, 10), Refusals(1.0, 0.05, 0.03, 10)
    assert paper_001_algorithms.gain(good, good).verdict is Verdict.HOLDS
    assert paper_001_algorithms.gain(good, bad).verdict is Verdict.FAILS
    assert paper_001_algorithms.boundary(horizon(3, like)).verdict is Verdict.HOLDS


def test_the_numbers_are_those_of_the_reference():
    """Errors and shares of the compiled sheet against the numpy reference, which goes its own way: within the table's error."""
    seeds = (1, 2)
    runs = run_sheets(seeds, 3, sheets=("cstr_mhe",))
    errors, bound = [], []
    for seed in seeds:
        made = simulate(seed)
        done = frames(made.recording, Tuning(), ALGORITHM_1)[4:]
        errors.append([frame.x_hat[0] - x[0] for frame, x in zip(done, made.x[4:], strict=True)])
        bound += [bool((frame.x[:, 0] == 0.0).any()) for frame in done]
    assert runs.error("cstr_mhe", 4) == pytest.approx(np.array(errors), abs=1e-3)
    assert rms(runs.error("cstr_mhe", 4)) == pytest.approx(rms(np.array(errors)), rel=1e-2)
    # about a tenth of the windows
    assert runs.at_bound("cstr_mhe") == pytest.approx(np.mean(bound), abs=0.01)
    assert 0.05 < runs.at_bound("cstr_mhe") < 0.15


def test_ratios_of_updates_by_hand():
    flags = np.array([True, False, False])
    made = Updates(np.zeros(3), np.array([4.0, 3.0, 1.0]), np.array([2.0, 0.3, 4.0]), np.ones(3), flags, flags, flags, flags)
    assert made.left(flags) == 0.5
    assert made.left(~flags) == pytest.approx(np.sqrt(16.09 / 10.0))
    assert made.worse(~flags) == 0.5
    assert made.left(flags, plain=True) == 0.25


def test_the_update_is_counted_from_the_budget():
    """At N = 3: an update does 857 operations, of which the expansion of the longer window needs no y_t."""
    assert operations("cstr_ahead", 3) == Operations(2291, 3152, 857, 471, 4 * 530)
