"""A page of tables and pictures: HTML with everything inside, in the colours of saoflow's reports."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from saoflow.report.style import css_colours
from verification.campaigns.tables import Table

TEMPLATE = Path(__file__).with_name("page.html")


def page(title: str, lead: str, figures: Sequence[str], tables: Sequence[Table]) -> str:
    """The text of the page; ``figures`` are ``<svg>`` elements."""
    from jinja2 import Environment

    template = Environment(autoescape=True, trim_blocks=True, lstrip_blocks=True).from_string(
        TEMPLATE.read_text(encoding="utf-8")
    )

    return template.render(title=title, lead=lead, figures=figures, tables=tables, colours=css_colours())
