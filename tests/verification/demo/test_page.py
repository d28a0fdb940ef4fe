"""The page of the demonstration, and reports of other runs."""

from __future__ import annotations

import re
from collections.abc import Iterator
from html.parser import HTMLParser
from itertools import pairwise
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest

import saoflow
from saoflow.cli import run
from saoflow.report import limits_of, render_report, report_of_run, write_report
from saoflow.report.icicle import slabs
from saoflow.report.panels import spread
from saoflow.report.style import DARK, LIGHT
from saoflow.scheduler.counts import CountTree
from verification.demo import DemoResult
from verification.demo.files import page_of

pytestmark = pytest.mark.xdist_group("demo")

SHEET = """\
sheet: halves
inputs: {x: {shape: [2]}}
blocks:
  y: {mul: [x, 0.5]}
outputs: [y]
"""


@pytest.fixture(scope="module")
def page(result: DemoResult) -> str:
    return render_report(page_of(result, Path("out")))


def drawings(page: str) -> Iterator[ElementTree.Element]:
    for text in re.findall(r"<svg.*?</svg>", page, re.DOTALL):
        yield ElementTree.fromstring(text)


def words(page: str) -> str:
    return " ".join(text for drawing in drawings(page) for text in drawing.itertext())


class Tags(HTMLParser):
    """Which elements are opened and closed, and what they refer to."""

    def __init__(self) -> None:
        super().__init__()
        self.open: list[str] = []
        self.references: list[str] = []
        self.ids: list[str] = []
        self.names: set[str] = set()

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.names.add(tag)
        if tag not in ("meta", "link", "img", "br", "hr"):
            self.open.append(tag)
        for name, value in attrs:
            if name in ("src", "href", "xlink:href"):
                self.references.append(value or "")
            if name == "id":
                self.ids.append(value or "")

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.handle_starttag(tag, attrs)
        self.open.pop()

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag


def test_the_page_stands_alone(page: str) -> None:
    tags = Tags()
    tags.feed(page)
    assert tags.open == []
    assert not tags.names & {"script", "img", "link", "iframe"}
    assert all(reference.startswith("#") for reference in tags.references)
    assert len(tags.ids) == len(set(tags.ids))
    assert {reference[1:] for reference in tags.references} <= set(tags.ids)
    assert set(re.findall(r"url\(#([^)]*)\)", page)) <= set(tags.ids)
    assert "@import" not in page and "@font-face" not in page


def test_the_page_has_every_plot(page: str) -> None:
    headings = re.findall(r"<h2>(.*?)</h2>", page)
    assert headings[:8] == [
        "Calibrated airspeed",
        "Residual of the airspeed sensors",
        "Horizontal wind",
        "Error of the airspeed estimate",
        "Angle of attack",
        "Residual of the angle-of-attack sensors",
        "Vertical wind",
        "Configuration",
    ]
    assert "The budget of a frame" in headings
    assert len(list(drawings(page))) == 10


def test_plots_say_what_was_found(page: str, result: DemoResult) -> None:
    shown = words(page)
    frame = result.isolated_frame(result.cmhe)
    assert frame is not None and f"isolated {result.time[frame]:.1f} s" in shown
    for text in ("threshold 12", "threshold 2.9", "bound 60", "bound 30", "time [s]", "airspeed [kt]", "wind [kt]"):
        assert text in shown
    total = result.cmhe.budget.total
    assert f"{total:,}".replace(",", "\N{NARROW NO-BREAK SPACE}") in shown


def test_colours_follow_the_page(page: str) -> None:
    for drawing in re.findall(r"<svg.*?</svg>", page, re.DOTALL):
        assert re.match(r'<svg [^>]*aria-label="[A-Z]', drawing)
        assert not set(LIGHT.values()) & set(re.findall(r"#[0-9a-f]{6}", drawing))
        used = set(re.findall(r"var\(--(\w+)\)", drawing))
        assert used and used <= set(LIGHT)
        # What matplotlib sets by itself must not show: black is the colour of nothing that is drawn.
        assert set(re.findall(r"(?:stroke|fill): (#[0-9a-f]{6})", drawing)) <= {"#000000"}
    assert set(DARK) == set(LIGHT) and len(set(LIGHT.values())) == len(LIGHT)


@pytest.mark.parametrize("colours", [LIGHT, DARK])
def test_words_can_be_read(colours: dict[str, str]) -> None:
    """Contrast of at least 4.5 for all that is written (WCAG 2, AA)."""

    def luminance(colour: str) -> float:
        parts = [int(colour[i : i + 2], 16) / 255 for i in (1, 3, 5)]
        linear = [p / 12.92 if p <= 0.04045 else ((p + 0.055) / 1.055) ** 2.4 for p in parts]
        return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]

    for role in ("ink", "soft", "estimate", "truth", "limit"):
        high, low = sorted((luminance(colours[role]), luminance(colours["paper"])), reverse=True)
        assert (high + 0.05) / (low + 0.05) >= 4.5, role


