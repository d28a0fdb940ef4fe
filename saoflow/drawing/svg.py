"""One drawing as SVG, for documents: the page's own layout and rendering, run in an embedded JavaScript engine."""

from __future__ import annotations

import gzip
import json
from html import escape
from typing import TYPE_CHECKING, Any

from saoflow.diagnosis import Diagnosis, DiagnosisError, did_you_mean
from saoflow.drawing.page import view_data
from saoflow.drawing.style import FOLDER, picture_css
from saoflow.report.style import LIGHT

if TYPE_CHECKING:
    from saoflow.pipeline import LoadedSheet

ENGINE = """
var globalThis = this, window = this, self = this, console = {log() {}, warn() {}, error() {}};
var setTimeout = (f) => (f(), 0), clearTimeout = () => 0;
"""

DRAW = """
var answer = null;
(function () {
  const {drawing, types} = given;
  new ELK().layout(SAO.graph(drawing, types, false)).then(
    (layout) => { answer = JSON.stringify([layout.width, layout.height, SAO.MARKER + SAO.render(drawing, layout, types)]); },
    (error) => { answer = JSON.stringify([String(error)]); });
})();
"""


def render_svg(sheet: LoadedSheet, inside: str = "") -> str:
    """The drawing of a sheet, or of the instance at the path ``inside`` (``step3.ip[2].stages[1]``; a stack by its name).

    Raises DiagnosisError E605 without the extra ``saoflow[svg]``, E303 for a path that is none.
    """
    return Drafter(sheet).draw(inside)


class Drafter:
    """Draws several parts of one sheet with one engine."""

    def __init__(self, sheet: LoadedSheet) -> None:
        """Raises DiagnosisError E605 without the extra ``saoflow[svg]``."""
        self.sheet = sheet
        self.data, _ = view_data(sheet, None)
        self._engine: Any = None

    def draw(self, inside: str = "") -> str:
        """One drawing as SVG. Raises DiagnosisError E303 for a path that is none."""
        data = self.data
        drawing = data["drawings"][find_drawing(data, inside)]
        types = [None if number is None else data["types"][number] for number in data["wires"][drawing["body"]]]
        if self._engine is None:
            self._engine = _engine()
        width, height, body = _drawn(self._engine, drawing, types)
        title = escape(f"{self.sheet.name} {inside}".strip())
        return (
            f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width:.0f} {height:.0f}" width="{width:.0f}" '
            f'height="{height:.0f}" role="img" aria-label="{title}"><title>{title}</title>'
            f"<style>{escape(picture_css(), quote=False)}</style>"
            f'<rect width="100%" height="100%" fill="{LIGHT["paper"]}"/>{body}</svg>\n'
        )


def find_drawing(data: dict[str, Any], path: str) -> int:
    """The number of the drawing at a path. Raises DiagnosisError E303."""
    number = 0
    for part in path.split(".") if path else []:
        blocks = {b["n"]: b["in"] for b in data["drawings"][number]["blocks"] if b["in"] is not None}
        stack = blocks.get(part.partition("[")[0]) if part not in blocks else None
        if stack is not None:
            blocks = {b["n"]: b["in"] for b in data["drawings"][stack]["blocks"] if b["in"] is not None}
        if part not in blocks:
            raise DiagnosisError(
                [
                    Diagnosis(
                        "E303",
                        f"there is no sheet at `{path}`",
                        cause=f"`{part}` is no sub-sheet of `{data['drawings'][number]['sheet']}`",
                        remedy=did_you_mean(part, blocks) or f"those are: {', '.join(sorted(blocks)) or 'none'}",
                    )
                ]
            )
        number = blocks[part]
    return number


def _engine() -> Any:
    """A JavaScript engine that can lay out and draw. Raises DiagnosisError E605."""
    try:
        from py_mini_racer import MiniRacer
    except ImportError:
        raise DiagnosisError(
            [
                Diagnosis(
                    "E605",
                    "drawing SVG without a browser needs mini-racer",
                    cause="it is not installed",
                    remedy="pip install 'saoflow[svg]', or write the page and save the picture from there",
                )
            ]
        ) from None
    engine = MiniRacer()
    engine.eval(ENGINE)
    engine.eval(gzip.decompress((FOLDER / "elk" / "elk.bundled.js.gz").read_bytes()).decode())
    for name in ("layout.js", "render.js"):
        engine.eval((FOLDER / name).read_text(encoding="utf-8"))
    return engine


def _drawn(engine: Any, drawing: dict[str, Any], types: list[Any]) -> tuple[float, float, str]:
    """Width, height and content of a drawing."""
    engine.eval(f"var given = {json.dumps({'drawing': drawing, 'types': types}, allow_nan=False)};")
    engine.eval(DRAW)
    answer = json.loads(str(engine.eval("answer")))
    assert len(answer) == 3, answer
    return float(answer[0]), float(answer[1]), str(answer[2])
