"""What paper 001 prints wrongly: each printed form fails where the right one holds."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from cstr_independent import rates

from verification.plants.cstr import COOL, HOT, simulate
from verification.reference.cstr.estimator import ALGORITHM_1, ALGORITHM_2, frames
from verification.reference.cstr.reactor import right_hand_side
from verification.reference.cstr.sensitivity import PRINTED
from verification.reference.cstr.tuning import Tuning

TUNING = Tuning()


def test_the_printed_right_hand_sides_run_backwards():
    """From a set-point disturbed by a hundredth the reactor comes back; by the printed right-hand sides it leaves, as far
    as it would come from in reversed time."""

    def after(sign, seconds=30.0, dt=0.01):
        x = np.array([HOT.concentration + 0.01, HOT.temperature])
        for _ in range(int(seconds / dt)):
            x = x + dt * np.array(rates(x, HOT.flow, sign)).ravel()
            if not np.all(np.abs(x) < 10.0) or x[1] < 0.05:
                return np.inf
        return float(np.abs(x - [HOT.concentration, HOT.temperature]).max())

    assert after(1.0) < 0.01 < 0.02 < after(-1.0)
    # The two signs have eigenvalues of opposite sign: a stable focus and an unstable one
    J = np.array(
        [[(right_hand_side(np.array([HOT.concentration, HOT.temperature]) + e, HOT.flow, TUNING)
           - right_hand_side(np.array([HOT.concentration, HOT.temperature]) - e, HOT.flow, TUNING))[i] / 2e-6
          for e in 1e-6 * np.eye(2)] for i in range(2)]
    )
    assert np.linalg.eigvals(J).real.max() < 0.0 < np.linalg.eigvals(-J).real.min()


@pytest.mark.parametrize("point", [HOT, COOL])
def test_the_set_points_balance_only_with_alpha_and_theta_of_hicks_and_ray(point):
    x = np.array([point.concentration, point.temperature])

    def off(**change):
        return np.abs(right_hand_side(x, point.flow, replace(TUNING, **change))).max()

    assert off() < 2e-4  # the set-points have four digits
    assert off(alpha=1.95e4) > 1e6
    assert off(theta=19.0) > 1e-3 and off(theta=21.0) > 1e-3


def test_with_the_printed_sign_of_k_t_the_algorithm_is_pure_prediction():
    """Every update fails test (27) then; with the right sign nearly every one passes."""
    recording = simulate(3, steps=100).recording
    share = {}
    for sign in (1.0, PRINTED):
        made = [f.update for f in frames(recording, TUNING, replace(ALGORITHM_2, sign=sign))[TUNING.N + 1 :]]
        share[sign] = np.mean([m.accepted for m in made])
        if sign == PRINTED:
            assert all(np.array_equal(m.x, m.reference) for m in made if not m.accepted)
    assert share[1.0] > 0.95
    assert share[PRINTED] < 0.05


def test_the_eigenvalues_of_a_of_theorem_1_have_k_f():
    """0 and c1 p + c2 k_f p/(p + c3 delta); the printed one lacks k_f."""
    generator = np.random.default_rng(1)
    for c1, c2, c3, k_f, p, delta in generator.uniform(0.1, 3.0, (20, 6)):
        A = np.array([[c1 * p, c1 * k_f * p], [c2 * p / (p + c3 * delta), c2 * k_f * p / (p + c3 * delta)]])
        found = np.sort(np.linalg.eigvals(A).real)
        np.testing.assert_allclose(found, [0.0, c1 * p + c2 * k_f * p / (p + c3 * delta)], atol=1e-12)
        assert abs(found[1] - (c1 * p + c2 * p / (p + c3 * delta))) == pytest.approx(
            abs(c2 * (k_f - 1.0) * p / (p + c3 * delta)), rel=1e-9
        )


def test_there_are_no_estimates_before_t_is_n():
    """So the mean over t = 1 to 250 of the paper's "mean SSE" has no terms for t < N, and is a mean square error."""
    for method, first in ((ALGORITHM_1, TUNING.N), (ALGORITHM_2, TUNING.N + 1)):
        valid = [frame.valid for frame in frames(simulate(1, steps=8).recording, TUNING, method)]
        assert valid == [False] * first + [True] * (9 - first)
