"""Loading the sheets of a campaign."""

from __future__ import annotations

from dataclasses import replace

import saoflow
from saoflow.pipeline import LoadedSheet
from verification.campaigns.plan import Variant


def load_variant(variant: Variant) -> LoadedSheet:
    """The sheet with its parameters. Raises DiagnosisError as loading does.

    One that is ``unlimited`` has no budget: a comparison shows what lies beyond it. It has a further line, too, so that
    what is compiled of it is not taken for the sheet that would be refused.
    """
    loaded = saoflow.load(variant.sheet, dict(variant.settings))
    if variant.unlimited:
        sheet = loaded.sheet
        loaded.sheet = replace(sheet, budget=None, lines=(*sheet.lines, "# compared without its budget"))
    return loaded
