"""The page of `saoflow view` in a real Chromium: walked, searched, pinned, scrubbed, without an error."""

from __future__ import annotations

import base64
import gzip
import json
import re
import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import saoflow
from saoflow.cli import run
from saoflow.drawing.page import RunShown, write_view

sync_api = pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
CHROMIUM = next((found for name in ("chromium", "chromium-browser", "google-chrome") if (found := shutil.which(name))), None)
needs_chromium = pytest.mark.skipif(CHROMIUM is None, reason="there is no chromium")

PROBE = "step3.ip[2].stages[1].measured.K"
FAULT_FRAME = 84


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    with sync_api.sync_playwright() as play:
        opened = play.chromium.launch(executable_path=CHROMIUM, args=["--no-sandbox"])
        yield opened
        opened.close()


def open_page(browser: Any, path: Path, width: int = 1400) -> tuple[Any, list[str]]:
    page = browser.new_page(viewport={"width": width, "height": 900})
    troubles: list[str] = []
    page.on("console", lambda message: troubles.append(message.text) if message.type in ("error", "warning") else None)
    page.on("pageerror", lambda error: troubles.append(str(error)))
    # A blob is a piece of the page itself: the worker that lays out.
    page.on("request", lambda request: troubles.append(request.url) if not request.url.startswith(("file:", "blob:")) else None)
    page.goto(path.as_uri())
    page.wait_for_function("() => !!globalThis.saoView", timeout=60_000)
    return page, troubles


@pytest.fixture(scope="module")
def flagship(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, np.ndarray]:
    """The page with a flight in which three airspeed sensors run away, and the gain K of a Riccati stage in every frame."""
    from verification.flights import Fault, load_recording, sensors

    truth = load_recording("a320_calm_350kt_5000ft").part(0.0, 9.6)
    fault = Fault("runaway", "vc", which=(1, 2, 3), rate=-40.0, onset=FAULT_FRAME * 0.048)
    inputs = sensors(truth, 1, faults=[fault]).inputs()
    sheet = saoflow.load("cmhe_fte")
    path = tmp_path_factory.mktemp("page") / "flagship.html"
    write_view(path, sheet, RunShown(inputs, len(truth), 0.048))
    return path, sheet.simulator(probes=[PROBE]).run(inputs)[PROBE]


@needs_chromium
def test_walk_to_the_riccati_stage_pin_a_wire_and_scrub_to_the_fault(
    browser: Any, flagship: tuple[Path, np.ndarray]
) -> None:
    path, expected = flagship
    assert path.stat().st_size < 3_000_000
    page, troubles = open_page(browser, path)
    # By hand: step3, its stack of passes, the third, its stack of stages, the second, its measurement update.
    for name in ("step3", "ip", "ip[2]", "stages", "stages[1]", "measured"):
        page.evaluate("n => { const b = saoView.here().drawing.blocks.findIndex((b) => b.n === n); document.querySelector(`[data-block='${b}']`).dispatchEvent(new MouseEvent('dblclick', {bubbles: true})); }", name)
        page.wait_for_function("n => saoView.here().name === n && document.querySelector('#busy').hidden", arg=name)
    assert page.evaluate("location.hash") in ("#step3.ip[2].stages[1].measured", "#step3.ip%5B2%5D.stages%5B1%5D.measured")
    assert page.inner_text("#crumbs").replace("\n", " ").split() == (
        ["cmhe_fte", "›", "step3", "›", "ip", "▤", "›", "ip[2]", "›", "stages", "▤", "›", "stages[1]", "›", "measured"]
    )
    page.locator("[data-block]").filter(has_text=re.compile("^.*K.*$")).first.wait_for()
    number = page.evaluate("saoView.here().drawing.blocks.findIndex((b) => b.n === 'K')")
    page.locator(f"[data-block='{number}']").click()
    page.keyboard.press("p")
    assert "measured.K" in page.inner_text("#pins")
    page.locator("#time").fill(str(FAULT_FRAME + 40))
    assert page.evaluate("saoView.player().at") == FAULT_FRAME + 40
    values = "(k) => { saoView.seek(k); const h = saoView.here(), b = h.drawing.blocks.find((b) => b.n === 'K'), p = saoView.player(); return p.values(p.places(h.where, b.o[0].w, 32)); }"
    for frame in (0, 199, FAULT_FRAME + 40, 3):
        assert page.evaluate(values, frame) == expected[frame].ravel().tolist()  # back and forth, to the last bit
    page.evaluate("saoView.go('')")
    page.evaluate("saoView.seek(199)")
    page.wait_for_function("() => saoView.here().path === ''")
    lit = page.evaluate("[...document.querySelectorAll('.terminal.lit')].map((g) => g.textContent)")
    assert lit == ["vc_faulty"]
    page.evaluate("saoView.seek(10)")
    assert page.evaluate("document.querySelectorAll('.terminal.lit').length") == 0
    assert troubles == []
    page.close()


