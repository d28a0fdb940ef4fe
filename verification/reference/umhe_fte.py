"""UMHE-FTE: the same estimator without the inequality constraints, paper 004, IV-A and VI-A."""

from __future__ import annotations

from collections.abc import Mapping

import numpy.typing as npt

from verification.reference import estimator
from verification.reference.arrays import Array
from verification.reference.estimator import Method, State, Step, initial_state
from verification.reference.inputs import Inputs
from verification.reference.tuning import Tuning
from verification.reference.unconstrained import unconstrained

__all__ = ["METHOD", "Inputs", "State", "Step", "Tuning", "initial_state", "run", "step"]

METHOD = Method(
    solve=unconstrained,
    x_limits=lambda tuning: (tuning.umhe_x_lower, tuning.umhe_x_upper),
    u_limits=lambda tuning: (-tuning.umhe_u_upper, tuning.umhe_u_upper),
    wind_limits=lambda tuning: (tuning.umhe_w_out_max, tuning.umhe_w_out_max),
)
"""One exact step of (42) without bounds; the warm start keeps wide limits, so that no run diverges."""


def step(state: State, inputs: Inputs, tuning: Tuning) -> Step:
    """Run one frame of UMHE-FTE."""
    return estimator.step(state, inputs, tuning, METHOD)


def run(recording: Mapping[str, npt.ArrayLike], tuning: Tuning | None = None) -> dict[str, Array]:
    """Run UMHE-FTE over a recording: see `estimator.run`."""
    return estimator.run(recording, tuning or Tuning(), METHOD)
