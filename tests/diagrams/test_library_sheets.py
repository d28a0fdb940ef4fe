"""Every sheet of the library against numpy, exact mode where it has tables."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import saoflow
from saoflow.diagrams.store import LIBRARY
from tests.sheet_text import sheet_of

Array = NDArray[Any]
FRAMES = 24
RANDOM = np.random.default_rng(20181)


def noise(*shape: int) -> Array:
    return RANDOM.normal(size=(FRAMES, *shape))


def flags(*shape: int) -> Array:
    return (RANDOM.uniform(size=(FRAMES, *shape)) < 0.3).astype(float)


def covariance(n: int) -> Array:
    root = noise(n, n)
    return root @ root.transpose(0, 2, 1) + 0.1 * np.eye(n)


def well_conditioned(n: int) -> Array:
    return noise(n, n) + 2.0 * n * np.eye(n)


def over_time(function: Callable[[Array], Array]) -> Callable[[Array], Array]:
    """From a function of the samples up to now to all frames."""
    return lambda x: np.array([function(x[: k + 1]) for k in range(len(x))])


def last_samples(n: int) -> Callable[[Array], Array]:
    """The last n samples, zeros before the first."""
    return over_time(lambda past: np.concatenate([np.zeros((n, *past.shape[1:])), past])[-n:])


def held(x: Array) -> Array:
    """x where it lies in -1 to 1, else the last that did, 0.25 before any."""
    result, last = [], np.full(x.shape[1:], 0.25)
    for row in x:
        last = np.where((row >= -1) & (row <= 1), row, last)
        result.append(last)
    return np.array(result)


def confirmed(flag: Array) -> Array:
    enough = last_samples(4)(flag).sum(axis=1) >= 2
    return np.maximum.accumulate(enough, axis=0)


def one_frame_later(x: Array) -> Array:
    return np.concatenate([np.zeros_like(x[:1]), x[:-1]])


def windows(x: Array, load: Array) -> Array:
    """Three samples, the oldest first; all of them the present one while load is true."""
    result, window = [], np.zeros((3, *x.shape[1:]))
    for row, fill in zip(x, load, strict=True):
        window = np.stack([row] * 3) if fill else np.concatenate([window[1:], row[None]])
        result.append(window)
    return np.array(result)


@dataclass(frozen=True)
class Case:
    """A library sheet with its inputs by port and what each output should be."""

    sheet: str
    inputs: dict[str, Array]
    outputs: dict[str, Any]
    parameters: str = ""
    booleans: tuple[str, ...] = ()
    units: dict[str, str] = field(default_factory=dict)
    tolerance: float = 1e-12


def with_gaps(x: Array) -> Array:
    return np.where(RANDOM.uniform(size=x.shape) < 0.2, RANDOM.choice([np.nan, np.inf, -np.inf], size=x.shape), x)


def cases() -> list[Case]:
    s, t = noise() + 4.0, noise()
    v, w, v3 = noise(5), noise(5), noise(3)
    p3, p4, p8 = covariance(3), covariance(4), covariance(8)
    m4, m8, a23 = well_conditioned(4), well_conditioned(8), noise(2, 3)
    f, g, flag = flags(3), flags(3), flags()
    load = np.array([1.0, 1.0] + [0.0] * 10 + [1.0] + [0.0] * (FRAMES - 13))
    angle = np.linspace(-1.4, 1.4, FRAMES)
    gaps = with_gaps(noise(3))
    valid = (gaps >= -1) & (gaps <= 1)
    kt, deg = 1852 / 3600, np.pi / 180
    frames = np.arange(FRAMES)
    last_low, last_high, loaded = noise(3), noise(3) + 3, noise(3)
    return [
        Case("reciprocal", {"x": s}, {"y": 1 / s}),
        Case("reciprocals", {"x": v}, {"y": 1 / v}, "n: 5"),
        Case("divide", {"a": t, "b": s}, {"y": t / s}),
        Case("inverse_4x4", {"M": m4}, {"y": np.linalg.inv(m4)}),
        Case("inverse_8x8", {"M": m8}, {"y": np.linalg.inv(m8)}),
        Case("inverse_4x4_symmetric", {"M": p4}, {"y": np.linalg.inv(p4)}, tolerance=1e-10),
        Case("inverse_8x8_symmetric", {"M": p8}, {"y": np.linalg.inv(p8)}, tolerance=1e-9),
        Case("dot", {"a": v, "b": w}, {"y": np.einsum("ki,ki->k", v, w)}, "n: 5"),
        Case("quadratic_form", {"x": v3, "M": p3}, {"y": np.einsum("ki,kij,kj->k", v3, p3, v3)}, "n: 3"),
        Case("congruence", {"A": a23, "P": p3}, {"y": a23 @ p3 @ a23.transpose(0, 2, 1)}, "m: 2, n: 3"),
        Case("larger", {"x": s, "largest": t}, {"largest": np.maximum(s, t)}),
        Case("smaller", {"x": s, "smallest": t}, {"smallest": np.minimum(s, t)}),
        Case("maximum", {"x": v}, {"y": v.max(axis=1)}, "n: 5"),
        Case("minimum", {"x": v}, {"y": v.min(axis=1)}, "n: 5"),
        Case("absolute_value", {"x": v}, {"y": np.abs(v)}),
        Case("sine_cosine", {"angle": angle}, {"sin": np.sin(angle), "cos": np.cos(angle)}),
        Case("kt_to_mps", {"x": v}, {"y": v * kt}, units={"x": "kt"}),
        Case("mps_to_kt", {"x": v}, {"y": v / kt}, units={"x": "m/s"}),
        Case("deg_to_rad", {"x": v}, {"y": v * deg}, units={"x": "deg"}),
        Case("rad_to_deg", {"x": v}, {"y": v / deg}, units={"x": "rad"}),
        Case(
            "window_tap",
            {"sample": v, "present": w, "load": load},
            {"sample": np.where(load[:, None] > 0, w, one_frame_later(v))},
            booleans=("load",),
        ),
        Case("window", {"x": v, "load": load}, {"y": windows(v, load)}, "n: 3", ("load",)),
        Case("last_tap", {"sample": v}, {"sample": one_frame_later(v)}),
        Case("last", {"x": v}, {"y": last_samples(4)(one_frame_later(v))}, "n: 4"),
        Case("running_sum", {"sum": v, "x": w}, {"sum": v + w}),
        Case("sum_of", {"x": p3}, {"y": p3.sum(axis=1)}, "n: 3"),
        Case("sum_of_last", {"x": v}, {"y": last_samples(4)(v).sum(axis=1)}, "n: 4"),
        Case("square_root", {"x": np.abs(v)}, {"y": np.sqrt(np.abs(v))}, "largest: 25"),
        Case("norm", {"x": v}, {"y": np.linalg.norm(v, axis=1)}, "n: 5, largest: 10"),
        Case("window_rms", {"x": v}, {"y": np.sqrt((last_samples(4)(v) ** 2).mean(axis=1))}, "n: 4, largest: 10"),
        Case("count_last", {"flag": f}, {"y": last_samples(4)(f).sum(axis=1)}, "n: 4", ("flag",)),
        Case(
            "latch",
            {"x": f},
            {"y": np.maximum.accumulate(f), "before": one_frame_later(np.maximum.accumulate(f))},
            "size: 3",
            ("x",),
        ),
        Case(
            "confirmation",
            {"flag": f},
            {"confirmed": confirmed(f), "before": one_frame_later(confirmed(f))},
            "n: 4, needed: 2, size: 3",
            ("flag",),
        ),
        Case(
            "in_range",
            {"x": gaps, "low": last_low, "high": last_high},
            {"y": (gaps >= last_low) & (gaps <= last_high)},
        ),
        Case(
            "hold_last_valid",
            {"x": gaps},
            {"y": held(gaps), "valid": valid},
            "low: -1, high: 1, nominal: [0.25, 0.25, 0.25]",
        ),
        Case("first_frame", {}, {"y": frames == 0}),
        Case(
            "initialise",
            {"memory": gaps[:, :3], "first": loaded, "load": load},
            {"y": np.where(load[:, None] > 0, loaded, gaps)},
            booleans=("load",),
        ),
        Case(
            "limit",
            {"x": 3 * last_low, "low": last_high - 5, "high": last_high},
            {"y": np.clip(3 * last_low, last_high - 5, last_high)},
        ),
        Case("any_of", {"x": f}, {"y": f.any(axis=1)}, "n: 3", ("x",)),
        Case("all_of", {"x": 1 - f}, {"y": (1 - f).all(axis=1)}, "n: 3", ("x",)),
        Case("either", {"any": f[:, 0], "x": g[:, 0]}, {"any": (f[:, 0] + g[:, 0]) > 0}, booleans=("any", "x")),
        Case("both", {"all": 1 - f[:, 0], "x": flag}, {"all": (1 - f[:, 0]) * flag > 0}, booleans=("all", "x")),
        *linear_algebra(),
    ]


def linear_algebra() -> list[Case]:
    """Equations with symmetric matrices, measurements one after the other, and a turn in the plane."""
    p4, b4, x3, c3, lambda3, p3 = covariance(4), noise(4), noise(3), noise(3), noise(3), covariance(3)
    r, z, e, per_s = noise() ** 2 + 0.1, noise(), noise(), noise() ** 2
    column = p4[:, 1:, 0] / p4[:, :1, 0]
    a, path, forces = noise() / 5, noise() / 5, noise(3)
    turned = np.stack([np.cos(a), np.sin(a)]), np.stack([-np.sin(a), np.cos(a)])
    along, across = (np.einsum("ik,ki->k", row, forces[:, :2]) for row in turned)
    gain = np.einsum("kij,kj->ki", p3, c3) / (np.einsum("ki,kij,kj->k", c3, p3, c3) + r)[:, None]
    without = np.eye(3) - np.einsum("ki,kj->kij", gain, c3)
    innovation = z - np.einsum("ki,ki->k", c3, x3)
    Pc = np.einsum("kij,kj->ki", p3, c3)
    return [
        Case(
            "forces_along_path",
            {
                "A_x": forces[:, 0],
                "A_z": forces[:, 1],
                "gravity": forces[:, 2],
                "sin": np.sin(a),
                "cos": np.cos(a),
                "path_sin": np.sin(path),
                "path_cos": np.cos(path),
            },
            {
                # The body's force turned by alpha, and gravity by the path's angle
                "f_alpha": across + forces[:, 2] * np.cos(path),
                "f_v": along + forces[:, 2] * np.sin(path),
                "g_cos": forces[:, 2] * np.cos(path),
                "g_sin": forces[:, 2] * np.sin(path),
            },
        ),
        Case(
            "eliminate_first",
            {"M": p4, "b": b4},
            {
                # The Schur complement is the inverse of a block of the inverse.
                "M": np.linalg.inv(np.linalg.inv(p4)[:, 1:, 1:]),
                "b": b4[:, 1:] - column * b4[:, :1],
                "l": column,
                "first": b4[:, 0] / p4[:, 0, 0],
            },
            "n: 4",
            tolerance=1e-9,
        ),
        Case(
            "put_back_first",
            {"x": x3, "l": lambda3, "first": z},
            {"x": np.column_stack([z - np.einsum("ki,ki->k", lambda3, x3), x3])},
            "n: 4",
        ),
        Case(
            "solve_symmetric",
            {"M": p4, "b": b4},
            {"x": np.linalg.solve(p4, b4[..., None])[..., 0]},
            "n: 4",
            tolerance=1e-10,
        ),
        Case(
            "scalar_update",
            {"P": p3, "x": x3, "c": c3, "r": r, "z": z},
            {
                # Joseph's form
                "P": without @ p3 @ without.transpose(0, 2, 1) + np.einsum("k,ki,kj->kij", r, gain, gain),
                "x": x3 + gain * innovation[:, None],
                "Pc": Pc,
                "per_s": 1 / (np.einsum("ki,ki->k", c3, Pc) + r),
                "e": innovation,
            },
            "n: 3",
            tolerance=1e-10,
        ),
        Case(
            "scalar_update_back",
            {"lambda": lambda3, "c": c3, "Pc": Pc, "per_s": per_s, "e": e},
            {"lambda": lambda3 - c3 * ((e + np.einsum("ki,ki->k", Pc, lambda3)) * per_s)[:, None]},
            "n: 3",
        ),
    ]


CASES = cases()


def wrapper(case: Case) -> str:
    """A sheet that does nothing but use the library sheet; its inputs have the shapes of the arrays."""
    lines = ["sheet: wrapper", "inputs:", "  clock: {}"]
    for port, values in case.inputs.items():
        kind = ", type: boolean" if port in case.booleans else ""
        unit = f", unit: {case.units[port]}" if port in case.units else ""
        lines.append(f"  {port}: {{shape: {list(values.shape[1:])}{kind}{unit}}}")
    operands = ", ".join(f"{port}: {port}" for port in case.inputs)
    more = f", {case.parameters}" if case.parameters else ""
    wires = f"{{{operands}}}" if operands else "[]"
    lines += [f"blocks: {{used: {{{case.sheet}: {wires}{more}}}}}"]
    lines += ["outputs: [" + ", ".join(f"used.{port}" for port in case.outputs) + "]"]
    return "\n".join(lines) + "\n"


def test_no_sheet_is_left_out() -> None:
    assert {case.sheet for case in CASES} == {path.stem for path in LIBRARY.glob("*.yaml")}


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.sheet)
def test_equals_numpy(case: Case, tmp_path: Path) -> None:
    sheet = sheet_of(tmp_path, wrapper(case), name="wrapper")
    found = sheet.simulator(exact=True).run({"clock": np.zeros(FRAMES), **case.inputs})
    assert set(found) == set(case.outputs)
    for port, expected in case.outputs.items():
        values, wanted = (np.asarray(array, dtype=float) for array in (found[port], expected))
        np.testing.assert_allclose(values, wanted, rtol=case.tolerance, atol=case.tolerance)


@pytest.mark.parametrize("path", sorted(LIBRARY.glob("*.yaml")), ids=lambda path: path.stem)
def test_says_what_it_is(path: Path) -> None:
    sheet = saoflow.load(str(path)).sheet
    assert sheet.doc.endswith(".")
    assert sheet.profile is not None


def operations(tmp_path: Path, text: str) -> int:
    return sheet_of(tmp_path, text, name="counted").budget().tree.total


def test_a_reciprocal_is_one_operation(tmp_path: Path) -> None:
    text = "sheet: counted\ninputs: {x: {}}\nblocks: {r: {reciprocal: x}}\noutputs: [r]\n"
    assert operations(tmp_path, text) == 1


def test_the_symmetric_inverse_costs_less(tmp_path: Path) -> None:
    """The symmetry of its argument is carried by the wires: a product with its own transpose has it."""

    def text(inverse: str) -> str:
        return f"""\
            sheet: counted
            inputs: {{A: {{shape: [8, 8]}}}}
            blocks:
              S: {{mul: [A, A.T], product: matrix, symmetric: true}}
              inverse: {{{inverse}: S}}
            outputs: [inverse]
            """

    general, symmetric = (operations(tmp_path, text(i)) for i in ("inverse_8x8", "inverse_8x8_symmetric"))
    product = 36 * 15
    assert symmetric - product < 0.72 * (general - product)


def test_an_inverse_leaves_out_what_is_known(tmp_path: Path) -> None:
    """Of blkdiag(S, I) the 8x8 inverse costs no more than the 4x4 inverse of S."""
    text = """\
        sheet: counted
        inputs: {{S: {{shape: [4, 4]}}}}
        blocks:
          upper: {{concatenate: [S, "zeros(4, 4)"], axis: columns}}
          M: {{concatenate: [upper, "concatenated"]}}
          concatenated: {{concatenate: ["zeros(4, 4)", eye(4)], axis: columns}}
          inverse: {{{inverse}: {argument}}}
        outputs: [inverse]
        """
    eight = operations(tmp_path, text.format(inverse="inverse_8x8_symmetric", argument="M"))
    four = operations(tmp_path, text.format(inverse="inverse_4x4_symmetric", argument="S"))
    assert eight == four


def test_a_band_is_left_out_of_the_elimination(tmp_path: Path) -> None:
    """Of a tridiagonal matrix only the band is worked on: the cost grows with n, not with its cube."""

    def cost(n: int) -> int:
        band = "[" + ", ".join("[" + ", ".join(entry(i, j) for j in range(n)) + "]" for i in range(n)) + "]"
        text = f"""\
            sheet: counted
            inputs: {{d: {{shape: [{n}]}}, e: {{shape: [{n}]}}, b: {{shape: [{n}]}}}}
            blocks:
              M: {{concatenate: ["{band}"]}}
              solved: {{solve_symmetric: [M, b], n: {n}}}
            outputs: [solved]
            """
        return operations(tmp_path, text)

    def entry(i: int, j: int) -> str:
        return f"d[{i}]" if i == j else f"e[{max(i, j)}]" if abs(i - j) == 1 else "0"

    four, eight = cost(4), cost(8)
    assert cost(12) - eight == eight - four
