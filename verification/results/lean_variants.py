"""The way from `cmhe_fte` to `cmhe_fte_lean`, one change at a time: each variant is a set of sheets that runs.

A variant is a shipped folder of sheets in which some are replaced (``lean_variants/NAME/*.yaml``). All take the same step.
"""

from __future__ import annotations

import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import saoflow

REPLACED = Path(__file__).parent / "lean_variants"
"""One folder of sheets for each change."""

SHIPPED = Path(saoflow.__file__).parent / "diagrams"


@dataclass(frozen=True)
class Variant:
    """One row of the table."""

    title: str
    sheet: str
    """The shipped sheet it starts from, in the folder of the same name."""
    changes: tuple[str, ...] = ()
    """Folders of sheets that replace or join those of ``sheet``, the later ones over the earlier."""


_SCALAR = ("without_square_roots", "scalar_updates")
_JOINED = (*_SCALAR, "merged_rows")
_POINTS = (*_JOINED, "points")

VARIANTS = (
    Variant("`cmhe_fte`: the paper's form", "cmhe_fte"),
    Variant("without square roots: C_bar = [C; I]", "cmhe_fte", ("without_square_roots",)),
    Variant("eight scalar updates in sequence instead of the 8x8 inverse", "cmhe_fte", _SCALAR),
    Variant("rows of V_g and alpha joined with their barriers: six updates", "cmhe_fte", _JOINED),
    Variant("unknowns are the points to step to: no residual is formed anew in a pass", "cmhe_fte", _POINTS),
    Variant("step length from one table, without changes of sign", "cmhe_fte", (*_POINTS, "one_table")),
    Variant(
        "information from both ends of the window, V_g apart, instead of covariances from one end",
        "cmhe_fte_lean",
        ("model_apart", "whole_last_pass"),
    ),
    Variant("the last pass updates only what the next frame needs", "cmhe_fte_lean", ("model_apart",)),
    Variant("`cmhe_fte_lean`: sines, atmosphere and tables of the model shared", "cmhe_fte_lean"),
)
"""In the order of the table; each one has what the changes of those above do."""


@contextmanager
def loaded(variant: Variant) -> Iterator[saoflow.LoadedSheet]:
    """The variant's sheet, composed in a folder that is gone afterwards."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for source in (SHIPPED / variant.sheet, *(REPLACED / change for change in variant.changes)):
            shutil.copytree(source, folder, dirs_exist_ok=True)
        yield saoflow.load(str(folder / f"{variant.sheet}.yaml"))
