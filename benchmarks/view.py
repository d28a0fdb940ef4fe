"""The page of `saoflow view`: time to make it, its size, and time to its first drawing in Chromium.

Needs chromium and playwright. "Drawn" is the wall clock from going to the page to its first drawing, on a quiet machine the
number that counts; "processor" is what all threads of the page's process spend until then, which other work moves less (its
compilers run beside the page's own threads). Medians, the pages taken in turn; the load average stands below.
"""

from __future__ import annotations

import argparse
import os
import random
import shutil
import statistics
import tempfile
import time
from pathlib import Path
from typing import Any

from playwright.sync_api import sync_playwright

import saoflow
from saoflow.drawing.page import RunShown, write_view
from verification.flights import Fault, load_recording, sensors

REPEAT = 5


def large_sheet(blocks: int) -> str:
    """A sheet of so many blocks, each wired to blocks shortly before it."""
    rng = random.Random(3)
    names, lines = ["a", "b", "c"], ["sheet: large", "inputs: [a, b, c]", "blocks:"]
    for i in range(blocks):
        near = names[-25:] if rng.random() < 0.97 else names
        x, y = rng.choice(near), rng.choice(near)
        forms = (f"{{add: [{x}, {y}]}}", f"{{mul: [{x}, 0.5]}}", f"{{saturation: {x}, low: -1, high: 1}}", f"{{delay: {x}}}")
        lines.append(f"  w{i}: {rng.choice(forms)}")
        names.append(f"w{i}")
    return "\n".join([*lines, f"outputs: [{', '.join(names[-5:])}]", ""])


def opened(browser: Any, path: Path) -> tuple[float, float]:
    """Seconds until the first sheet is drawn: by the clock, and of processor."""
    page = browser.new_page(viewport={"width": 1500, "height": 900})
    session = browser.new_browser_cdp_session()
    before = _processor(session)
    start = time.perf_counter()
    page.goto(path.as_uri())
    page.wait_for_selector("body[data-ready]", timeout=120_000)
    taken = time.perf_counter() - start
    spent = _processor(session) - before
    session.detach()
    page.close()
    return taken, spent


def _processor(session: Any) -> float:
    """Seconds of processor of all processes that show pages."""
    return sum(p["cpuTime"] for p in session.send("SystemInfo.getProcessInfo")["processInfo"] if p["type"] == "renderer")


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--repeat", type=int, default=REPEAT)
    options = parser.parse_args()
    chromium = next(found for name in ("chromium", "chromium-browser", "google-chrome") if (found := shutil.which(name)))
    truth = load_recording("a320_calm_350kt_5000ft").part(0.0, 42.0)
    inputs = sensors(truth, 1, faults=[Fault("runaway", "vc", rate=-15.0, onset=20.0)]).inputs()
    with tempfile.TemporaryDirectory() as folder, sync_playwright() as play:
        browser = play.chromium.launch(executable_path=chromium, args=["--no-sandbox"])
        large = Path(folder) / "large.yaml"
        large.write_text(large_sheet(2000))
        cases = {
            "cmhe_fte": ("cmhe_fte", None),
            "cmhe_fte with a run": ("cmhe_fte", RunShown(inputs, len(truth), 0.048)),
            "2000 blocks": (str(large), None),
        }
        made: dict[str, float] = {}
        times: dict[str, list[tuple[float, float]]] = {name: [] for name in cases}
        for name, (sheet, run) in cases.items():
            start = time.process_time()
            write_view(Path(folder) / f"{name}.html", saoflow.load(sheet), run)
            made[name] = time.process_time() - start
        for _ in range(options.repeat):
            for name in cases:
                times[name].append(opened(browser, Path(folder) / f"{name}.html"))
        print(f"{'page':22}{'made, CPU s':>12}{'MB':>7}{'drawn, s':>10}{'processor, s':>14}")
        for name in cases:
            size = (Path(folder) / f"{name}.html").stat().st_size / 1e6
            drawn, spent = (statistics.median(column) for column in zip(*times[name], strict=True))
            print(f"{name:22}{made[name]:12.2f}{size:7.2f}{drawn:10.2f}{spent:14.2f}")
        print(f"load average {os.getloadavg()[0]:.1f}")
        browser.close()


if __name__ == "__main__":
    main()
