"""The page of `saoflow view`: time to make it, its size, and time to its first drawing in Chromium.

Needs chromium and playwright. Times in Chromium are wall-clock medians; run it on a quiet machine.
"""

from __future__ import annotations

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


def opened(browser: Any, path: Path) -> float:
    """Seconds until the first sheet is drawn."""
    page = browser.new_page(viewport={"width": 1500, "height": 900})
    start = time.perf_counter()
    page.goto(path.as_uri())
    page.wait_for_selector("body[data-ready]", timeout=120_000)
    taken = time.perf_counter() - start
    page.close()
    return taken


def main() -> None:
    """Print the table."""
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
        print(f"{'page':22}{'made, CPU s':>12}{'MB':>7}{'drawn, s':>10}")
        for name, (sheet, run) in cases.items():
            path = Path(folder) / "page.html"
            start = time.process_time()
            write_view(path, saoflow.load(sheet), run)
            made = time.process_time() - start
            drawn = statistics.median(opened(browser, path) for _ in range(REPEAT))
            print(f"{name:22}{made:12.2f}{path.stat().st_size / 1e6:7.2f}{drawn:10.2f}")
        browser.close()


if __name__ == "__main__":
    main()
