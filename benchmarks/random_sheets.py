"""Random sheets for benchmarks, by seed: sums, products, matrices, inverses, tables, limits, decisions, state, folds."""

from __future__ import annotations

import random
from pathlib import Path

import saoflow
from saoflow.pipeline import LoadedSheet

PART = """
sheet: part
inputs: {x: {shape: [4]}, u: {}, m: {shape: [4, 4]}}
blocks:
  a: {mul: [m, x], product: matrix}
  b: {mul: [a, u]}
  c: {add: [b, -x, u]}
  d: {mul: [m, c], product: matrix}
  e: {add: [d, a]}
  f: {saturation: e, low: -5, high: 5}
outputs: {x: f}
"""
"""A stateless sheet large enough to be called."""

KINDS = {
    "add": 5, "mul": 5, "matrix": 3, "square": 2, "inv2": 1, "saturation": 2, "lookup": 2, "lookup2": 1, "compare": 2,
    "logic": 1, "switch": 2, "delay": 2, "fold": 1,
}  # fmt: skip
"""Blocks drawn, with their weights."""


class _Drawing:
    def __init__(self, seed: int) -> None:
        self.random = random.Random(seed)
        self.wires: dict[str, tuple[bool, tuple[int, ...]]] = {
            "u": (False, ()), "w": (False, ()), "v": (False, (4,)), "m": (False, (4, 4)),
        }  # fmt: skip
        self.lines: list[str] = []
        weights = {k: w * self.random.choice((0.3, 1.0, 3.0)) for k, w in KINDS.items()}
        for i in range(self.random.randint(8, 60)):
            (kind,) = self.random.choices(list(weights), list(weights.values()))
            self._block(f"b{i}", kind)

    def pick(self, *shapes: tuple[int, ...], boolean: bool = False) -> str:
        """A wire of one of the shapes, recent ones first."""
        fitting = [n for n, (b, s) in self.wires.items() if b == boolean and s in shapes]
        return self.random.choice(fitting[-6:] if self.random.random() < 0.7 else fitting)

    def _add(self, name: str, text: str, shape: tuple[int, ...], boolean: bool = False) -> None:
        self.lines.append(f"  {name}: {{{text}}}")
        self.wires[name] = (boolean, shape)

    def _block(self, name: str, kind: str) -> None:
        shape = self.random.choice([(), (4,), (4,), (4, 4)])
        number = round(self.random.uniform(-2, 2), 3)
        booleans = {s for b, s in self.wires.values() if b}
        match kind:
            case "add":
                parts = [self.random.choice(["", "-"]) + self.pick((), shape) for _ in range(self.random.randint(1, 3))]
                self._add(name, f"add: [{', '.join([self.pick(shape), *parts])}]", shape)
            case "mul":
                self._add(name, f"mul: [{self.pick(shape)}, {number}, {self.pick((), shape)}]", shape)
            case "matrix":
                self._add(name, f"mul: [{self.pick((4, 4))}, {self.pick((4,))}], product: matrix", (4,))
            case "square":
                self._add(name, f"mul: [{self.pick((4, 4))}, {self.pick((4, 4))}], product: matrix", (4, 4))
            case "inv2":
                self.lines.append(f"  {name}_c: {{select: '{self.pick((4, 4))}[0:2, 0:2]'}}")
                self.lines.append(f"  {name}_i: {{inv2: {name}_c}}")
                self._add(name, f"select: '{name}_i[0, 1]'", ())
            case "saturation":
                high = self.random.choice(["2.5", self.pick(())])
                self._add(name, f"saturation: {self.pick(shape)}, low: -1.5, high: {high}", shape)
            case "lookup":
                n = self.random.choice([3, 5, 9, 20, 70, 200])
                x = [round(-3 + 6 * k / (n - 1), 5) for k in range(n)]
                y = [round(self.random.uniform(-2, 2), 3) for _ in x]
                how = self.random.choice(["linear", "linear", "hold"])
                self._add(
                    name, f"lookup: {self.pick((), (4,))}, breakpoints: {x}, values: {y}, interpolation: {how}", ()
                )
                self.wires[name] = self.wires[self.lines[-1].split("lookup: ")[1].split(",")[0]]
            case "lookup2":
                x, y = [-2, -1, 0, 2], [-1, 0, 0.5, 1, 3]
                z = [[round(self.random.uniform(-2, 2), 3) for _ in y] for _ in x]
                text = f"lookup: [{self.pick(())}, {self.pick(())}], breakpoints: {x}, columns: {y}, values: {z}"
                self._add(name, text, ())
            case "compare":
                relation = self.random.choice(["<", "<=", ">", ">="])
                shape = self.random.choice([(), (4,)])
                text = f"compare: [{self.pick(shape)}, {self.pick(())}], relation: '{relation}'"
                self._add(name, text, shape, True)
            case "logic" if booleans:
                shape = self.random.choice(sorted(booleans))
                self._add(name, f"{self.random.choice(['and', 'or'])}: [{self.pick(shape, boolean=True)}, "
                          f"{self.pick(shape, boolean=True)}]", shape, True)  # fmt: skip
            case "switch" if booleans:
                shape = self.random.choice(sorted(booleans))
                condition = self.pick(shape, boolean=True)
                self._add(name, f"switch: [{condition}, {self.pick(shape)}, {self.pick(shape)}]", shape)
            case "delay":
                self._add(name, f"delay: {self.pick(shape)}, initial: {number}", shape)
            case "fold":
                x, u, m = self.pick((4,)), self.pick(()), self.pick((4, 4))
                count = self.random.randint(2, 5)
                self.lines.append(
                    f"  {name}_f: {{fold: part, count: {count}, carry: {{x: {x}}}, in: {{u: {u}, m: {m}}}}}"
                )
                self._add(name, f"select: '{name}_f.x[-1]'", (4,))

    def text(self, name: str) -> str:
        """The sheet: outputs are the last wires, and those that nothing reads."""
        body = "\n".join(self.lines)
        made = [n for n in self.wires if n.startswith("b")]
        unread = [n for n in made if not any(f"{n}{c}" in body.replace(f"  {n}: ", "") for c in ",]}[)' ")]
        outputs = ", ".join(dict.fromkeys([*unread, *made[-2:]]))
        return (
            f"sheet: {name}\ninputs: {{u: {{}}, w: {{}}, v: {{shape: [4]}}, m: {{shape: [4, 4]}}}}\n"
            f"blocks:\n{body}\noutputs: [{outputs}]\n"
        )


def random_sheet(seed: int, folder: Path) -> LoadedSheet:
    """The sheet of a seed, written into a folder with the sheet that it calls."""
    (folder / "part.yaml").write_text(PART, encoding="utf-8")
    path = folder / f"random_{seed}.yaml"
    path.write_text(_Drawing(seed).text(f"random_{seed}"), encoding="utf-8")
    return saoflow.load(str(path))
