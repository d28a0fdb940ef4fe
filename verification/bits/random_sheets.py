"""Random valid sheets that use every symbol, shapes, folds, maps, state and odd constants; and odd inputs for them.

Needs hypothesis (extra ``test``), which also shrinks a failing sheet to a small readable one.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from hypothesis import strategies as st

SHAPES: list[tuple[int, ...]] = [(), (2,), (2, 2)]
NUMBERS = ["0", "1", "-1", "0.5", "-2", "1e-3", "3", "0.1", "1e-310", "1e30", "-1e-20", "1/3"]
SIDE_SHEETS: dict[str, str] = {
    "polynomial": """
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
""",
    "lag": """
sheet: lag
parameters: {gain: 0.3}
inputs: [u]
blocks:
  e: {add: [u, -x]}
  step: {mul: [e, gain]}
  next: {add: [x, step]}
  x: {delay: next, initial: 0.25}
outputs: {y: next}
""",
    "decide": """
sheet: decide
profile: sao
inputs: [x, u]
blocks:
  above: {compare: [x, u], relation: ">"}
  was: {delay: above, type: boolean}
  rises: {and: [above, not_was]}
  not_was: {not: was}
  either: {or: [rises, above, was]}
  y: {switch: [rises, x, u]}
  z: {switch: [either, y, 0.125]}
