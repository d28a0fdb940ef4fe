"""The verifier on a small sheet: it agrees where the two sides agree, and finds every planted difference."""

from __future__ import annotations

import io
import json
from dataclasses import replace
from functools import partial
from pathlib import Path

import lag_reference
import numpy as np
import pytest
from rich.console import Console

from saoflow import load
from verification.verifier import Choice, ClosedLoop, Compared, FunctionReference, verify
from verification.verifier.comparison import relative_difference
from verification.verifier.printing import print_report

LAG = str(Path(__file__).with_name("lag.yaml"))


def check(report, quantity):
    (found,) = (c for c in report.checks if c.quantity == quantity and c.part == "frame")
    return found


def test_a_right_sheet_passes_and_every_frame_is_compared():
    report = verify(LAG, lag_reference.case, frames=200)
    assert report.passed, report.summary
    assert check(report, "y").frames == 400
    assert check(report, "remembered").frames == 398  # the state after a run's last frame is never seen
    assert report.failures == ()


def test_a_changed_parameter_is_found_where_it_acts():
    report = verify(load(LAG, parameters={"share": 0.2500001}), lag_reference.case, frames=50)
    assert not report.passed
    assert check(report, "way").passed  # the sheet's state is the reference's too: what lies before is right
    assert not check(report, "y").passed
    assert "first in the order of the frame: y, wire y, at " in report.summary
    where = check(report, "y").where
    got = load(LAG, parameters={"share": 0.2500001}).simulator(exact=True).run(scenario(report, 50, where).inputs)
    assert got["y"][where.frame][where.element] == where.sheet
    assert where.recording_frame == where.frame + (100 if where.scenario == "slow" else 0)


def scenario(report, frames, where):
    return next(s for s in lag_reference.scenarios(frames, report.seed) if s.name == where.scenario)


@pytest.mark.parametrize(
    ("old", "new", "first"),
    [
        ("way: {add: [bent, -before]}", "way: {add: [bent, before]}", "way"),
        ("function: sin", "function: cos", "way"),
        ("{saturation: u, low: -5, high: 5}", "{saturation: u, low: -1, high: 5}", "way"),
        ("y: {add: [before, part]}", "y: {add: [before, -part]}", "y"),
        ("before: {delay: y, initial", "before: {delay: way, initial", "remembered"),
        ("values: [1, 0.5]", "values: [1, 0.25]", "frames with another choice"),
        ('relation: ">"', 'relation: "<"', "latched"),
    ],
)
def test_planted_defects_are_found_at_the_first_wire_that_is_wrong(tmp_path, old, new, first):
    text = Path(LAG).read_text(encoding="utf-8")
    assert old in text
    path = tmp_path / "lag.yaml"
    path.write_text(text.replace(old, new), encoding="utf-8")
    report = verify(str(path), lag_reference.case, frames=100)
    assert not report.passed
    assert report.failures[0].quantity == first


def test_a_choice_that_rounding_decides_is_listed_and_what_depends_on_it_left_out():
    # The reference's margin is made to vanish in one frame, in which its step is made to differ.
    def expect(state, inputs, margin):
        right = lag_reference.expect(state, inputs)
        if state["before"][0] == 0.0:
            return replace(
                right,
                values=right.values | {"y": np.array([9.0, 9.0])},
                choices={"step": 0.75 * right.choices["step"]},
                margins={"step": margin},
            )
        return right

    near = lag_reference.case_with(expect=partial(expect, margin=5e-13), closed_loop=None)
    report = verify(LAG, near, frames=1000)
    assert report.passed, report.summary
    assert [(other.where.frame, other.excused) for other in report.other_choices] == [(0, True)] * 2
    assert check(report, "y").frames == 1998
    far = lag_reference.case_with(expect=partial(expect, margin=2e-12), closed_loop=None)
    assert not verify(LAG, far, frames=1000).passed
    assert not verify(LAG, near, frames=10).passed  # 2 in 20 frames are too many


def test_a_quantity_that_is_never_compared_does_not_pass():
    never = lag_reference.case_with(
        compared=(Compared("y", "y", 1.0, after=2),), choices=(Choice("step", "step"),), closed_loop=None
    )
    report = verify(LAG, never, frames=20)
    assert not report.passed


def test_closed_loop_limits_hold_in_fault_free_runs_alone():
    def shifted(inputs):
        right = lag_reference.run(inputs)
        return right | {"y": right["y"] + 0.002}

    loop = lag_reference.case.closed_loop
    off = ClosedLoop(shifted, loop.close, ())
    report = verify(LAG, lag_reference.case_with(closed_loop=off), frames=60)
    assert [c.quantity for c in report.failures] == ["y"]
    assert report.failures[0].where.scenario == "slow"


@pytest.mark.parametrize(("distance", "excused"), [(5e-4, True), (0.05, False)])
def test_a_decision_may_differ_only_near_its_threshold(distance, excused):
    reached = float(load(LAG).simulator().run(lag_reference.scenarios(60, 1)[1].inputs)["y"][:, 0].max())
    loop = lag_reference.case.closed_loop
    # The sheet latches at reached - distance / 2; the reference, with its threshold above, never does.
    sheet = load(LAG, parameters={"high": reached - distance / 2})
    run = partial(lag_reference.run, high=reached + distance / 2)
    decision = replace(loop.decisions[0], threshold=reached + distance / 2)
    only_slow = lag_reference.case_with(
        scenarios=lambda frames, seed: lag_reference.scenarios(frames, seed)[1:],
        closed_loop=ClosedLoop(run, loop.close, (decision,)),
    )
    report = verify(sheet, only_slow, frames=60)
    assert [other.excused for other in report.other_decisions] == [excused]
    assert report.passed is excused


def test_a_plain_function_is_a_reference_too():
    report = verify(LAG, FunctionReference(lag_reference.run), frames=120)
    assert report.passed, report.summary
    parts = {c.part for c in report.checks}
    assert parts == {"run, exact functions", "run, tables"}
    wrong = verify(LAG, FunctionReference(partial(lag_reference.run, share=0.26)), frames=120)
    assert not wrong.passed
    assert wrong.failures[0].quantity == "y"


def test_tables_are_listed_with_their_proved_error():
    (error,) = verify(LAG, lag_reference.case, frames=5).tables
    assert error.name.startswith("sin")
    assert 0.0 < error.sampled <= error.proved <= 1e-4


def test_differences_of_special_values():
    nan, inf = np.nan, np.inf
    got = np.array([nan, inf, -inf, nan, 1.0, inf, 0.0, 1e-20])
    right = np.array([nan, inf, inf, 1.0, nan, 1.0, -0.0, 0.0])
    ratio = relative_difference(got, right, 1.0)
    np.testing.assert_array_equal(ratio, [0.0, 0.0, inf, inf, inf, inf, 0.0, 1e-20])
    assert relative_difference(np.array([3.0]), np.array([2.0]), 10.0)[0] == pytest.approx(0.1)


def test_the_report_prints_and_is_json():
    report = verify(load(LAG, parameters={"share": 0.5}), lag_reference.case, frames=30)
    console = Console(record=True, width=140, file=io.StringIO())
    print_report(report, console)
    text = console.export_text()
    assert "FAILS" in text and "tables against their functions" in text
    assert report.summary.split(":")[0] in text
    plain = json.loads(json.dumps(report.to_dict(), allow_nan=False))
    assert plain["passed"] is False
    assert plain["checks"][1]["where"]["sheet"] == check(report, "y").where.sheet