def test_limits_are_those_of_the_sheet() -> None:
    limits = limits_of(saoflow.load("cmhe_fte", parameters={"vc_threshold": 15.5, "wx_max": 42}))
    assert (limits.vc_threshold_kt, limits.wx_bound_kt) == (15.5, 42.0)
    assert (limits.alpha_threshold_deg, limits.wz_bound_kt) == (2.9, 30.0)


def test_a_run_of_any_sheet_has_a_report(tmp_path: Path) -> None:
    (tmp_path / "halves.yaml").write_text(SHEET)
    sheet = saoflow.load(str(tmp_path / "halves.yaml"))
    inputs = {"x": np.arange(20.0).reshape(10, 2)}
    report = report_of_run(sheet, inputs, sheet.simulator().run(inputs))
    write_report(tmp_path / "report.html", report)
    text = (tmp_path / "report.html").read_text()
    tags = Tags()
    tags.feed(text)
    assert tags.open == []
    assert len(list(drawings(text))) == 2, "its output and its budget"
    assert [p.name for p in tmp_path.iterdir() if p.name.startswith(".")] == []


def test_a_run_of_the_estimator_alone_has_its_plots(result: DemoResult) -> None:
    report = report_of_run(result.cmhe.sheet, result.recording.inputs(), result.cmhe.outputs, result.time)
    text = render_report(report)
    assert "Residual of the airspeed sensors" in text
    assert "truth" not in words(text)


def test_missing_samples_are_gaps(result: DemoResult) -> None:
    inputs = {name: column.copy() for name, column in result.recording.inputs().items()}
    inputs["vc"][100:120] = np.nan
    inputs["alpha"][:, 2] = np.inf
    render_report(report_of_run(result.cmhe.sheet, inputs, result.cmhe.outputs, result.time))


def test_a_report_that_cannot_be_written_is_diagnosed(result: DemoResult, tmp_path: Path) -> None:
    report = report_of_run(result.cmhe.sheet, {}, result.cmhe.outputs)
    with pytest.raises(saoflow.DiagnosisError) as caught:
        write_report(tmp_path / "no" / "folder.html", report)
    assert caught.value.diagnoses[0].code == "E601"


def test_the_same_report_is_the_same_page(result: DemoResult) -> None:
    report = report_of_run(result.cmhe.sheet, {}, result.cmhe.outputs)
    assert render_report(report) == render_report(report)


def test_text_is_escaped(result: DemoResult) -> None:
    report = report_of_run(result.cmhe.sheet, {}, result.cmhe.outputs)
    object.__setattr__(report, "title", "<b>&")
    assert "<h1>&lt;b&gt;&amp;</h1>" in render_report(report)


def test_slabs_of_the_budget_add_up_and_stand_below_what_they_are_part_of(result: DemoResult) -> None:
    tree = result.cmhe.budget.tree
    shown = slabs(tree)
    for level in range(1, 4):
        for slab in (s for s in shown if s.level == level):
            above = [s for s in shown if s.level == level - 1 and s.start <= slab.start]
            assert any(slab.start + slab.operations <= s.start + s.operations for s in above)
        edges = sorted((s.start, s.start + s.operations) for s in shown if s.level == level)
        assert all(end <= start for (_, end), (start, _) in pairwise(edges))
    assert sum(s.operations for s in shown if s.level == 1) == tree.total
    step3 = tree.parts["step3"]
    assert next(s for s in shown if s.name == "step3").operations == step3.total
    ip = sum(part.total for name, part in step3.parts.items() if name.startswith("ip["))
    assert next(s for s in shown if s.name == "ip[0..3]").operations == ip


def test_slabs_by_hand() -> None:
    tree = CountTree("s")
    for path, count in ((("a", "x[0]"), 30), (("a", "x[1]"), 20), (("a", "y"), 40), (("b",), 9), (("c",), 1)):
        tree.add(path, CountTree("").kinds.__class__({"add": count}))
    found = [(s.name, s.level, s.start, s.operations) for s in slabs(tree, depth=2, least=0.05)]
    assert found == [
        ("s", 0, 0, 100),
        ("a", 1, 0, 90),
        ("x[0..1]", 2, 0, 50),
        ("y", 2, 50, 40),
        ("b", 1, 90, 9),
        ("1 smaller", 1, 99, 1),
    ]


def test_labels_keep_their_distance() -> None:
    placed = spread([10.0, 10.0, 12.0, 60.0], gap=10.5)
    assert all(b - a >= 10.5 - 1e-3 for a, b in pairwise(placed))
    assert placed[3] == pytest.approx(60.0)
    assert spread([0.0, 50.0]) == [0.0, 50.0]


def test_the_page_of_a_budget(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    page = tmp_path / "budget.html"
    assert run(["budget", "cmhe_fte", "--report", str(page)]) == 0
    text = page.read_text()
    free = 19_500 - saoflow.load("cmhe_fte").budget().total
    assert "step3" in text and f"{free:,} free".replace(",", "\N{NARROW NO-BREAK SPACE}") in text and 'class="holds"' in text
    assert run(["budget", "cmhe_fte", "--set", "N=5", "--report", str(page)]) == 1
    assert 'class="fails"' in page.read_text()
    assert run(["budget", "cmhe_fte", "--report", str(tmp_path / "no" / "b.html")]) == 2
    assert "E601" in capsys.readouterr().err
