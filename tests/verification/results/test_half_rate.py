"""Step 3 at half rate against the numpy reference at half rate, and what docs/multirate.md says of it."""

from __future__ import annotations

from dataclasses import fields, replace

import numpy as np
import pytest

import saoflow
from verification.flights import load_recording, sensors
from verification.reference.cmhe_fte import METHOD
from verification.reference.estimator import Outputs, initial_state, step
from verification.reference.inputs import frames
from verification.reference.interior_point import Iteration
from verification.reference.linearisation import QuadraticProgram
from verification.reference.tuning import Tuning
from verification.results.half_rate import variant


def at_rest(qp: QuadraticProgram, tuning: Tuning) -> list[Iteration]:
    """No step: the estimate is the warm start, limited."""
    x, u = np.zeros_like(qp.x), np.zeros_like(qp.u)
    return [Iteration(1.0, x, u, x, u, 0.0, 0.0, 1.0, x, u)]


@pytest.mark.parametrize("phase", [0, 1])
def test_the_variant_equals_the_reference_that_rests_every_second_frame(phase: int) -> None:
    inputs = sensors(load_recording("a320_wind_350kt_5000ft").part(0.0, 14.4), 2).inputs()
    tuning = Tuning()
    state, rows = initial_state(tuning), []
    for k, now in enumerate(frames(inputs)):
        done = step(state, now, tuning, METHOD if k % 2 == phase else replace(METHOD, solve=at_rest))
        state = done.state
        rows.append(done.outputs)
    with variant() as path:
        found = saoflow.load(str(path), parameters={"phase": phase}).simulator(exact=True).run(inputs)
    for field in fields(Outputs):
        expected = np.array([getattr(row, field.name) for row in rows])
        np.testing.assert_allclose(found[field.name], expected, rtol=1e-9, atol=1e-9 * np.abs(expected).max(), err_msg=field.name)


def test_two_channels_cost_little_more_than_one() -> None:
    one = saoflow.load("cmhe_fte").budget().total
    with variant() as path:
        half = saoflow.load(str(path)).budget()
        two = saoflow.load(str(path.with_name("two_channels.yaml"))).budget()
    assert half.frames[0] > one > half.frames[1] * 10
    assert two.frames == (two.total, two.total)
    assert two.total < 1.08 * one
