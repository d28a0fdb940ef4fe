"""Comparisons: the entries against the campaign they come from, what no other beats, budgets, files, the command."""

from __future__ import annotations

import json
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import pytest

import saoflow
from saoflow import DiagnosisError
from verification.campaigns.metrics import metrics_of
from verification.campaigns.plan import Campaign, FaultMix, Range, RecordedFlights, RunSet, Variant
from verification.campaigns.run import run_campaign
from verification.campaigns.store import rows_of
from verification.comparison.compare import Comparison, Entry, compare, pareto
from verification.comparison.files import check_output, write
from verification.comparison.tables import table_of
from verification.comparison.variants import parse_variants

FLIGHTS = RecordedFlights("shipped", ("a320_wind_350kt_5000ft",), 12.0)
PLAN = Campaign(
    "tiny",
    "",
    1,
    (Variant("cmhe_fte"),),
    (FLIGHTS,),
    (
        RunSet("quiet", "shipped", 4, None),
        RunSet("hit", "shipped", 12, FaultMix((47, 22, 25, 15), (), onset=Range(3.0, 5.0))),
    ),
)


@pytest.fixture(scope="module")
def found() -> Comparison:
    budget = float(saoflow.load("umhe_fte").budget().total)
    return compare(parse_variants(["umhe_fte[n_eval=5|10]", "cmhe_fte_lean"]), PLAN, budget=budget, workers=1)


def test_entries_are_the_metrics_of_the_campaign(found: Comparison, tmp_path: Path) -> None:
    plan = replace(PLAN, sheets=(Variant("umhe_fte"), Variant("cmhe_fte_lean")))
    umhe, lean = metrics_of(rows_of(run_campaign(plan, tmp_path / "out", workers=1).results))
    assert (found.fault_free, found.faulty, found.campaign) == (4, 12, "tiny")
    assert [entry.label for entry in found.entries] == ["umhe_fte[n_eval=5]", "umhe_fte[n_eval=10]", "cmhe_fte_lean"]
    # n_eval is 10 in the sheet
    for entry, metrics in zip(found.entries[1:], (umhe, lean), strict=True):
        assert entry.alpha_error == metrics.fault_free.alpha.error[1]
        assert entry.vc_error_faulty == metrics.faulty.vc.error[1]
        hit = metrics.faulty.alpha.hit + metrics.faulty.vc.hit
        missed = metrics.faulty.alpha.missed + metrics.faulty.vc.missed
        assert entry.found == pytest.approx(100.0 * (1.0 - missed / hit))
    assert found.entries[0].found != found.entries[1].found or found.entries[0].delay != found.entries[1].delay


def test_operations_are_those_of_the_budget(found: Comparison) -> None:
    assert found.entries[1].operations == saoflow.load("umhe_fte").budget().total
    assert found.entries[0].operations == saoflow.load("umhe_fte", {"n_eval": 5}).budget().total
    assert [entry.fits for entry in found.entries] == [True, True, False]
    assert found.entries[2].microseconds > found.entries[1].microseconds > 0.0


def test_a_variant_over_its_own_budget_is_compared_and_marked() -> None:
    quick = replace(PLAN, runs=(RunSet("quiet", "shipped", 2, None),), flights=(replace(FLIGHTS, part=5.0),))
    result = compare(parse_variants(["umhe_fte[N=3|5]"]), quick, workers=1)
    assert [entry.fits for entry in result.entries] == [True, False]
    assert result.entries[1].operations > 2500 and result.entries[1].failed == 0
    # and stays refused everywhere else, though its code has been compiled
    with pytest.raises(DiagnosisError, match="E401"):
        saoflow.load("umhe_fte", {"N": 5}).simulator(backend="c")
    with pytest.raises(DiagnosisError, match="E401"):
        run_campaign(replace(quick, sheets=(Variant("umhe_fte", (("N", "5"),)),)), "never", workers=1)


def entry(operations: int, error: float, share: float = 0.0) -> Entry:
    return Entry(f"{operations}", operations, 1.0, None, 0.0, 0.0, error, 0.0, share, 0, 0.0, 0, 0, 0)


def test_what_no_other_beats() -> None:
    entries = [entry(30, 1.0), entry(10, 3.0), entry(20, 2.0), entry(25, 2.5), entry(20, 2.5), entry(40, 1.0)]
    assert [e.operations for e in pareto(entries, "operations", "alpha_error_faulty")] == [10, 20, 30]
    # two alike are both best; what differs in the fourth digit is alike; NaN is no value
    entries = [entry(10, 2.0), entry(10, 2.0), entry(20, 1.9996), entry(5, float("nan"))]
    assert [e.operations for e in pareto(entries, "operations", "alpha_error_faulty")] == [10, 10]
    entries = [entry(10, 0.0, 60.0), entry(20, 0.0, 70.0), entry(30, 0.0, 65.0)]
    assert [e.operations for e in pareto(entries, "operations", "found", True)] == [10, 20]


def test_files(found: Comparison, tmp_path: Path) -> None:
    for name in ("page.html", "picture.png", "table.md"):
        write(found, check_output(str(tmp_path / name)))
    page = (tmp_path / "page.html").read_text(encoding="utf-8")
    assert "<svg" in page and "umhe_fte[n_eval=5]" in page and "http-equiv" not in page
    for row in table_of(found).rows:
        for cell in row:
            assert f"<td>{cell}</td>" in page
        assert f"| {' | '.join(row)} |" in (tmp_path / "table.md").read_text(encoding="utf-8")
    assert (tmp_path / "picture.png").read_bytes().startswith(b"\x89PNG")
    assert sorted(p.name for p in tmp_path.iterdir()) == ["page.html", "picture.png", "table.md"]


@pytest.mark.parametrize("name", ["table.pdf", "there/is/no/folder.html", "."])
def test_a_file_that_cannot_be_written(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    with pytest.raises(DiagnosisError, match="E601"):
        check_output(name)


def test_the_command(tmp_path: Path) -> None:
    (tmp_path / "tiny.yaml").write_text(
        """\
campaign: tiny
sheets: [umhe_fte]
flights:
  shipped: {recorded: a320_wind_350kt_5000ft, part: 10}
runs:
  quiet: {flights: shipped, count: 2}
  hit: {flights: shipped, count: 4, sensors: vc_1, kinds: bias, onset: 4}
"""
    )
    command = [sys.executable, "-m", "saoflow.cli", "compare"]
    done = subprocess.run(
        [*command, "umhe_fte[n_eval=5|10]", "--campaign", "tiny.yaml", "--json", "-o", "out.html", "--workers", "1"],
        cwd=tmp_path, capture_output=True, text=True,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    facts = json.loads(done.stdout)
    assert [e["label"] for e in facts["entries"]] == ["umhe_fte[n_eval=5]", "umhe_fte[n_eval=10]"]
    assert facts["faulty"] == 4 and (tmp_path / "out.html").is_file()
    done = subprocess.run(
        [*command, "umhe_fte[n_eval=5", "--campaign", "tyni.yaml", "-o", "out.pdf", "--budget", "0"],
        cwd=tmp_path, capture_output=True, text=True,
    )  # fmt: skip
    assert done.returncode == 2 and done.stdout == ""
    for code in ("E807", "E101", "E601", "E603"):
        assert f"error[{code}]" in done.stderr
    assert "Traceback" not in done.stderr
