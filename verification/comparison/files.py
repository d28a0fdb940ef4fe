"""Writing a comparison: a page, its picture, or its table."""

from __future__ import annotations

import os
from pathlib import Path

from saoflow.diagnosis import did_you_mean, refusal
from saoflow.report.style import style, svg
from saoflow.whole_file import write_whole
from verification.campaigns.page import page
from verification.campaigns.tables import markdown_table
from verification.comparison.compare import Comparison
from verification.comparison.picture import picture
from verification.comparison.tables import table_of
from verification.papers.style import save

KINDS = (".html", ".png", ".md")


def check_output(output: str) -> Path:
    """Raises DiagnosisError E601 for a file that could not be written: before the work, not after it."""
    path = Path(output)
    if path.suffix not in KINDS:
        near = did_you_mean(path.suffix, KINDS)
        remedy = near or "end its name in .html (a page), .png (the picture alone) or .md (the table alone)"
        raise refusal(
            "E601", f"{output} cannot be written", cause=f"its name ends in none of {', '.join(KINDS)}", remedy=remedy
        )
    folder = path.resolve().parent
    cause = "it is a folder" if path.is_dir() else ""
    if not folder.is_dir():
        cause = f"there is no folder {folder}"
    elif not os.access(folder, os.W_OK):
        cause = f"you may not write into {folder}"
    if cause:
        raise refusal("E601", f"{output} cannot be written", cause=cause, remedy="name another file")
    return path


def write(comparison: Comparison, path: Path) -> None:
    """Write the page, the picture or the table, all of it or nothing. Raises DiagnosisError E601."""
    table = table_of(comparison)
    try:
        if path.suffix == ".md":
            text = "\n".join(["# Sheets compared", "", *markdown_table(table), "", table.note, ""])
            write_whole(path, text.encode())
            return
        with style("comparison"), picture(comparison) as drawn:
            if path.suffix == ".png":
                save(drawn, path)
                return
            shown = svg(drawn, "comparison", "accuracy and detection against operations and time a frame")
        lead = (
            "Each point is a sheet or a variant of one; the line joins those that no other beats in both. Hollow: over the "
            "budget."
        )
        write_whole(path, page("Sheets compared", lead, [shown], [table]).encode())
    except OSError as error:
        raise refusal(
            "E601", f"{path} cannot be written", cause=str(error.strerror or error), remedy="name another file"
        ) from None
