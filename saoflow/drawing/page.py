"""The page of ``saoflow view``: one file, nothing fetched from anywhere, the drawings and (if asked) a run inside."""

from __future__ import annotations

import base64
import gzip
import json
import os
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from saoflow.blocks.library import SYMBOLS
from saoflow.drawing.described import described
from saoflow.drawing.draw import draw
from saoflow.drawing.javascript import print_javascript
from saoflow.drawing.style import FOLDER, css_colours
from saoflow.scheduler.counts import CountTree
from saoflow.scheduler.lowering import lower
from saoflow.whole_file import write_text

if TYPE_CHECKING:
    from saoflow.pipeline import LoadedSheet

SCRIPTS = ("layout.js", "render.js", "player.js", "layouter.js")


@dataclass(frozen=True, slots=True, eq=False)
class RunShown:
    """A run for the page to play: inputs, one row a frame."""

    inputs: Mapping[str, NDArray[np.float64]]
    """By port: (frames, *shape)."""
    frames: int
    period: float | None


def render_view(sheet: LoadedSheet, run: RunShown | None = None) -> str:
    """The whole page as text. Raises DiagnosisError with what the sheet has."""
    import jinja2

    loader = jinja2.FileSystemLoader(FOLDER)
    # Everything that is put in is our own text, or packed into base64: nothing of a sheet reaches the page as HTML.
    environment = jinja2.Environment(loader=loader, autoescape=False, trim_blocks=True, lstrip_blocks=True)
    data, frame = view_data(sheet, run)
    inputs = ""
    if run is not None:
        inputs = _packed(_rows(sheet, run).tobytes())
    return environment.get_template("view.html").render(
        title="saoflow view",
        colours=css_colours(),
        css=_asset("view.css"),
        data=_packed(json.dumps(data, allow_nan=False, separators=(",", ":")).encode()),
        elk=base64.b64encode((FOLDER / "elk" / "elk.bundled.js.gz").read_bytes()).decode(),
        inputs=inputs,
        scripts="\n".join(_asset(name) for name in SCRIPTS),
        frame=frame,
        app=_asset("app.js"),
    )


def write_view(path: str | os.PathLike[str], sheet: LoadedSheet, run: RunShown | None = None) -> None:
    """Write the page, all of it or nothing. Raises DiagnosisError E601 if the file cannot be written."""
    write_text(path, render_view(sheet, run), "the page")


def view_data(sheet: LoadedSheet, run: RunShown | None) -> tuple[dict[str, Any], str]:
    """What the page's script reads, and the frame program as JavaScript (empty without a run)."""
    drawings = draw(sheet.schedule, sheet.netlist, sheet.store)
    budget = sheet.budget()
    limit = next((line.limit for line in budget.lines if line.kind == "operations" and line.limit is not None), None)
    data: dict[str, Any] = {
        "title": sheet.name,
        **described(drawings, sheet),
        "costs": _costs(budget.tree),
        "limit": limit,
        "symbols": {name: [symbol.summary, symbol.equation] for name, symbol in SYMBOLS.items()},
        "run": None,
    }
    if run is None:
        return data, ""
    program = print_javascript(lower(sheet.schedule, traced=True))
    data["run"] = {
        "frames": run.frames,
        "width": sum(wire.size for wire in sheet.input_types.values()),
        "period": run.period,
        "initial": program.initial,
        "size": program.size,
        "bodies": program.bodies,
    }
    return data, program.text


def _rows(sheet: LoadedSheet, run: RunShown) -> NDArray[np.float64]:
    """The inputs as the frame takes them: element by element in the order of the ports."""
    columns = [
        np.asarray(run.inputs[name], dtype=np.float64).reshape(run.frames, wire.size)
        for name, wire in sheet.input_types.items()
    ]
    return np.ascontiguousarray(np.concatenate(columns, axis=1)) if columns else np.zeros((run.frames, 0))


def _costs(tree: CountTree) -> dict[str, Any]:
    """The operations of every instance and block, for the page."""
    parts = {name: _costs(part) for name, part in tree.parts.items()}
    return {"total": tree.total, "kinds": {k: n for k, n in tree.kinds.items() if n}, "parts": parts}


def _asset(name: str) -> str:
    return (FOLDER / name).read_text(encoding="utf-8")


def _packed(data: bytes) -> str:
    return base64.b64encode(gzip.compress(data, 6, mtime=0)).decode()