@needs_chromium
def test_search_keyboard_history_and_cost(browser: Any, flagship: tuple[Path, np.ndarray]) -> None:
    page, troubles = open_page(browser, flagship[0])
    page.keyboard.press("/")
    page.keyboard.type("line_search")
    page.locator("#found button").first.click()
    page.wait_for_function("() => saoView.here().path === 'step3.ip[0]'")
    assert page.inner_text("#panel h2") == "search"
    page.keyboard.press("Enter")
    page.wait_for_function("() => saoView.here().path === 'step3.ip[0].search'")
    page.keyboard.press("u")
    page.wait_for_function("() => saoView.here().path === 'step3.ip[0]'")
    page.go_back()
    page.wait_for_function("() => saoView.here().path === 'step3.ip[0].search'")
    page.evaluate("saoView.go('')")
    page.wait_for_function("() => saoView.here().path === ''")
    page.keyboard.press("c")
    costs = page.evaluate("[...document.querySelectorAll('.cost')].map((t) => Number(t.textContent))")
    tree = saoflow.load("cmhe_fte").budget().tree
    assert max(costs) == tree.parts["step3"].total
    page.keyboard.press("ArrowRight")
    assert page.evaluate("document.querySelectorAll('.chosen').length") == 1
    assert troubles == []
    page.close()


@needs_chromium
def test_a_deep_link_opens_where_it_points(browser: Any, flagship: tuple[Path, np.ndarray]) -> None:
    page = browser.new_page()
    page.goto(flagship[0].as_uri() + "#step3.ip[1].backward[0]")
    page.wait_for_function("() => globalThis.saoView && saoView.here().path === 'step3.ip[1].backward[0]'")
    assert page.inner_text("#panel h2") == "backward_stage"
    page.close()


@needs_chromium
def test_the_page_is_the_same_without_a_worker(browser: Any, flagship: tuple[Path, np.ndarray], tmp_path: Path) -> None:
    """Workers refused by the browser, or by a policy: elkjs runs in the page."""
    drawn = "() => [document.querySelector('#sheet').innerHTML, document.querySelector('#sheet').getAttribute('viewBox')]"
    page, troubles = open_page(browser, flagship[0])
    with_worker = page.evaluate(drawn)
    assert len(page.workers) == 1 and page.evaluate("typeof ELK") == "undefined" and troubles == []
    page.close()
    text = flagship[0].read_text(encoding="utf-8")
    assert text.count("<script>") == 3 and text.count("worker-src blob:") == text.count("'unsafe-inline' blob:") == 1
    without = {
        "none": text.replace("<script>", "<script>globalThis.Worker = class { constructor() { throw new Error('none'); } };", 1),
        "refused": text.replace("worker-src blob:", "worker-src 'none'"),
        "elkjs refused in it": text.replace("'unsafe-inline' blob:", "'unsafe-inline'"),
    }
    for name, changed in without.items():
        path = tmp_path / f"{name}.html"
        path.write_text(changed, encoding="utf-8")
        page, _ = open_page(browser, path)
        assert page.evaluate(drawn) == with_worker
        assert page.evaluate("typeof ELK") == "function" and page.workers == []
        page.close()


