"""Every symbol against its definition, written out by hand here, odd numbers included."""

from __future__ import annotations

import itertools
import math
from pathlib import Path

import numpy as np
import pytest

from saoflow.blocks.library import SYMBOLS
from saoflow.scheduler.counting_run import CountingRun
from saoflow.symbol_catalogue import EXAMPLE, cost_text
from tests.sheet_text import run, same_bits, sheet_of

ODD = [0.0, -0.0, 1.0, -1.0, 0.5, -2.5, 1e-310, 1e308, -1e308, math.inf, -math.inf, math.nan]
PAIRS = np.array(list(itertools.product(ODD, ODD)))
TRIPLES = np.array(list(itertools.product(ODD, ODD, [-1.0, 0.0, 2.0, math.nan, math.inf])))


def two(folder: Path, block: str) -> np.ndarray:
    sheet = sheet_of(folder, f"sheet: s\ninputs: [a, b]\nblocks: {{y: {block}}}\noutputs: [y]\n")
    return run(sheet, a=PAIRS[:, 0], b=PAIRS[:, 1])["y"]


def three(folder: Path, block: str) -> np.ndarray:
    sheet = sheet_of(folder, f"sheet: s\ninputs: [a, b, c]\nblocks: {{y: {block}}}\noutputs: [y]\n")
    return run(sheet, a=TRIPLES[:, 0], b=TRIPLES[:, 1], c=TRIPLES[:, 2])["y"]


def by_hand(function: object, rows: np.ndarray) -> np.ndarray:
    assert callable(function)
    return np.array([float(function(*row)) for row in rows.tolist()])


def test_sum_runs_left_to_right_with_signs(tmp_path: Path) -> None:
    assert same_bits(three(tmp_path, "{add: [a, b, c]}"), by_hand(lambda a, b, c: (a + b) + c, TRIPLES))
    assert same_bits(three(tmp_path, "{add: [a, -b, c]}"), by_hand(lambda a, b, c: (a - b) + c, TRIPLES))
    assert same_bits(three(tmp_path, "{add: [-a, b, -c]}"), by_hand(lambda a, b, c: (-a + b) - c, TRIPLES))
    assert same_bits(three(tmp_path, "{add: [-a, -b, -c]}"), by_hand(lambda a, b, c: (-a - b) - c, TRIPLES))


def test_product_runs_left_to_right(tmp_path: Path) -> None:
    assert same_bits(three(tmp_path, "{mul: [a, b, c]}"), by_hand(lambda a, b, c: (a * b) * c, TRIPLES))
    assert same_bits(two(tmp_path, "{mul: [a, -b]}"), by_hand(lambda a, b: a * -b, PAIRS))


def test_saturation_is_minimum_of_maximum_and_nan_gives_the_lower_limit(tmp_path: Path) -> None:
    def saturate(u: float, low: float, high: float) -> float:
        m = u if u > low else low
        return m if m < high else high

    assert same_bits(three(tmp_path, "{saturation: [a, b, c]}"), by_hand(saturate, TRIPLES))
    assert same_bits(two(tmp_path, "{saturation: a, high: b}"), by_hand(lambda a, b: a if a < b else b, PAIRS))
    out = two(tmp_path, "{saturation: a, low: -3, high: 4}")
    assert same_bits(out, by_hand(lambda a, b: saturate(a, -3.0, 4.0), PAIRS))
    assert out[np.isnan(PAIRS[:, 0])][0] == -3.0


@pytest.mark.parametrize("relation", ["<", "<=", ">", ">="])
def test_comparison_with_nan_is_false(tmp_path: Path, relation: str) -> None:
    meaning = {
        "<": lambda a, b: a < b,
        "<=": lambda a, b: a <= b,
        ">": lambda a, b: a > b,
        ">=": lambda a, b: a >= b,
    }[relation]
    out = two(tmp_path, f"{{compare: [a, b], relation: '{relation}'}}")
    assert same_bits(out, by_hand(meaning, PAIRS))
    assert not out[np.isnan(PAIRS).any(axis=1)].any()


def test_logic_and_switch(tmp_path: Path) -> None:
    text = """
        sheet: s
        profile: sao
        inputs: [a, b, c]
        blocks:
          p: {compare: [a, 0], relation: ">"}
          q: {compare: [b, 0], relation: ">"}
          both: {and: [p, q]}
          any: {or: [p, q, both]}
          neither: {not: any}
          y: {switch: [both, c, a]}
        outputs: [both, any, neither, y]
        """
    out = run(sheet_of(tmp_path, text), a=TRIPLES[:, 0], b=TRIPLES[:, 1], c=TRIPLES[:, 2])
    p, q = TRIPLES[:, 0] > 0, TRIPLES[:, 1] > 0
    assert np.array_equal(out["both"], (p & q).astype(float))
    assert np.array_equal(out["any"], (p | q).astype(float))
    assert np.array_equal(out["neither"], (~(p | q)).astype(float))
    assert same_bits(out["y"], np.where(p & q, TRIPLES[:, 2], TRIPLES[:, 0]))


