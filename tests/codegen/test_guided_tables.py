"""The guide of a table in compiled frames: it begins where the plain search would end, for every input, in both real types."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from saoflow.codegen.guide import guide_of


def found(x: np.ndarray, u: np.ndarray) -> np.ndarray:
    """The interval of each input by the guide, with the steps that the C takes."""
    guide = guide_of(x)
    assert guide is not None
    i = guide.first[guide.bucket(u)]
    padded = np.append(x, np.full(2 * len(x), np.inf))
    for half in [1 << k for k in reversed(range(guide.steps))]:
        i = np.where(padded[i + half] <= u, i + half, i)
    return np.asarray(i)


@pytest.mark.parametrize("real", [np.float64, np.float32])
@settings(max_examples=150, deadline=None)
@given(st.integers(0, 2**32), st.integers(20, 500), st.floats(0.2, 3.0), st.floats(-1e6, 1e6))
def test_guided_search_finds_what_bisection_finds(
    real: type[np.floating], seed: int, points: int, power: float, offset: float
) -> None:
    rng = np.random.default_rng(seed)
    x = np.unique((offset + np.abs(rng.normal(size=points)) ** power * 10.0 ** rng.integers(-3, 6)).astype(real))
    if x.size < 20 or guide_of(x) is None:
        return
    near = np.concatenate([x, np.nextafter(x, real(-np.inf)), np.nextafter(x, real(np.inf))])
    u = np.clip(np.concatenate([near, rng.uniform(x[0], x[-1], 500).astype(real)]), x[0], x[-1])
    assert np.array_equal(found(x, u), np.searchsorted(x, u, side="right") - 1)


def test_even_breakpoints_need_one_step() -> None:
    guide = guide_of(np.linspace(-3.0, 7.0, 400))
    assert guide is not None and guide.within == 1


@pytest.mark.parametrize("real", [np.float64, np.float32])
def test_breakpoints_that_crowd_at_the_lower_end_need_few_steps(real: type[np.floating]) -> None:
    """As those of a square root do; even buckets would leave nearly all in the first."""
    for low in (-2.0, 0.0, 1e-3):
        x = np.unique(real(low) + np.append(0.0, np.geomspace(1e-5, 10.0, 300)).astype(real))
        guide = guide_of(x)
        assert guide is not None and guide.steps <= 2 and guide.first.size < 2000
        u = np.clip(np.concatenate([x, np.nextafter(x, real(-9)), np.nextafter(x, real(99))]), x[0], x[-1])
        assert np.array_equal(found(x, u), np.searchsorted(x, u, side="right") - 1)


def test_breakpoints_that_a_guide_does_not_help_have_none() -> None:
    assert guide_of(np.array([0.0, 1.0, 2.0])) is None
    crowd = np.linspace(0.4, 0.4 + 1e-9, 200)
    assert guide_of(np.concatenate([[0.0], crowd, [1.0]])) is None
