"""Doubt: two sensors that are wrong alike do not get the healthy one condemned, and it is taken back when they are found."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from verification.flights import Fault, load_recording, sensors
from verification.reference import cmhe_fte
from verification.reference.arrays import KNOT, Array
from verification.reference.conditioning import Conditioned
from verification.reference.residuals import hold_wind
from verification.reference.tuning import Tuning

TUNING = Tuning()
AS_IN_THE_PAPER = replace(TUNING, doubt=0.0)


def fly(fault: Fault, tuning: Tuning, seconds: float, seed: int = 1) -> dict[str, Array]:
    truth = load_recording("a320_calm_350kt_5000ft").part(0.0, seconds)
    out = cmhe_fte.run(sensors(truth, seed, faults=[fault]).inputs(), tuning)
    return out | {"vc_error": out["vc_hat"] - truth["vc_true"]}


def test_two_that_drift_alike_are_found_and_the_third_is_kept() -> None:
    """At 2 kt/s they draw the wind to its bound, 60 kt later than they began; the third then carries the estimate."""
    fault = Fault("runaway", "vc", (2, 3), rate=2.0, onset=8.0)
    paper, ours = fly(fault, AS_IN_THE_PAPER, 48.0), fly(fault, TUNING, 48.0)
    assert paper["vc_faulty"][:, 0].any()
    assert ours["vc_faulty"].any(axis=0).tolist() == [False, True, True]
    found = int(ours["vc_faulty"].all(axis=1, where=[False, True, True]).argmax())
    assert np.abs(ours["vc_error"][found:]).max() > 20.0  # drawn away until then
    assert np.abs(ours["vc_error"][found + 60 :]).max() < 3.0  # 2.9 s later it is back
    assert np.abs(paper["vc_error"][found + 60 :]).max() > 30.0


@pytest.mark.parametrize("which", [(2,), (1, 3), (1, 2, 3)])
def test_a_jump_is_found_in_the_same_frame_with_doubt_and_without(which: tuple[int, ...]) -> None:
    fault = Fault("bias", "vc", which, amplitude=30.0, onset=5.0)
    paper, ours = fly(fault, AS_IN_THE_PAPER, 8.0), fly(fault, TUNING, 8.0)
    assert ours["vc_faulty"].any(axis=0).tolist() == [i in which for i in (1, 2, 3)]
    np.testing.assert_array_equal(ours["vc_faulty"], paper["vc_faulty"])


def conditioned(vc: list[float], valid: list[bool]) -> Conditioned:
    readings = np.array([[0.05, 0.05, 0.05], [v * KNOT for v in vc]])
    flags = np.array([[True] * 3, valid])
    seven = np.zeros(7)
    return Conditioned(np.where(flags, readings, 0.0), flags, seven, seven, np.ones(7, dtype=bool), True)


@pytest.mark.parametrize(
    ("vc", "valid", "faulty", "apart"),
    [
        ([250.0, 251.0, 253.9], [True, True, True], [False] * 3, False),
        ([250.0, 251.0, 254.1], [True, True, True], [False] * 3, True),
        ([250.0, 251.0, 254.1], [True, True, False], [False] * 3, False),
        ([250.0, 251.0, 254.1], [True, True, True], [False, False, True], False),
        ([250.0, 300.0, 350.0], [False, False, False], [False] * 3, False),
    ],
)
def test_sensors_in_use_are_compared(vc: list[float], valid: list[bool], faulty: list[bool], apart: bool) -> None:
    """4 kt apart; the wind is kept from the n_detect-th frame of it on, or while one is in doubt."""
    flags = np.array([[False] * 3, faulty])
    no_doubt = np.zeros((2, 3), dtype=bool)
    now, held, past = np.array([1.0, 2.0]), np.array([3.0, 4.0]), np.zeros((TUNING.n_eval - 1, 2), dtype=bool)
    found = hold_wind(conditioned(vc, valid), now, held, past, no_doubt, flags, TUNING)
    assert found.apart.tolist() == [False, apart]
    assert found.wind.tolist() == [1.0, 2.0]
    past[-TUNING.n_detect + 1 :, 1] = True
    found = hold_wind(conditioned(vc, valid), now, held, past, no_doubt, flags, TUNING)
    assert found.wind.tolist() == [1.0, 4.0 if apart else 2.0]
    no_doubt[1, 0] = True
    assert hold_wind(conditioned(vc, valid), now, held, past, no_doubt, flags, TUNING).wind.tolist() == [1.0, 4.0]
