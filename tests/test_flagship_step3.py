"""Step 3 of cmhe_fte by itself, pass by pass, against the numpy reference."""

from __future__ import annotations

from dataclasses import dataclass, fields
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from tests.sheet_text import sheet_of
from verification.reference import cmhe_fte
from verification.reference.arrays import saturate
from verification.reference.interior_point import Iteration, interior_point
from verification.reference.linearisation import QuadraticProgram, Window, linearise
from verification.reference.model import output
from verification.reference.tuning import Tuning

Array = NDArray[np.float64]
TUNING = Tuning()

STEP3 = """\
    sheet: root
    parameters:
      N: 3
      n_kappa: 2
      n_QP: 2
      n_s_max: 8
      t_s: {value: 0.048, unit: s}
      P: {unit: [1, m^2/s^2, m^2/s^2, m^2/s^2]}
      Q: {unit: [1/s^2, m^2/s^4, m^2/s^4, m^2/s^4]}
      R: {unit: [m^2/s^2, m^2/s^2, 1, m^2/s^2]}
      x_min: {unit: [1, m/s, m/s, m/s]}
      x_max: {unit: [1, m/s, m/s, m/s]}
      u_min: {unit: [1/s, m/s^2, m/s^2, m/s^2]}
      u_max: {unit: [1/s, m/s^2, m/s^2, m/s^2]}
      kappa_init: 1
      kappa_factor: 0.1
      clip_margin: 1e-3
      distance_floor: 1e-9
      rho_error: 1e-3
      gravity: {value: 9.80665, unit: m/s^2}
      angle_range: pi/2
      angle_error: 1e-3
      vt_min: {value: 30, unit: m/s}
      vt_max: {value: 400, unit: m/s}
      z_min: {value: -500, unit: m}
      z_max: {value: 13000, unit: m}
      pressure_error: 1e-3
      power_error: 1e-3
      slope_error: 1e-3
    inputs: {x: {shape: [N, 4]}, u: {shape: [N - 1, 4]}, Theta: {shape: [N, 6]}, y: {shape: [N, 4]}, row: {shape: [N, 4]}}
    blocks: {step3: {step3: [x, u, Theta, y, row]}}
    outputs: [step3.x, step3.u]
    """


@dataclass(frozen=True)
class Point:
    """One random window: what goes into Step 3."""

    x: Array
    u: Array
    Theta: Array
    y: Array
    row: Array


def random_point(random: np.random.Generator, wild: bool) -> Point:
    """A window; the wild ones lie anywhere between the bounds and a little beyond, with bad measurements."""
    t = TUNING
    x = t.x_lower + (t.x_upper - t.x_lower) * random.uniform(-0.02, 1.02, (3, 4))
    x[:, 1] = random.uniform(60, 340)
    if not wild:
        x = x[0] + random.normal(size=(3, 4)) * [0.002, 0.2, 0.3, 0.3]
    u = t.u_upper * random.uniform(-1.02, 1.02, (2, 4)) * (1.0 if wild else 0.2)
    columns = [x[:, 1], random.uniform(-0.2, 0.3, 3), random.normal(0, 0.02, 3), random.normal(1, 1, 3)]
    columns += [random.normal(-9.8, 0.5, 3), np.full(3, random.uniform(0, 12000))]
    theta = np.stack(columns, axis=1)
    noise = random.normal(size=(3, 4)) * [0.2, 0.45, 0.004, 0.4] * (5.0 if wild else 1.0)
    row = (random.uniform(size=(3, 4)) > 0.1).astype(float)
    return Point(x, u, theta, output(x, theta, t)[0] + noise, row)


def solved(point: Point) -> tuple[QuadraticProgram, list[Iteration]]:
    method = cmhe_fte.METHOD
    x, u = saturate(point.x, *method.x_limits(TUNING)), saturate(point.u, *method.u_limits(TUNING))
    qp = linearise(x, u, Window(point.Theta, point.y, point.row), TUNING)
    return qp, interior_point(qp, TUNING)


def test_every_interior_point_step(tmp_path: Path) -> None:
    """The quantities of (42), every search direction and every step length, at points where many bounds are active."""
    given = {"P": TUNING.P, "Q": TUNING.Q, "R": TUNING.R, "x_min": TUNING.x_lower, "x_max": TUNING.x_upper}
    given |= {"u_min": TUNING.u_lower, "u_max": TUNING.u_upper}
    passes = range(4)
    probes = [f"step3.qp.{name}" for name in ("A", "C", "f", "r_y")]
    probes += [f"step3.ip[{j}].{name}" for j in passes for name in ("direction_x", "direction_u", "s", "dx", "du")]
    sheet = sheet_of(tmp_path, STEP3, "root", **{name: value.tolist() for name, value in given.items()})
    random = np.random.default_rng(7)
    points = [random_point(random, wild=k % 2 == 0) for k in range(60)]
    inputs = {f.name: np.array([getattr(p, f.name) for p in points]) for f in fields(Point)}
    found = sheet.simulator(exact=True, probes=probes).run(inputs)

    references = [solved(point) for point in points]
    for name in ("A", "C", "f", "r_y"):
        expected = np.array([getattr(qp, name) for qp, _ in references])
        np.testing.assert_allclose(found[f"step3.qp.{name}"], expected, rtol=1e-12, atol=1e-11)
    steps = np.array([[i.s for i in iterations] for _, iterations in references])
    assert len(np.unique(steps)) > 4
    scales = {"x": np.sqrt(TUNING.P), "u": np.sqrt(TUNING.Q)}
    for j in passes:
        np.testing.assert_array_equal(found[f"step3.ip[{j}].s"], steps[:, j])
        for letter, scale in scales.items():
            for name in (f"direction_{letter}", f"d{letter}"):
                expected = np.array([getattr(iterations[j], name) for _, iterations in references])
                error = np.abs(found[f"step3.ip[{j}].{name}"] - expected) / np.maximum(np.abs(expected), scale)
                assert error.max() < 1e-10, (j, name)
