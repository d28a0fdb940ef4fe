"""The table of passes of paper 001's estimators, shortened."""

from __future__ import annotations

import itertools

import numpy as np

from verification.plants.cstr import simulate
from verification.reference.cstr.estimator import ALGORITHM_1, frames
from verification.reference.cstr.tuning import Tuning
from verification.results.reactor_passes import METHODS, distances


def test_more_passes_come_nearer():
    for method, enough in zip(METHODS, (1e-3, 1e-3, 1e-3), strict=True):
        rows = distances(method, (1,), steps=20)
        assert [row.passes for row in rows] == list(method.counts)
        assert all(a.typical >= b.typical for a, b in itertools.pairwise(rows))
        assert rows[-1].largest < 1e-6 and rows[-1].lost == 0
        assert rows[3].largest < enough
        assert rows[3].epsilon < 1e-3 and rows[-1].epsilon <= rows[0].epsilon


def test_the_distance_is_that_of_the_sheets_passes():
    """The first window of a run, as the estimator solves it with 4 passes, against the same with 60."""
    made = simulate(1, steps=3)
    tuning = Tuning()
    found, right = (
        frames(made.recording, tuning_n, ALGORITHM_1)[-1].x for tuning_n in (tuning, Tuning(n_GN=60))
    )
    row = next(row for row in distances(METHODS[0], (1,), steps=3) if row.passes == tuning.n_GN)
    assert row.largest == np.abs(found - right).max()
