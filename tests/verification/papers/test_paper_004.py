"""Paper 004's findings, shortened; and each rule on made-up numbers, also on the paper's own."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from verification.papers import paper_004, paper_004_sensitivity, paper_004_tables
from verification.papers.air_data_runs import SCENARIOS, Jamming, Rate, Robustness, rates, runaway
from verification.papers.document import DocumentError, read_findings
from verification.papers.finding import Verdict
from verification.results.fault_sensitivity import ALPHA, VC


def titled(findings):
    return {f"{f.item}: {f.title}": f for f in findings}


def shipped():
    """The verdicts of docs/papers."""
    folder = Path(__file__).parents[3] / "docs" / "papers"
    return {f"{f.item}: {f.title}": f.verdict for f in read_findings(folder) if f.paper == "004"}


def test_the_verdicts_of_figures_3_to_6(tmp_path: Path):
    found = titled(paper_004.findings(tmp_path, short=True))
    verdicts = {name: f.verdict for name, f in found.items()}
    assert verdicts == {
        "Figs. 2, 3: robustness to wind": Verdict.HOLDS,
        "Fig. 3: robustness of the EKF": Verdict.ONLY_IF,
        "Fig. 4: benefit of the bounds": Verdict.HOLDS,
        "Fig. 4: the EKF": Verdict.HOLDS,
        "Fig. 5(a): sensitivity against the rate": Verdict.ONLY_IF,
        "Fig. 5(a): the weight of the wind": Verdict.HOLDS,
        "Fig. 5(b): sensitivity in wind": Verdict.ONLY_IF,
        "Fig. 6(a): jamming near the true value": Verdict.ONLY_IF,
        "Fig. 6(b): a failure that upsets the flight": Verdict.NOT_HERE,
    }
    assert all((tmp_path / name).is_file() for f in found.values() for name in f.pictures)
    assert verdicts.items() <= shipped().items()


def test_the_verdicts_of_section_iv(tmp_path: Path):
    found = titled(paper_004_sensitivity.findings(tmp_path, short=True))
    assert {name: f.verdict for name, f in found.items()} == {
        "Section IV: sensitivity at the wind's bound": Verdict.ONLY_IF,
        "Section IV: in the long run": Verdict.HOLDS,
        "Theorem 1: the inequality": Verdict.FAILS,
        "Theorem 1: the number of bounds": Verdict.FAILS,
    }
    assert {name: f.verdict for name, f in found.items()}.items() <= shipped().items()


def test_the_wind_meets_its_bound_when_the_fault_is_as_large():
    """60 kt of true airspeed at 350 kt and 5000 ft are about 56 kt of calibrated: -15 kt/s makes them in 3.7 s."""
    run = runaway("umhe_fte", (1,), duration=26.0)
    reached = run.at_bound[0]
    assert reached is not None and 3.6 < reached * run.period < 4.3
    assert run.delays == (None,)


def test_without_bounds_the_residual_is_what_the_wind_lags_behind():
    """UMHE follows a ramp with a constant lag: the residual is proportional to the rate, once above the noise."""
    slow, fast = (r.rms for r in rates(SCENARIOS[0], ("umhe_fte",), (1.0,), (6.0, 12.0)))
    assert fast / slow == pytest.approx(2.0, rel=0.15)


def rate_rows(cmhe, umhe, name=SCENARIOS[0].name):
    """Rates 2, 8, 12 and 16 kt/s, for both weights."""
    tried = (2.0, 8.0, 12.0, 16.0)
    return [
        Rate(name, sheet, q, rate, value)
        for sheet, values in (("cmhe_fte", cmhe), ("umhe_fte", umhe))
        for q in (1e-4, 1.0)
        for rate, value in zip(tried, values, strict=True)
    ]


def test_the_rules_of_fig_5_follow_the_numbers(tmp_path: Path):
    umhe = (1.0, 2.0, 3.0, 4.0)
    as_printed = rate_rows((1.0, 2.1, 9.0, 20.0), umhe)
    assert paper_004.fig_5a(as_printed, tmp_path).verdict is Verdict.HOLDS
    assert paper_004.fig_5a(rate_rows((1.0, 4.0, 9.0, 20.0), umhe), tmp_path).verdict is Verdict.ONLY_IF
    assert paper_004.fig_5a(rate_rows((1.0, 2.0, 3.0, 4.0), umhe), tmp_path).verdict is Verdict.FAILS
    _, two, three = (s.name for s in SCENARIOS)
    windy = as_printed + rate_rows((1.0, 5.0, 14.0, 30.0), umhe, two)
    assert paper_004.fig_5b(windy + rate_rows((1.0, 5.0, 13.0, 29.0), umhe, three), tmp_path).verdict is Verdict.HOLDS
    assert paper_004.fig_5b(windy + rate_rows((1.0, 2.0, 4.0, 9.0), umhe, three), tmp_path).verdict is Verdict.ONLY_IF
    same = as_printed + [r for name in (two, three) for r in rate_rows((1.0, 2.0, 9.0, 20.0), umhe, name)]
    assert paper_004.fig_5b(same, tmp_path).verdict is Verdict.FAILS
    assert paper_004.fig_5a_weight(as_printed).verdict is Verdict.FAILS  # nothing lost by either


def test_the_rules_of_figs_3_and_6_follow_the_numbers(tmp_path: Path):
    def rows(cmhe_1, ekf_1, cmhe_3):
        sizes = {"cmhe_fte": (cmhe_1, 2.0, cmhe_3), "umhe_fte": (1.0, 2.0, 3.0), "ekf_fte": (ekf_1, 5.0, 6.0)}
        return [Robustness(f"{i + 1}: wind", sheet, v[i], v[i]) for i in range(3) for sheet, v in sizes.items()]

    assert paper_004.fig_3(rows(1.0, 2.0, 9.0), tmp_path).verdict is Verdict.HOLDS
    assert paper_004.fig_3(rows(1.3, 2.0, 9.0), tmp_path).verdict is Verdict.FAILS
    assert paper_004.fig_3(rows(1.0, 2.0, 3.0), tmp_path).verdict is Verdict.FAILS
    assert paper_004.fig_3_ekf(rows(1.0, 2.0, 9.0)).verdict is Verdict.HOLDS
    assert paper_004.fig_3_ekf(rows(1.0, 1.0, 9.0)).condition == "there is wind: in scenario 2, not in calm air"
    right = Jamming("flight", (1.0, 5.0), (19.0, 18.0, None), (4.0, 4.5, None))
    wrong = Jamming("flight", (1.0, 5.0), (None, None, 30.0), (4.0, None, None))
    assert (right.verdict("alpha"), right.delay("alpha"), wrong.verdict("alpha"), wrong.verdict("vc")) == (
        "right",
        19.0,
        "wrong",
        "missed",
    )
    assert paper_004.fig_6a([right], tmp_path).verdict is Verdict.HOLDS
    assert paper_004.fig_6a([right, wrong], tmp_path).verdict is Verdict.ONLY_IF
    assert paper_004.fig_6a([wrong], tmp_path).verdict is Verdict.FAILS


def report(missed=0, mean_error=0.24, delay=0.75, fast=0.5):
    """A campaign's report with the paper's own Tables III and IV."""

    def figures(errors, faulty, wrong, spread):
        return {
            "hit": 80, "missed": missed if faulty else 0, "detectable": 70, "detectable_missed": 0, "wrong": wrong,
            "delay": spread, "fast_delay": {"largest": 1.0, "mean": fast}, "error": list(errors),
        }  # fmt: skip

    free = {"runs": 140, "alpha": figures((2.44, 0.02), False, 0, {"largest": None, "mean": None})}
    free["vc"] = figures((8.22, 0.02), False, 0, {"largest": None, "mean": None})
    faulty = {"runs": 109, "alpha": figures((16.39, mean_error), True, 1, {"largest": 19.16, "mean": delay})}
    faulty["vc"] = figures((8.22, 0.02), True, 0, {"largest": 4.64, "mean": 0.8})
    return {
        "campaign": "table_iv",
        "runs": 249,
        "sheets": [{"sheet": "cmhe_fte", "fault_free": free, "faulty": faulty}],
    }


def test_tables_iii_and_iv_come_from_a_campaigns_report(tmp_path: Path):
    assert [f.verdict for f in paper_004_tables.tables(paper_004_tables.reported(tmp_path))] == [Verdict.NOT_HERE] * 2
    path = tmp_path / "report.json"
    for given, verdicts in (
        (report(), [Verdict.HOLDS, Verdict.HOLDS]),
        (report(missed=20), [Verdict.HOLDS, Verdict.ONLY_IF]),
        (report(mean_error=0.9), [Verdict.ONLY_IF, Verdict.HOLDS]),
        (report(delay=2.0), [Verdict.HOLDS, Verdict.ONLY_IF]),
        (report(delay=2.0, fast=1.0), [Verdict.HOLDS, Verdict.FAILS]),
    ):
        path.write_text(json.dumps(given))
        found = list(paper_004_tables.tables(paper_004_tables.reported(tmp_path)))
        assert [f.verdict for f in found] == verdicts
        assert "campaign `table_iv`, 249 runs" in found[0].text.lower()
    path.write_text('{"sheets": 3}')
    with pytest.raises(DocumentError, match="no report"):
        paper_004_tables.reported(tmp_path)


def test_a_lasting_bias_goes_into_the_wind_unless_it_is_held():
    """At W_x's bound the airspeed's prediction cannot follow: 1, by hand. Without bounds W_x takes in all of it: 0."""
    held, free = (
        paper_004_sensitivity.long_run(VC, sheet, onset=4.0, seconds=8.0) for sheet in ("cmhe_fte", "umhe_fte")
    )
    assert held[0] == free[0] == pytest.approx(1.0, abs=1e-6)
    assert np.all(np.diff(free[:10]) < 0.0) and abs(free[-1]) < 0.01
    assert held[-1] == pytest.approx(1.0, abs=0.01)


def test_at_the_bound_the_vertical_speed_says_what_alpha_is():
    """With W_z held, V_z = -V_g sin(alpha - theta) - W_z measures alpha with the noise sqrt(R_vz)/V_g = 0.134 deg; the
    sensors do with sqrt(R_alpha) = 0.198 deg. Of two that disagree for good the mean weighs V_z with 0.69."""
    alpha = paper_004_sensitivity.long_run(ALPHA, "cmhe_fte", onset=4.0, seconds=9.0)[-1]
    v_z, own = 1.0 / (0.20 / 191.0**2), 1.0 / 1.2e-5
    assert alpha == pytest.approx(v_z / (v_z + own), abs=0.03)


def test_the_shipped_tables_are_the_shipped_campaigns():
    found = titled(paper_004_tables.findings(Path(), short=True))
    assert {name: f.verdict for name, f in found.items()}.items() <= shipped().items()
    assert all("`table_iv`" in f.text for f in found.values())
