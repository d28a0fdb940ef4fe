"""The frame program as JavaScript against the interpreter: the same bits on every wire."""

from __future__ import annotations

import json
import struct
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st

import saoflow
from saoflow.drawing.javascript import TracedJavaScript, print_javascript
from saoflow.drawing.style import FOLDER, picture_css
from saoflow.scheduler.lowering import lower
from verification.bits.random_sheets import SIDE_SHEETS, sheets

mini_racer = pytest.importorskip("py_mini_racer", reason="the JavaScript engine of saoflow[svg] is not installed")

DRIVE = """
globalThis.result = (() => {
  const width = given.width, rows = [];
  let state = Float64Array.from(given.initial), next = new Float64Array(state.length);
  const trace = new Float64Array(given.size), row = new Float64Array(width);
  for (const bits of given.rows) {
    for (let k = 0; k < width; k++) row[k] = number(bits[k]);
    frame(row, state, next, trace);
    [state, next] = [next, state];
    rows.push(given.places.map((p) => hex(trace[p])));
  }
  return JSON.stringify(rows);
})();
"""
HELP = """
var globalThis = this, SAO = {};
var view = new DataView(new ArrayBuffer(8));
var number = (bits) => { view.setBigUint64(0, BigInt("0x" + bits)); return view.getFloat64(0); };
var hex = (x) => { if (x !== x) return "nan"; view.setFloat64(0, x); return view.getBigUint64(0).toString(16).padStart(16, "0"); };
"""


def bits(x: float) -> str:
    return struct.pack(">d", x).hex()


def shown(x: float) -> str:
    return "nan" if x != x else bits(float(x))


def drive(made: TracedJavaScript, rows: np.ndarray, places: Sequence[int]) -> list[list[str]]:
    """The traced values at some places, in every frame."""
    engine = mini_racer.MiniRacer()
    engine.eval(HELP)
    engine.eval((FOLDER / "player.js").read_text())
    engine.eval(made.text)
    given = {
        "width": rows.shape[1],
        "rows": [[bits(x) for x in row] for row in rows],
        "initial": made.initial,
        "size": made.size,
        "places": list(places),
    }
    engine.eval(f"var given = {json.dumps(given)};")
    engine.eval(DRIVE)
    answer: list[list[str]] = json.loads(str(engine.eval("result")))
    return answer


def traced(sheet: saoflow.LoadedSheet, wires: dict[str, int]) -> tuple[TracedJavaScript, dict[str, list[Any]]]:
    """The program, and where the wires of the root's body are."""
    made = print_javascript(lower(sheet.schedule, traced=True))
    scope = made.bodies[-1]["scopes"][""]
    body, found = sheet.netlist.root, {}
    for name, wire in wires.items():
        place, size = scope[wire], body.type_of(wire).size
        found[name] = [place + k for k in range(size)] if isinstance(place, int) else place
    return made, found


def assert_same_bits(sheet: saoflow.LoadedSheet, inputs: dict[str, np.ndarray], probes: Sequence[str] = ()) -> None:
    body = sheet.netlist.root
    wires = {port.name: port.wire for port in body.structure.outputs}
    by_path = {node.path: node.outputs[0] for node in body.nodes}
    wires.update({probe: by_path[probe] for probe in probes})
    made, places = traced(sheet, wires)
    frames = len(next(iter(inputs.values())))
    rows = np.concatenate(
        [np.asarray(inputs[p], dtype=np.float64).reshape(frames, -1) for p in sheet.input_types], axis=1
    )
    flat = [p for name in wires for p in places[name] if isinstance(p, int)]
    answer = drive(made, rows, flat)
    expected = sheet.simulator(probes=probes).run(inputs)
    for k in range(frames):
        row = iter(answer[k])
        for name in wires:
            values = np.asarray(expected[name][k], dtype=np.float64).ravel()
            for place, value in zip(places[name], values, strict=True):
                found = next(row) if isinstance(place, int) else shown(float(place[0]))
                assert found == shown(value), (name, k)


def test_the_flagship_through_faults_and_gaps() -> None:
    from verification.flights import Fault, Missing, load_recording, sensors

    truth = load_recording("a320_wind_350kt_5000ft").part(0.0, 9.6)
    fault = Fault("runaway", "vc", which=(1, 2, 3), rate=-40.0, onset=4.0)
    gap = Missing(("alpha_1", "vg"), 3.0, 5)
    inputs = sensors(truth, 3, faults=[fault], missing=[gap]).inputs()
    assert_same_bits(saoflow.load("cmhe_fte"), inputs, ["vc_check.J.mean_square", "row", "warm.x_shifted"])


@settings(max_examples=12, deadline=None, suppress_health_check=list(HealthCheck), phases=[Phase.generate])
@given(data=st.data(), seed=st.integers(0, 2**32 - 1))
def test_random_sheets(data: st.DataObject, seed: int, tmp_path_factory: pytest.TempPathFactory) -> None:
    folder: Path = tmp_path_factory.mktemp("script")
    for name, text in SIDE_SHEETS.items():
        (folder / f"{name}.yaml").write_text(text)
    (folder / "s.yaml").write_text(data.draw(sheets()))
    sheet = saoflow.load(str(folder / "s.yaml"))
    rng = np.random.default_rng(seed)
    odd = np.array([0.0, -0.0, np.nan, np.inf, -np.inf, 5e-324, 1e300])
    inputs = {}
    for name, wire in sheet.input_types.items():
        values = rng.normal(size=(12, *wire.shape)) * 3
        values[rng.random(values.shape) < 0.15] = rng.choice(odd)
        inputs[name] = values
    assert_same_bits(sheet, inputs)


def test_a_picture_has_the_style_of_what_is_drawn_and_no_other() -> None:
    """Not the page's around it, nor the outline of what has the keyboard, which would stand on every block."""
    css = picture_css()
    assert css.startswith(".box{fill:#")
    assert "outline" not in css and "aside" not in css and "var(--paper)" not in css
