"""Flights side by side and one after the other give the same bits, also when they differ in length."""

from __future__ import annotations

from dataclasses import fields

import numpy as np

from verification.flights import load_recording, sensors
from verification.results import batch


def test_side_by_side_equals_one_after_the_other(monkeypatch):
    truth = load_recording("a320_wind_350kt_5000ft")
    flights = [sensors(truth.part(0.0, seconds), seed=1) for seconds in (4.0, 6.0)]
    one_by_one = batch.run_batch("umhe_fte", flights)
    monkeypatch.setattr(batch, "FEW", 0)
    for alone, beside in zip(one_by_one, batch.run_batch("umhe_fte", flights), strict=True):
        for field in fields(batch.Outcome):
            np.testing.assert_array_equal(getattr(alone, field.name), getattr(beside, field.name))