def test_inverse_of_2x2_against_the_adjugate(tmp_path: Path) -> None:
    text = """
        sheet: s
        inputs: {m: {shape: [2, 2]}}
        blocks: {y: {inv2: m}}
        outputs: [y]
        """
    rng = np.random.default_rng(1)
    m = np.concatenate([rng.normal(size=(200, 2, 2)), np.zeros((1, 2, 2)), np.full((1, 2, 2), np.nan)])
    out = run(sheet_of(tmp_path, text), m=m)["y"]

    def adjugate(x: np.ndarray) -> np.ndarray:
        (a, b), (c, d) = x
        with np.errstate(all="ignore"):
            r = 1.0 / (a * d - b * c)
            return np.array([[d * r, -(b * r)], [-(c * r), a * r]])

    assert same_bits(out, np.array([adjugate(x) for x in m]))
    assert np.allclose(out[:200] @ m[:200], np.eye(2), atol=1e-9)


def test_inverse_of_diag_x_1_is_one_reciprocal(tmp_path: Path) -> None:
    text = """
        sheet: s
        inputs: [x]
        blocks:
          i: {inv2: [[[x, 0], [0, 1]]]}
        outputs: {y: "i[0, 0]"}
        """
    sheet = sheet_of(tmp_path, text)
    assert dict(sheet.budget().tree.kinds) == {"reciprocal": 1}
    x = np.array(ODD)
    with np.errstate(all="ignore"):
        assert same_bits(run(sheet, x=x)["y"], 1.0 / x)


def test_matrix_product_sums_over_the_inner_index_in_increasing_order(tmp_path: Path) -> None:
    text = """
        sheet: s
        inputs: {a: {shape: [3, 4]}, b: {shape: [4, 2]}, v: {shape: [4]}}
        blocks:
          ab: {mul: [a, b], product: matrix}
          av: {mul: [a, v], product: matrix}
          vv: {mul: [v, v], product: matrix}
          t: {mul: [b.T, a.T], product: matrix}
        outputs: [ab, av, vv, t]
        """
    rng = np.random.default_rng(2)
    a, b, v = rng.normal(size=(50, 3, 4)), rng.normal(size=(50, 4, 2)), rng.normal(size=(50, 4))
    a[3, 1, 2] = np.nan
    b[4, 0, 0] = np.inf
    out = run(sheet_of(tmp_path, text), a=a, b=b, v=v)

    def in_order(terms: list[float]) -> float:
        total = terms[0]
        for term in terms[1:]:
            total = total + term
        return total

    with np.errstate(all="ignore"):
        for k in range(50):
            for i, j in itertools.product(range(3), range(2)):
                expected = in_order([a[k, i, n] * b[k, n, j] for n in range(4)])
                assert same_bits(out["ab"][k, i, j], np.float64(expected))
                assert same_bits(out["t"][k, j, i], np.float64(expected))
            assert same_bits(out["vv"][k], np.float64(in_order([v[k, n] * v[k, n] for n in range(4)])))
            for i in range(3):
                assert same_bits(out["av"][k, i], np.float64(in_order([a[k, i, n] * v[k, n] for n in range(4)])))


def test_structure_leaves_out_zeros_and_ones(tmp_path: Path) -> None:
    """[[1, a], [0, -1]] x: x0 + a x1 costs a product and a sum, -x1 a negation."""
    text = """
        sheet: s
        inputs: {a: {}, x: {shape: [2]}}
        blocks:
          m: {concatenate: [[1, a], [0, -1]], axis: new}
          y: {mul: [m, x], product: matrix}
        outputs: [y]
        """
    sheet = sheet_of(tmp_path, text)
    assert dict(sheet.budget().tree.kinds) == {"multiply": 2, "add": 1}
    out = run(sheet, a=[2.0], x=[[3.0, 5.0]])["y"]
    assert np.array_equal(out, [[13.0, -5.0]])


def test_a_symmetric_product_is_computed_once(tmp_path: Path) -> None:
    text = """
        sheet: s
        inputs: {a: {shape: [3, 3]}}
        blocks:
          y: {mul: [a, a.T], product: matrix, symmetric: true}
          z: {add: [y, y.T]}
        outputs: [z]
        """
    sheet = sheet_of(tmp_path, text)
    kinds = sheet.budget().tree.kinds
    assert (kinds["multiply"], kinds["add"]) == (18, 12 + 6)
    a = np.random.default_rng(3).normal(size=(5, 3, 3))
    assert np.allclose(run(sheet, a=a)["z"], 2 * a @ a.transpose(0, 2, 1))


