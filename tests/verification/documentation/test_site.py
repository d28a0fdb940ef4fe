"""The documentation site: built strictly, complete, and asking nobody for anything."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest

from saoflow.blocks.library import SYMBOLS
from saoflow.diagrams.store import LIBRARY, SHIPPED
from verification.documentation.reference import FLAGSHIP, library_page, symbols_page

ROOT = Path(__file__).parents[3]


def test_every_symbol_has_its_glyph_equation_and_examples() -> None:
    page = symbols_page()
    for name, symbol in SYMBOLS.items():
        part = page[page.index(f"\n## {name}\n") :].partition("\n## ")[2].partition("\n## ")[0]
        assert "<svg" in part and symbol.equation in part
        for example in symbol.examples:
            assert example.replace("|", "\\|") in part


def test_every_library_sheet_is_there() -> None:
    page = library_page()
    for path in LIBRARY.glob("*.yaml"):
        assert f"\n## {path.stem}\n" in page


def reached(sheet: str, among: set[str]) -> set[str]:
    """The sheets of a folder that a sheet uses, directly or through others, by their texts."""
    found, waiting = set(), [sheet]
    while waiting:
        name = waiting.pop()
        found.add(name)
        text = (SHIPPED / "cmhe_fte" / f"{name}.yaml").read_text()
        used = set(re.findall(r"\{ *(?:map: *|fold: *)?(\w+)|^ {4}(?:fold: *|map: *)?(\w+)", text, re.M))
        waiting += ({a or b for a, b in used} & among) - found - set(waiting)
    return found


@pytest.mark.xdist_group("site")
def test_the_site_is_built_and_asks_nobody(tmp_path: Path) -> None:
    pytest.importorskip("zensical", reason="the site generator of saoflow[docs] is not installed")
    pytest.importorskip("py_mini_racer", reason="the JavaScript engine of saoflow[svg] is not installed")
    command = [sys.executable, "-m", "verification.documentation", "-o", str(tmp_path)]
    done = subprocess.run(command, capture_output=True, text=True, cwd=ROOT, check=False)
    assert done.returncode == 0, done.stderr
    site = tmp_path / "site"
    pages = {path.stem for path in site.glob("*.html")}
    assert {"index", "tutorial", "symbols", "library", "flagship", "multirate", "diagnoses", "editors", "view"} <= pages
    for path in site.rglob("*.html"):
        text = path.read_text(encoding="utf-8")
        asked = re.findall(r'<(?:script|link|img|iframe)[^>]+(?:src|href)="(https?://[^"]+)"', text)
        assert [url for url in asked if "canonical" not in url] == [], path.name
    explained = set(re.findall(r'<h2 id="(\w+)"', (site / "flagship.html").read_text()))
    own = {path.stem for path in (SHIPPED / "cmhe_fte").glob("*.yaml")}
    assert reached("cmhe_fte", own) == explained
    for name in FLAGSHIP:
        assert (site / "flagship" / f"{name}.svg").stat().st_size > 2000
