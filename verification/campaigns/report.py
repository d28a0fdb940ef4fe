"""What a campaign leaves beside its results: the tables as Markdown and as JSON."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path

from saoflow.diagnosis import DiagnosisError, refusal
from saoflow.whole_file import write_whole
from verification.campaigns.metrics import SheetMetrics, to_dict
from verification.campaigns.plan import Campaign
from verification.campaigns.tables import markdown


def write_report(campaign: Campaign, metrics: Sequence[SheetMetrics], folder: Path) -> tuple[Path, ...]:
    """Writes report.md and report.json into the folder. Raises DiagnosisError E601."""
    files = {"report.md": markdown(campaign, metrics), "report.json": json_of(campaign, metrics)}
    for name, text in files.items():
        try:
            write_whole(folder / name, text.encode())
        except OSError as error:
            raise _unwritable(folder / name, error) from None
    return tuple(folder / name for name in files)


def json_of(campaign: Campaign, metrics: Sequence[SheetMetrics]) -> str:
    """The metrics as JSON text."""
    facts = {"campaign": campaign.name, "runs": campaign.total, "sheets": [to_dict(sheet) for sheet in metrics]}
    return json.dumps(facts, indent=1, allow_nan=False) + "\n"


def _unwritable(path: Path, error: OSError) -> DiagnosisError:
    cause = error.strerror or str(error)
    return refusal("E601", f"{path} cannot be written", cause=cause, remedy="make room, or see who may write there")
