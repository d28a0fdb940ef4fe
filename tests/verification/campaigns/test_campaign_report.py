"""The report of a campaign: tables from metrics worked out by hand, page, picture and data that agree."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

from small_campaign import SMALL
from test_campaign_metrics import FAULTY, QUIET

from verification.campaigns.cases import Chunk
from verification.campaigns.metrics import metrics_of
from verification.campaigns.report import json_of, write_report
from verification.campaigns.run import run_campaign
from verification.campaigns.store import Store, rows_of
from verification.campaigns.tables import markdown, tables_of

ROWS = [replace(row, run=i) for i, row in enumerate([*QUIET, *FAULTY])]


def test_tables_hold_the_numbers_of_the_metrics() -> None:
    (metrics,) = metrics_of(ROWS)
    tables = {table.title.split(":")[0]: table for table in tables_of(metrics)}
    assert tables["Table III"].rows[0] == ("fault-free (3)", "2.00", "4.00", "0.167", "0.400")
    assert tables["Table III"].rows[1] == ("fault-free, paper", "2.44", "8.22", "0.02", "0.02")
    assert tables["Table III"].rows[2] == ("faulty (6)", "9.00", "4.00", "0.100", "0.400")
    assert tables["Table IV"].rows[0] == ("AOA", "0", "50.00", "33.33", "1.50", "1.00")
    assert tables["Table IV"].rows[2] == ("VCAS", "33.33", "16.67", "0", "3.00", "3.00")
    assert tables["What must be found, and what was"].rows[1] == (
        "faults that must be found, missed",
        "2 of 4",
        "1 of 2",
    )
    assert tables["Winds beyond the assumed bounds, counted apart"].rows == (
        ("fault-free, wind beyond the bounds (1)", "1 of 1", "1 of 1", "-", "-"),
    )
    assert tables["Runs that failed (the first of them)"].rows == (("10", "it would not fly"),)
    for table in tables.values():
        assert all(len(row) == len(table.heads) for row in table.rows), table.title


def test_rows_survive_their_file(tmp_path: Path) -> None:
    with Store(tmp_path, "hand", {}) as store:
        chunks = [Chunk(0, 0, 4), Chunk(1, 4, 11)]
        for chunk in reversed(chunks):
            store.keep(chunk, ROWS[chunk.first : chunk.stop])
        results = store.finish(chunks)
    again = list(rows_of(results))
    assert repr(again) == repr(ROWS)  # NaN equal to NaN
    assert repr(metrics_of(again)) == repr(metrics_of(ROWS))


def test_page_picture_and_data_agree(tmp_path: Path) -> None:
    results = run_campaign(SMALL, tmp_path, workers=1).results
    metrics, files = write_report(SMALL, results)
    assert [path.name for path in files] == ["report.md", "report.json", "report.html", "report.png"]
    page = (tmp_path / "report.html").read_text(encoding="utf-8")
    text = (tmp_path / "report.md").read_text(encoding="utf-8")
    assert text == markdown(SMALL, metrics)
    for table in tables_of(metrics[0]):
        for row in table.rows:
            assert f"| {' | '.join(row)} |" in text
            assert all(f"<td>{cell}</td>" in page for cell in row)
    data = json.loads(json_of(SMALL, metrics))  # strict: no NaN
    assert data["sheets"][0]["faulty"]["runs"] == metrics[0].faulty.runs
    before = {path: path.read_bytes() for path in files}
    write_report(SMALL, results)
    assert {path: path.read_bytes() for path in files} == before


def test_fault_free_runs_have_no_picture(tmp_path: Path) -> None:
    quiet = replace(SMALL, runs=SMALL.runs[:1])
    _, files = write_report(quiet, run_campaign(quiet, tmp_path, workers=1).results)
    assert [path.name for path in files] == ["report.md", "report.json", "report.html"]
    assert "<svg" not in (tmp_path / "report.html").read_text(encoding="utf-8")
