"""No false alarm in fault-free flight: every shipped recording, through the sheet.

`python -m verification.results.false_alarms --all` does the same with three noise seeds and every flight of the catalogue.
"""

from __future__ import annotations

from verification.flights import FLIGHTS
from verification.results.false_alarms import BEYOND_BOUNDS, false_alarms, markdown, shipped


def test_no_healthy_sensor_is_condemned_on_any_shipped_flight():
    rows = false_alarms(shipped(), seeds=(1,))
    assert len(rows) == 6 and sum(row.frames for row in rows) > 12_000
    for row in rows:
        assert row.within_bounds
        assert row.false_alarms == 0, row
        # Not by luck: the residuals stay well below the thresholds of 2.9 deg and 12 kt.
        assert row.alpha_rms < 2.0 and row.vc_rms < 8.0, row
        # And the estimates are of use: better than the single sensor's noise of 0.2 deg and 0.78 kt allows alone
        # in calm air, and not lost in changing wind.
        assert row.alpha_error < 0.5 and row.vc_error < 1.5, row
    calm = next(row for row in rows if "calm" in row.flight)
    assert calm.alpha_error < 0.1 and calm.vc_error < 0.5
    assert markdown(rows).count("\n") == 7


def test_the_one_flight_beyond_the_bounds_is_marked():
    assert set(BEYOND_BOUNDS) < {plan.name for plan in FLIGHTS}