@needs_chromium
def test_letters_too_small_to_read_are_left_out_until_one_looks_closer(browser: Any, tmp_path: Path) -> None:
    blocks = "".join(f"  w{k}: {{add: [{'x' if k == 0 else f'w{k - 1}'}, 1]}}\n" for k in range(150))
    (tmp_path / "s.yaml").write_text(f"sheet: s\ninputs: [x]\nblocks:\n{blocks}outputs: [w149]\n")
    assert run(["view", str(tmp_path / "s.yaml"), "-o", str(tmp_path / "s.html")]) == 0
    page, troubles = open_page(browser, tmp_path / "s.html")
    name = page.locator("text.wire-name").first
    assert name.is_hidden()
    for _ in range(6):
        page.keyboard.press("+")
    assert name.is_visible()
    page.keyboard.press("f")
    assert name.is_hidden()
    page.evaluate("dispatchEvent(new Event('beforeprint'))")
    assert name.is_visible()
    assert troubles == []
    page.close()


def test_nothing_of_a_sheet_reaches_the_page_as_html(tmp_path: Path) -> None:
    sheet = tmp_path / "s.yaml"
    sheet.write_text("sheet: s\ndoc: </script><script>alert(1)</script>\ninputs: {x: {doc: '<img src=x>'}}\nblocks: {y: {add: [x, 1]}}\noutputs: [y]\n")
    target = tmp_path / "s.html"
    assert run(["view", str(sheet), "-o", str(target)]) == 0
    text = target.read_text()
    assert "alert(1)" not in text and "<img" not in text
    packed = re.search(r'id="data">([^<]*)<', text)
    assert packed is not None
    data = json.loads(gzip.decompress(base64.b64decode(packed[1])))
    assert data["drawings"][0]["doc"] == "</script><script>alert(1)</script>"


@needs_chromium
def test_a_hostile_doc_is_shown_as_text(browser: Any, tmp_path: Path) -> None:
    sheet = tmp_path / "s.yaml"
    sheet.write_text("sheet: s\ndoc: <b id='bad'>x</b>\ninputs: {x: {doc: '<i id=bad>'}}\nblocks: {y: {add: [x, 1], doc: '<u id=bad>'}}\noutputs: [y]\n")
    assert run(["view", str(sheet), "-o", str(tmp_path / "s.html")]) == 0
    page, troubles = open_page(browser, tmp_path / "s.html")
    assert "<b id='bad'>" in page.inner_text("#panel") and page.locator("#bad").count() == 0
    assert troubles == []
    page.close()


def test_bad_options_are_diagnosed(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    target = str(tmp_path / "x.svg")
    assert run(["view", "umhe_fte", "--svg", "--inside", "step3.stags", "-o", target]) == 2
    assert "E303" in (told := capsys.readouterr().err) and "did you mean `stages`" in told
    assert run(["view", "umhe_fte", "--inside", "step3", "--svg", "--run", "none.csv", "-o", target]) == 2
    assert "`--run` makes no sense here" in capsys.readouterr().err
    assert run(["view", "umhe_fte", "-o", str(tmp_path / "no" / "x.html")]) == 2
    assert "E601" in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []


def test_a_picture_for_documents(tmp_path: Path) -> None:
    pytest.importorskip("py_mini_racer", reason="the JavaScript engine of saoflow[svg] is not installed")
    import xml.etree.ElementTree as xml

    target = tmp_path / "k.svg"
    assert run(["view", "cmhe_fte", "--svg", "--inside", "step3.ip[0].stages[0].measured", "-o", str(target)]) == 0
    root = xml.parse(target).getroot()
    texts = {element.text for element in root.iter() if element.tag.endswith("text")}
    assert {"Pi", "Omega", "K", "P_f", "Σ", "[×]"} <= texts
    assert len([e for e in root.iter() if "block" in e.get("class", "").split()]) == len(
        saoflow.load("measurement_update", parameters=None).sheet.blocks
    )