def test_delay_of_n_frames_and_shapes(tmp_path: Path) -> None:
    text = """
        sheet: s
        inputs: {u: {shape: [2]}}
        blocks:
          one: {delay: u, initial: [7, 8]}
          three: {delay: u, initial: 1, frames: 3}
        outputs: [one, three]
        """
    u = np.arange(10.0).reshape(5, 2)
    out = run(sheet_of(tmp_path, text), u=u)
    assert np.array_equal(out["one"], np.vstack([[7, 8], u[:-1]]))
    assert np.array_equal(out["three"], np.vstack([np.ones((3, 2)), u[:2]]))


def test_lookup_from_data(tmp_path: Path) -> None:
    text = """
        sheet: s
        inputs: [u, v]
        blocks:
          line: {lookup: u, breakpoints: [0, 1, 3], values: [10, 20, -20]}
          hold: {lookup: u, breakpoints: [0, 1, 3], values: [10, 20, -20], interpolation: hold}
          plane: {lookup: [u, v], breakpoints: [0, 2], columns: [0, 1], values: [[0, 1], [4, 9]]}
        outputs: [line, hold, plane]
        """
    u = np.array([-5.0, 0.0, 0.5, 1.0, 2.0, 3.0, 9.0, np.nan, np.inf, -np.inf])
    v = np.array([0.0, 0.0, 0.5, 1.0, 0.25, 2.0, -1.0, 0.0, np.nan, 1.0])
    out = run(sheet_of(tmp_path, text), u=u, v=v)
    assert np.allclose(out["line"], [10, 10, 15, 20, 0, -20, -20, 10, -20, 10])
    assert np.array_equal(out["hold"], [10, 10, 10, 20, 20, -20, -20, 10, -20, 10])
    x, y = np.clip(np.nan_to_num(u, nan=0.0), 0, 2) / 2, np.clip(np.nan_to_num(v, nan=0.0), 0, 1)
    assert np.allclose(out["plane"], x * (1 - y) * 4 + (1 - x) * y * 1 + x * y * 9)


def test_lookup_of_a_function_within_its_proved_error(tmp_path: Path) -> None:
    text = """
        sheet: s
        parameters: {n: 3.5}
        inputs: [u]
        blocks:
          y: {lookup: u, function: "(1 + x)^n - 1", range: [0, 0.5], error: 1e-5}
        outputs: [y]
        """
    sheet = sheet_of(tmp_path, text)
    u = np.linspace(-0.1, 0.6, 2001)
    exact = (1 + np.clip(u, 0, 0.5)) ** 3.5 - 1
    assert np.max(np.abs(run(sheet, u=u)["y"] - exact)) <= 1e-5
    assert np.allclose(sheet.simulator(exact=True).run({"u": u})["y"], exact, rtol=1e-14)


def test_wiring_is_free_and_exact(tmp_path: Path) -> None:
    text = """
        sheet: s
        inputs: {m: {shape: [2, 3]}, v: {shape: [3]}}
        blocks:
          rows: {concatenate: [m, v2]}
          v2: {concatenate: [v], axis: new}
          wide: {concatenate: [m, m], axis: columns}
          d: {diagonal: v}
          s: {select: "m[:, 1:]"}
          e: {select: m, index: [1, -1]}
          t: {transpose: m}
        outputs: [rows, wide, d, s, e, t]
        """
    sheet = sheet_of(tmp_path, text)
    assert sheet.budget().total == 0
    m, v = np.arange(6.0).reshape(1, 2, 3), np.array([[7.0, 8.0, 9.0]])
    out = run(sheet, m=m, v=v)
    assert np.array_equal(out["rows"][0], np.vstack([m[0], v[0]]))
    assert np.array_equal(out["wide"][0], np.hstack([m[0], m[0]]))
    assert np.array_equal(out["d"][0], np.diag(v[0]))
    assert np.array_equal(out["s"][0], m[0][:, 1:])
    assert out["e"][0] == m[0, 1, -1]
    assert np.array_equal(out["t"][0], m[0].T)


@pytest.mark.parametrize("block", [text for symbol in SYMBOLS.values() for text in symbol.examples])
def test_examples_of_the_documentation_run_and_cost_what_it_says(block: str, tmp_path: Path) -> None:
    sheet = sheet_of(tmp_path, EXAMPLE.format(block=block))
    rng = np.random.default_rng(4)
    inputs = {
        name: rng.random((1, *wire.shape)) < 0.5 if wire.boolean else rng.normal(size=(1, *wire.shape))
        for name, wire in sheet.input_types.items()
    }
    counted = CountingRun(sheet.frame_program)
    frame = counted.frame([value.item() for array in inputs.values() for value in np.ravel(array)])
    result = sheet.simulator().run(inputs)["result"]
    assert same_bits(np.array(frame, dtype=float), np.ravel(result).astype(float))
    assert np.all(np.isfinite(result))
    said = cost_text(sheet.budget())
    assert [f"{n} {kind}" for kind, n in sorted(counted.kinds.items())] == sorted(
        (" ".join(part.split()[:2]) for part in said.partition(" (")[0].split(", ") if "state" not in part and part != "free"),
        key=lambda part: part.split()[1],
    )