outputs: {y: z}
""",
}
"""Sheets that the random ones use; they lie beside them."""

INPUTS = {"u": (), "v": (2,), "m": (2, 2)}
"""The inputs of every random sheet."""

ODD = [0.0, -0.0, 1.0, -1.0, 0.5, -3.0, 1e-310, -5e-324, 1e200, 1e-45, 3.4e38, math.inf, -math.inf, math.nan]

ROWS = st.lists(
    st.lists(st.one_of(st.sampled_from(ODD), st.floats(-10, 10)), min_size=7, max_size=7), min_size=1, max_size=6
)
"""Frames of inputs: u, v (2), m (2x2)."""


@dataclass(slots=True)
class _Sheet:
    """A sheet in the making: its wires (kind and shape) and its blocks."""

    wires: dict[str, tuple[str, tuple[int, ...]]] = field(
        default_factory=lambda: {name: ("real", shape) for name, shape in INPUTS.items()}
    )
    lines: list[str] = field(default_factory=list)

    def named(self, kind: str, *shapes: tuple[int, ...]) -> list[str]:
        return [n for n, (k, s) in self.wires.items() if k == kind and (not shapes or s in shapes)]

    def add(self, name: str, block: str, shape: tuple[int, ...], kind: str = "real") -> None:
        self.lines.append(f"{name}: {{{block}}}")
        self.wires[name] = (kind, shape)

    def text(self, name: str) -> str:
        outputs = [n for n in self.wires if n.startswith("b")]
        blocks = "".join(f"  {line}\n" for line in self.lines)
        return (
            f"sheet: {name}\ninputs: {{u: {{}}, v: {{shape: [2]}}, m: {{shape: [2, 2]}}}}\n"
            f"blocks:\n{blocks}outputs: [{', '.join(outputs)}]\n"
        )


REAL_BLOCKS = (
    "add", "mul", "saturation", "delay", "compare", "lookup", "plane", "inv2", "matrix", "symmetric", "stack", "select",
    "transpose", "diagonal", "fold", "map", "lag", "decide", "slow",
)  # fmt: skip


@st.composite
def sheets(draw: st.DrawFn, name: str = "s", most: int = 18) -> str:
    """The text of a valid sheet; :data:`SIDE_SHEETS` must lie beside it."""
    sheet = _Sheet()
    for i in range(draw(st.integers(2, most))):
        booleans = sheet.named("boolean")
        what = draw(st.sampled_from([*REAL_BLOCKS, *(["logic", "switch"] if booleans else [])]))
        _draw_block(draw, sheet, f"b{i}", what)
    return sheet.text(name)


def _draw_block(draw: st.DrawFn, sheet: _Sheet, name: str, what: str) -> None:
    def pick(kind: str, *shapes: tuple[int, ...]) -> str:
        return draw(st.sampled_from(sheet.named(kind, *shapes)))

    def number() -> str:
        return draw(st.sampled_from(NUMBERS))

    shape = draw(st.sampled_from(SHAPES))
    a = pick("real")
    of_a = sheet.wires[a][1]
    match what:
        case "add":
            parts = [draw(st.sampled_from(["", "-"])) + pick("real", (), shape) for _ in range(draw(st.integers(1, 3)))]
            widest = max((sheet.wires[p.lstrip("-")][1] for p in parts), key=len)
            sheet.add(name, f"add: [{', '.join(parts)}]", widest)
        case "mul":
            sheet.add(name, f"mul: [{a}, {number()}, {pick('real', (), of_a)}]", of_a)
        case "saturation":
            limits = draw(st.sampled_from(["low: -1.5, high: {0}", "low: {0}", "high: {0}", "low: {0}, high: 2"]))
            sheet.add(name, f"saturation: {a}, " + limits.format(pick("real", ())), of_a)
        case "delay":
            sheet.add(name, f"delay: {a}, initial: {number()}, frames: {draw(st.integers(1, 3))}", of_a)
        case "compare":
            relation = draw(st.sampled_from(["<", "<=", ">", ">="]))
            sheet.add(name, f"compare: [{a}, {pick('real', ())}], relation: '{relation}'", of_a, "boolean")
        case "logic":
            b = pick("boolean")
            kind = draw(st.sampled_from(["and", "or", "not"]))
            fitting = sheet.named("boolean", (), sheet.wires[b][1])
            operands = [b] if kind == "not" else [b, draw(st.sampled_from(fitting))]
            sheet.add(name, f"{kind}: [{', '.join(operands)}]", sheet.wires[b][1], "boolean")
        case "switch":
            c = pick("boolean")
            of_c = sheet.wires[c][1]
            sheet.add(name, f"switch: [{c}, {pick('real', (), of_c)}, {pick('real', (), of_c)}]", of_c)
        case "lookup":
            mode = draw(st.sampled_from(["linear", "hold"]))
            table = f"breakpoints: [-1, 0, 0.7, 2], values: [3, -1, 0, 1], interpolation: {mode}"
            if draw(st.booleans()):
                table = "function: 'sqrt(x^2 + 1)', range: [-2, 3], error: 0.01"
            sheet.add(name, f"lookup: {a}, {table}", of_a)
        case "plane":
            table = "breakpoints: [-1, 0, 3], columns: [0, 1], values: [[1, 2], [-3, 0.5], [0, 7]]"
            sheet.add(name, f"lookup: [{pick('real', ())}, {pick('real', ())}], {table}", ())
        case "inv2":
            sheet.add(name, f"inv2: {pick('real', (2, 2))}", (2, 2))
        case "matrix":
            left, right = pick("real", (2, 2), (2,)), pick("real", (2, 2), (2,))
            result = sheet.wires[left][1][:-1] + sheet.wires[right][1][1:]
            sheet.add(name, f"mul: [{left}, {right}], product: matrix", result)
        case "symmetric":
            m = pick("real", (2, 2))
            sheet.add(name, f"mul: ['{m}', '{m}.T'], product: matrix, symmetric: true", (2, 2))
        case "stack":
            parts = [pick("real", ()), draw(st.sampled_from([number(), pick("real", ())]))]
            sheet.add(name, f"concatenate: [{', '.join(parts)}]", (2,))
        case "select":
            index = draw(st.sampled_from(["[0]", "[-1]"]))
            sheet.add(name, f"select: '{pick('real', (2,))}{index}'", ())
        case "transpose":
            sheet.add(name, f"transpose: {pick('real', (2, 2))}", (2, 2))
        case "diagonal":
            sheet.add(name, f"diagonal: {pick('real', (2,))}", (2, 2))
        case "fold":
            order = draw(st.sampled_from(["", ", order: reverse"]))
            carry = f"carry: {{x: {pick('real', ())}}}, each: {{u: {pick('real', (2,))}}}"
            sheet.add(name, f"fold: polynomial, count: 2{order}, {carry}", (2,))
        case "map":
            sheet.add(name, f"map: lag, count: 2, each: {{u: {pick('real', (2,))}}}, gain: 0.1*(index + 1)", (2,))
        case "lag":
            sheet.add(name, f"lag: {pick('real', ())}", ())
        case "slow":
            every = draw(st.integers(1, 4))
            offset = draw(st.sampled_from(["auto", *map(str, range(every))]))
            rate = f"every: {every}, offset: {offset}, transition: {draw(st.sampled_from(['hold', 'delay']))}"
            which = draw(st.sampled_from(["lag: {0}", "decide: [{0}, {1}]", "polynomial: [{0}, {1}]"]))
            sheet.add(name, which.format(pick("real", ()), pick("real", ())) + f", {rate}, held: {number()}", ())
        case "decide":
            sheet.add(name, f"decide: [{pick('real', ())}, {pick('real', ())}]", ())
