"""The metrics against numbers worked out by hand from a table of runs."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from verification.campaigns.metrics import metrics_of
from verification.campaigns.row import NAN, NEVER, Row

RUN = Row(
    0, "s", "r", "f", "A320", 0, 1250, 0.05, 1, "", wind_inside=True,
    alpha_error_max=1.0, alpha_error_mean=0.1, vc_error_max=4.0, vc_error_mean=0.4,
)  # fmt: skip
QUIET = [
    RUN,
    replace(RUN, alpha_error_max=2.0, alpha_error_mean=0.3),
    replace(RUN, vc_confirmed_2=100),  # a false alarm
    replace(RUN, wind_inside=False, alpha_confirmed_1=7, vc_confirmed_1=8),  # beyond the bounds: apart
]
ONE = replace(RUN, category="I", alpha_kind="bias", alpha_faulty="2", alpha_onset=200, alpha_detectable=True)
TWO = replace(
    RUN, category="III", vc_kind="runaway", vc_faulty="123", vc_onset=200, vc_rate=-10.5, vc_detectable=True,
    alpha_kind="noise", alpha_faulty="13", alpha_onset=300, vc_error_mean_lost=20.0, vc_error_max_lost=50.0,
)  # fmt: skip
FAULTY = [
    # found after 10 frames
    replace(ONE, alpha_confirmed_2=210),
    # missed, though it had to be found
    ONE,
    # found after 30 frames; a healthy one, too
    replace(ONE, alpha_confirmed_2=230, alpha_confirmed_3=900),
    # confirmed before its fault: wrong, and missed
    replace(ONE, alpha_confirmed_2=150),
    # V_c found with the last sensor, after 60 frames; one of two noisy AOA sensors missed
    replace(TWO, vc_confirmed_1=240, vc_confirmed_2=260, vc_confirmed_3=250, alpha_confirmed_1=310),
    # V_c: one of three missed; AOA found after 20 frames
    replace(
        TWO, vc_confirmed_1=240, vc_confirmed_2=260, alpha_confirmed_1=310, alpha_confirmed_3=320, alpha_error_max=9.0
    ),
    replace(ONE, failure="it would not fly"),
]


@pytest.fixture
def sheet():
    (found,) = metrics_of([*QUIET, *FAULTY])
    return found


def test_false_alarms(sheet):
    assert (sheet.fault_free.runs, sheet.fault_free.alpha.wrong, sheet.fault_free.vc.wrong) == (3, 0, 1)
    beyond = sheet.fault_free_beyond
    assert (beyond.runs, beyond.alpha.wrong, beyond.vc.wrong) == (1, 1, 1)


def test_missed_and_wrong(sheet):
    assert (sheet.faulty.runs, sheet.faulty.failed) == (6, 1)
    assert (sheet.faulty.alpha.hit, sheet.faulty.alpha.missed, sheet.faulty.alpha.wrong) == (6, 3, 2)
    assert (sheet.faulty.alpha.detectable, sheet.faulty.alpha.detectable_missed) == (4, 2)
    assert (sheet.faulty.vc.hit, sheet.faulty.vc.missed, sheet.faulty.vc.wrong) == (2, 1, 0)


def test_delays(sheet):
    alpha, vc = sheet.faulty.alpha.delay, sheet.faulty.vc.delay
    assert alpha.count == 3
    assert alpha.largest == pytest.approx(1.5) and alpha.mean == pytest.approx((0.5 + 1.5 + 1.0) / 3)
    assert vc.count == 1 and vc.largest == vc.mean == pytest.approx(3.0)
    # noise is no fast fault, a runaway of 10.5 kt/s is
    assert sheet.faulty.alpha.fast_delay.mean == pytest.approx(1.0)
    assert sheet.faulty.vc.fast_delay.count == 1


def test_errors(sheet):
    assert sheet.fault_free.alpha.error == (2.0, pytest.approx(0.5 / 3))
    assert sheet.faulty.alpha.error == (9.0, pytest.approx(0.1))
    # categories III and IV are left out of the airspeed
    assert sheet.faulty.vc.error == (4.0, pytest.approx(0.4))
    assert sheet.faulty.vc.error_lost == (50.0, 20.0)
    third = sheet.categories[2]
    assert third.runs == 2 and math.isnan(third.vc.error[0])


def test_groups(sheet):
    assert [group.runs for group in sheet.categories] == [4, 0, 2, 0]
    kinds = {group.name: group for group in sheet.kinds}
    assert kinds["bias alpha"].runs == 4 and kinds["bias alpha"].failed == 1
    assert kinds["runaway vc"].vc.missed == 1 and kinds["noise alpha"].alpha.missed == 1
    assert kinds["jamming vc"].runs == 0
    assert sheet.failures == ((0, "it would not fly"),)


def test_one_frame_is_not_before_the_onset():
    row = replace(ONE, alpha_confirmed_2=200)
    assert row.delay("alpha") == 0.0 and not row.wrong("alpha")
    row = replace(ONE, alpha_confirmed_2=199)
    assert math.isnan(row.delay("alpha")) and row.wrong("alpha") and row.detected_at("alpha") == NEVER


def test_nan_is_no_value():
    (found,) = metrics_of([replace(RUN, alpha_error_max=NAN, alpha_error_mean=NAN), RUN])
    assert found.fault_free.alpha.error == (1.0, 0.1)
