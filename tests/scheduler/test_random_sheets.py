"""Random sheets: float interpreter, array interpreter, instrumented run and unsimplified program agree to the last bit."""

from __future__ import annotations

import math
import tempfile
from pathlib import Path

import numpy as np
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from saoflow.scheduler.counting_run import CountingRun
from saoflow.scheduler.counts import count
from saoflow.scheduler.interpreter import scalar_interpreter
from saoflow.scheduler.lowering import lower
from saoflow.scheduler.validate import validate_program
from tests.sheet_text import same_bits, sheet_of

SHAPES: list[tuple[int, ...]] = [(), (2,), (2, 2)]
NUMBERS = ["0", "1", "-1", "0.5", "-2", "1e-3", "3"]


@st.composite
def sheets(draw: st.DrawFn) -> str:
    """The text of a valid sheet with state, decisions, matrices, tables and a fold."""
    wires: dict[str, tuple[str, tuple[int, ...]]] = {"u": ("real", ()), "v": ("real", (2,)), "m": ("real", (2, 2))}
    lines: list[str] = []

    def pick(kind: str, *shapes: tuple[int, ...]) -> str:
        fitting = [n for n, (k, s) in wires.items() if k == kind and (not shapes or s in shapes)]
        return draw(st.sampled_from(fitting))

    for i in range(draw(st.integers(3, 18))):
        name = f"b{i}"
        booleans = [n for n, (k, _) in wires.items() if k == "boolean"]
        choices = ["add", "mul", "saturation", "delay", "compare", "lookup", "inv2", "matrix", "stack", "twice"]
        choices += ["logic", "switch"] if booleans else []
        what = draw(st.sampled_from(choices))
        shape = draw(st.sampled_from(SHAPES))
        if what == "add":
            parts = [draw(st.sampled_from(["", "-"])) + pick("real", (), shape) for _ in range(draw(st.integers(1, 3)))]
            shape = max((wires[p.lstrip("-")][1] for p in parts), key=len)
            lines.append(f"{name}: {{add: [{', '.join(parts)}]}}")
        elif what == "mul":
            a, number = pick("real"), draw(st.sampled_from(NUMBERS))
            shape = wires[a][1]
            lines.append(f"{name}: {{mul: [{a}, {number}, {pick('real', (), shape)}]}}")
        elif what == "saturation":
            a = pick("real")
            shape = wires[a][1]
            lines.append(f"{name}: {{saturation: {a}, low: -1.5, high: {pick('real', ())}}}")
        elif what == "delay":
            a, frames = pick("real"), draw(st.integers(1, 3))
            shape = wires[a][1]
            lines.append(f"{name}: {{delay: {a}, initial: {draw(st.sampled_from(NUMBERS))}, frames: {frames}}}")
        elif what == "compare":
            a = pick("real")
            relation = draw(st.sampled_from(["<", "<=", ">", ">="]))
            lines.append(f"{name}: {{compare: [{a}, {pick('real', ())}], relation: '{relation}'}}")
            wires[name] = ("boolean", wires[a][1])
            continue
        elif what == "logic":
            a = draw(st.sampled_from(booleans))
            fitting = [b for b in booleans if wires[b][1] in ((), wires[a][1])]
            kind = draw(st.sampled_from(["and", "or", "not"]))
            operands = [a] if kind == "not" else [a, draw(st.sampled_from(fitting))]
            lines.append(f"{name}: {{{kind}: [{', '.join(operands)}]}}")
            wires[name] = ("boolean", wires[a][1])
            continue
        elif what == "switch":
            c = draw(st.sampled_from(booleans))
            shape = wires[c][1]
            lines.append(f"{name}: {{switch: [{c}, {pick('real', (), shape)}, {pick('real', (), shape)}]}}")
        elif what == "lookup":
            a = pick("real")
            shape = wires[a][1]
            mode = draw(st.sampled_from(["linear", "hold"]))
            table = f"breakpoints: [-1, 0, 0.7, 2], values: [3, -1, 0, 1], interpolation: {mode}"
            lines.append(f"{name}: {{lookup: {a}, {table}}}")
        elif what == "inv2":
            shape = (2, 2)
            lines.append(f"{name}: {{inv2: {pick('real', (2, 2))}}}")
        elif what == "matrix":
            a, b = pick("real", (2, 2), (2,)), pick("real", (2, 2), (2,))
            shape = wires[a][1][:-1] + wires[b][1][1:]
            lines.append(f"{name}: {{mul: [{a}, {b}], product: matrix}}")
        elif what == "stack":
            a, number = pick("real", ()), draw(st.sampled_from(NUMBERS))
            shape = (2,)
            lines.append(f"{name}: {{concatenate: [{a}, {number}]}}")
        else:
            shape = ()
            lines.append(
                f"{name}: {{fold: polynomial, count: 3, carry: {{x: {pick('real', ())}}}, in: {{u: {pick('real', ())}}}}}"
            )
            lines.append(f"{name}_last: {{select: '{name}.x[-1]'}}")
            name = f"{name}_last"
        wires[name] = ("real", shape)
    outputs = [n for n in wires if n.startswith("b")]
    body = "\n".join(f"  {line}" for line in lines)
    return (
        "sheet: s\ninputs: {u: {}, v: {shape: [2]}, m: {shape: [2, 2]}}\n"
        f"blocks:\n{body}\noutputs: [{', '.join(outputs)}]\n"
    )


POLYNOMIAL = """
sheet: polynomial
inputs: [x, u]
blocks:
  a: {mul: [x, x]}
  b: {mul: [a, u]}
  c: {add: [b, -x, u]}
  d: {mul: [c, c, 0.25]}
  e: {saturation: d, low: -5, high: 5}
  f: {add: [e, a, -b]}
  g: {mul: [f, 0.5]}
  h: {add: [g, x, -u, c]}
outputs: {x: h}
"""

ODD = st.sampled_from([0.0, -0.0, 1.0, -1.0, 0.5, -3.0, 1e-310, 1e200, math.inf, -math.inf, math.nan])
ROW = st.lists(ODD, min_size=7, max_size=7)


@settings(max_examples=60, deadline=None, suppress_health_check=list(HealthCheck))
@given(sheets(), st.lists(ROW, min_size=1, max_size=5))
def test_four_ways_of_running_a_sheet_agree(text: str, rows: list[list[float]]) -> None:
    data = np.array(rows)
    inputs = {"u": data[:, 0], "v": data[:, 1:3], "m": data[:, 3:7].reshape(-1, 2, 2)}
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "polynomial.yaml").write_text(POLYNOMIAL, encoding="utf-8")
        sheet = sheet_of(Path(folder), text)
        program = sheet.frame_program
        scalar = sheet.simulator().run(inputs)
        batch = sheet.simulator().run({name: np.stack([a, a]) for name, a in inputs.items()})
        plain = lower(sheet.schedule, simplify=False)
    validate_program(plain)
    unsimplified = scalar_interpreter(plain)
    state = unsimplified.initial_state
    counting = CountingRun(program)
    for k, row in enumerate(rows):
        expected = np.concatenate([np.ravel(scalar[port.name][k]) for port in program.outputs])
        assert same_bits(np.concatenate([np.ravel(batch[port.name][1, k]) for port in program.outputs]), expected)
        assert same_bits(np.array(counting.frame(row), dtype=float), expected)
        found, state = unsimplified.frames[0](row, state)
        assert same_bits(np.array(found, dtype=float), expected)
    derived = count(program)
    assert counting.kinds == {kind: n * len(rows) for kind, n in derived.kinds.items() if n}


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
