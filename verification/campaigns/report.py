"""What a campaign leaves beside its results: the tables as Markdown, as JSON, and as a page with a picture."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from saoflow.diagnosis import DiagnosisError, refusal
from saoflow.report.style import style, svg
from saoflow.whole_file import write_whole
from verification.campaigns.metrics import SheetMetrics, metrics_of, to_dict
from verification.campaigns.page import page
from verification.campaigns.picture import Seen, is_empty, picture, seen_in
from verification.campaigns.plan import Campaign
from verification.campaigns.store import rows_of
from verification.campaigns.tables import markdown, tables_of
from verification.papers.style import save


def write_report(campaign: Campaign, results: Path) -> tuple[tuple[SheetMetrics, ...], tuple[Path, ...]]:
    """Writes report.md, report.json, report.html and report.png beside the results; the metrics and the files come
    back.

    Without a run with a fault there is no picture. Raises DiagnosisError E501, E601.
    """
    metrics, seen = metrics_of(rows_of(results)), seen_in(rows_of(results))
    folder = results.parent
    files = [folder / name for name in ("report.md", "report.json", "report.html", "report.png")]
    texts = (markdown(campaign, metrics), json_of(campaign, metrics))
    try:
        for path, text in zip(files, texts, strict=False):
            write_whole(path, text.encode())
        figures = _draw(metrics, seen, files[3])
        write_whole(files[2], _page(campaign, metrics, figures).encode())
    except OSError as error:
        raise _unwritable(folder, error) from None
    return metrics, tuple(files if figures else files[:3])


def json_of(campaign: Campaign, metrics: Sequence[SheetMetrics]) -> str:
    """The metrics as JSON text."""
    facts = {"campaign": campaign.name, "runs": campaign.total, "sheets": [to_dict(sheet) for sheet in metrics]}
    return json.dumps(facts, indent=1, allow_nan=False) + "\n"


def _draw(metrics: Sequence[SheetMetrics], seen: dict[str, Seen], path: Path) -> list[str]:
    """As PNG into the file, and as SVG."""
    if is_empty(seen):
        return []
    with style("campaign"), picture(metrics, seen) as drawn:
        save(drawn, path)
        return [svg(drawn, "campaign", "delays, detection by size and by kind of fault")]


def _page(campaign: Campaign, metrics: Sequence[SheetMetrics], figures: Sequence[str]) -> str:
    several = len(metrics) > 1
    tables = [
        replace(table, title=f"{sheet.sheet}: {table.title}" if several else table.title)
        for sheet in metrics
        for table in tables_of(sheet)
    ]
    return page(f"Campaign {campaign.name}", campaign.doc, figures, tables)


def _unwritable(folder: Path, error: OSError) -> DiagnosisError:
    cause = error.strerror or str(error)
    return refusal(
        "E601", f"{folder}: the report cannot be written", cause=cause, remedy="make room, or see who may write there"
    )
