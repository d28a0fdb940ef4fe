"""Random sheets: float interpreter, array interpreter, instrumented run and unsimplified program agree to the last bit."""

from __future__ import annotations

import tempfile
from collections import Counter
from pathlib import Path

import numpy as np
from hypothesis import HealthCheck, given, settings

from saoflow.scheduler.counting_run import CountingRun
from saoflow.scheduler.counts import count, frame_loads
from saoflow.scheduler.interpreter import scalar_interpreter
from saoflow.scheduler.lowering import lower
from saoflow.scheduler.rate_frames import frame_of
from saoflow.scheduler.validate import validate_program
from tests.sheet_text import same_bits, sheet_of
from verification.bits.random_sheets import ROWS, SIDE_SHEETS, sheets


@settings(max_examples=60, deadline=None, suppress_health_check=list(HealthCheck))
@given(sheets(), ROWS)
def test_four_ways_of_running_a_sheet_agree(text: str, rows: list[list[float]]) -> None:
    data = np.array(rows)
    inputs = {"u": data[:, 0], "v": data[:, 1:3], "m": data[:, 3:7].reshape(-1, 2, 2)}
    with tempfile.TemporaryDirectory() as folder:
        for name, content in SIDE_SHEETS.items():
            (Path(folder) / f"{name}.yaml").write_text(content, encoding="utf-8")
        sheet = sheet_of(Path(folder), text)
        program = sheet.frame_program
        scalar = sheet.simulator().run(inputs)
        batch = sheet.simulator().run({name: np.stack([a, a]) for name, a in inputs.items()})
        plain = lower(sheet.schedule, simplify=False)
    validate_program(plain)
    unsimplified = scalar_interpreter(plain)
    state = unsimplified.initial_state
    counting = CountingRun(program)
    loads, ran = frame_loads(program), Counter[str]()
    for k, row in enumerate(rows):
        expected = np.concatenate([np.ravel(scalar[port.name][k]) for port in program.outputs])
        assert same_bits(np.concatenate([np.ravel(batch[port.name][1, k]) for port in program.outputs]), expected)
        assert same_bits(np.array(counting.frame(row), dtype=float), expected)
        ran.update({kind: load[k % program.hyperperiod] for kind, load in loads.items() if kind != "operations"})
        frame = frame_of(program, k % program.hyperperiod)
        validate_program(frame)
        assert count(frame).total == loads["operations"][k % program.hyperperiod]
        found, state = unsimplified.frames[0](row, state)
        assert same_bits(np.array(found, dtype=float), expected)
    assert counting.kinds == {kind: n for kind, n in ran.items() if n}


def test_binary32_agrees_with_numpy_float32(tmp_path: Path) -> None:
    text = """
        sheet: s
        inputs: {u: {}, v: {}}
        blocks:
          a: {mul: [u, 0.1]}
          b: {add: [a, v, -0.3]}
          c: {inv2: [[[b, 0], [0, 1]]]}
          d: {select: "c[0, 0]"}
          e: {delay: d, initial: 0.7}
          f: {saturation: e, low: -0.2, high: 0.9}
        outputs: [b, d, f]
        """
    sheet = sheet_of(tmp_path, text)
    rng = np.random.default_rng(6)
    u, v = rng.normal(size=100), rng.normal(size=100)
    out = sheet.simulator(real=32).run({"u": u, "v": v})
    one = np.float32
    b = (u.astype(one) * one(0.1) + v.astype(one)) - one(0.3)
    d = one(1) / b
    e = np.concatenate([[one(0.7)], d[:-1]])
    assert out["b"].dtype == np.float32
    assert same_bits(out["b"], b) and same_bits(out["d"], d)
    assert same_bits(out["f"], np.minimum(np.maximum(e, one(-0.2)), one(0.9)))
