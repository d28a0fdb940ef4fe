"""Flights drawn by seed: their winds and speeds keep to the stated ranges, and what is recorded is measured."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from saoflow import DiagnosisError
from verification.flights.drawn import draw_flight, holdable, measure_wind, random_plan
from verification.flights.plan import Turbulence
from verification.recordings import Recording


def winds(plan) -> np.ndarray:
    """Tail and down wind of the plan [kt], every 0.048 s, at the starting height (frames, 2)."""
    times = np.arange(0.0, plan.duration_s, 0.048)
    parts = [w for w in plan.wind if not isinstance(w, Turbulence)]
    return np.array([np.sum([w.wind_kt(t, plan.altitude_ft) for w in parts], axis=0)[[0, 2]] for t in times])


@pytest.mark.parametrize("seed", range(12))
def test_winds_inside_the_bounds(seed: int) -> None:
    plan = random_plan((seed,), 300.0)
    found = winds(plan)
    # a shear adds up to 9 kt where the flight climbs
    assert np.abs(found[:, 0]).max() <= 45.1 and np.abs(found[:, 1]).max() <= 24.1
    assert np.abs(np.diff(found, axis=0)).max() / 0.048 <= 12.1
    low, high = holdable(plan.altitude_ft)
    assert low <= plan.cas_kt <= high and 3000.0 <= plan.altitude_ft <= 36000.0
    starts = [m.start_s for m in plan.manoeuvre]
    assert len(starts) >= 4 and all(b - a >= 5.0 for a, b in pairwise(starts)) and starts[-1] < 300.0


def test_winds_beyond_the_bounds() -> None:
    beyond = 0
    for seed in range(12):
        plan = random_plan((seed,), 120.0, inside=False)
        found = winds(plan)
        rate = np.abs(np.diff(found, axis=0)).max() / 0.048
        beyond += np.abs(found[:, 0]).max() > 60.0 or rate > 15.0 or any(isinstance(w, Turbulence) for w in plan.wind)
    assert beyond == 12


def test_the_same_seed_draws_the_same_flight() -> None:
    assert random_plan((1, 2), 100.0) == random_plan((1, 2), 100.0)
    plans = [random_plan((1, i), 100.0) for i in range(20)]
    assert len({p.cas_kt for p in plans}) == 20 and {p.aircraft for p in plans} == {"A320", "787-8"}


def test_a_speed_that_nothing_holds() -> None:
    with pytest.raises(DiagnosisError, match="E705"):
        random_plan((1,), 60.0, cas=(390.0, 400.0), altitude=(30000.0, 36000.0))


@pytest.mark.parametrize("inside", [True, False])
def test_what_is_recorded_is_as_asked(inside: bool) -> None:
    pytest.importorskip("jsbsim")
    plan, truth = draw_flight((5, 1), 21.0, inside)
    assert measure_wind(truth).inside == inside
    assert len(truth) == round(21.0 / 0.048) + 1 and plan.duration_s == 21.0


def test_wind_is_measured_sample_by_sample() -> None:
    wx = np.array([10.0, 10.5, 59.0, 59.0])
    wz = np.array([-29.0, -28.0, -28.5, 30.0])
    found = measure_wind(Recording(("wx_true", "wz_true"), (wx, wz), 5.0))
    assert (found.wx, found.wz) == (59.0, 30.0) and found.rate == pytest.approx(58.5 / 5.0)
    assert found.inside
    assert not measure_wind(Recording(("wx_true", "wz_true"), (wx, wz), 3.0)).inside
    assert not measure_wind(Recording(("wx_true", "wz_true"), (wx * 1.02, wz), 5.0)).inside
