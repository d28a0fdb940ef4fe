"""Paper 002's findings, shortened: verdicts and numbers against the paper, and what is known without running."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from verification.papers import double_mhe_runs, paper_002
from verification.papers.document import markdown, read_findings
from verification.papers.double_mhe_runs import LEVELS, cost, profile, windows
from verification.papers.finding import Verdict
from verification.plants.scalar_system import ScalarSystem
from verification.reference.double_mhe.model import Window


@pytest.fixture(scope="module")
def found(tmp_path_factory):
    folder = tmp_path_factory.mktemp("papers")
    return {f"{f.item}: {f.title}": f for f in paper_002.findings(folder, short=True)}


def test_the_verdicts(found):
    assert {name: f.verdict for name, f in found.items()} == {
        "Table I: error from the true guess": Verdict.ONLY_IF,
        "Table I: DMHE from a wrong guess": Verdict.HOLDS,
        "Table I: NMHE from a wrong guess": Verdict.FAILS,
        "Table I: execution time": Verdict.FAILS,
        "Fig. 2: local minima": Verdict.FAILS,
        "Fig. 3(a): estimates, true guess": Verdict.HOLDS,
        "Fig. 3(b): estimates, wrong guess": Verdict.FAILS,
    }
    assert "u = 5, 10, 20" in found["Table I: error from the true guess"].condition
    assert markdown(found.values()).count("### ") == 7


def test_the_shipped_document_says_the_same(found):
    shipped = read_findings(Path(__file__).parents[3] / "docs" / "papers")
    verdicts = [(f.item, f.title, f.verdict) for f in shipped if f.paper == "002"]
    assert verdicts == [(f.item, f.title, f.verdict) for f in found.values()]


def test_verdicts_follow_the_numbers():
    """The same rules on the paper's own numbers find what the paper says."""
    true = {sheet: error for sheet, (error, _) in paper_002.TABLE_I.items()}
    wrong = {sheet: error for sheet, (_, error) in paper_002.TABLE_I.items()}
    level = paper_002.Level((1.0,), 1.0, true, wrong, (9.0, 100.0))
    assert paper_002.accuracy([level], "").verdict is Verdict.HOLDS
    assert paper_002.wrong_guess([level]).verdict is Verdict.HOLDS
    assert paper_002.any_guess([level]).verdict is Verdict.FAILS  # 11.59 is 1.24 times 9.33


def test_the_biased_stage_has_the_mean_of_the_noise():
    """CMHE follows the measurements, whose mean error is 0.05: 300 samples give about 15, whatever the control."""
    for levels in LEVELS[::3]:
        error = double_mhe_runs.sums(ScalarSystem(levels, 3.0), 0.0, (1,))["convexified_mhe"]
        assert error == pytest.approx(0.05 * 300, rel=0.05)


def test_the_profile_is_the_least_over_all_trajectories():
    """Dynamic programming against every trajectory of three samples on a coarse grid; ends count as minima."""
    window = Window(np.array([0.1, 0.5, 0.3]), np.array([3.0, -2.0]), -0.4)
    found = profile(window, points=31)
    grid = np.linspace(-1.0, 2.0, 31)
    for i in (0, 7, 18, 30):
        every = [cost(np.array([a, b, grid[i]]), window) for a in grid for b in grid]
        assert found.cost[i] == pytest.approx(min(every), rel=1e-12)
    bent = double_mhe_runs.Profile(np.linspace(-1, 2, 7), np.array([3.0, 1.0, 2.0, 0.5, 1.0, 2.0, 1.5]))
    assert bent.minima == 3 and bent.at == 0.5
    assert double_mhe_runs.Profile(np.linspace(-1, 2, 3), np.array([1.0, 2.0, 3.0])).minima == 1


def test_the_profile_agrees_with_the_estimates():
    for window, x in windows(ScalarSystem(duration=0.3), -1.0, 3, 6):
        assert abs(profile(window).at - x[-1]) < 0.0051
