"""CMHE-FTE: fault-tolerant air data estimation by constrained moving horizon estimation, paper 004.

Wan, Keviczky: Real-time fault-tolerant moving horizon air data estimation for the RECONFIGURE benchmark,
IEEE Transactions on Control Systems Technology 27 (2019). Exact functions, where the sheets have tables.
`docs/corrections.md` says where the paper is corrected and what it leaves open.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy.typing as npt

from verification.reference import estimator
from verification.reference.arrays import Array
from verification.reference.estimator import Method, State, Step, initial_state
from verification.reference.inputs import Inputs
from verification.reference.interior_point import interior_point
from verification.reference.tuning import Tuning

__all__ = ["METHOD", "Inputs", "State", "Step", "Tuning", "initial_state", "run", "step"]


def _inside(lower: Array, upper: Array, fraction: float) -> tuple[Array, Array]:
    margin = fraction * (upper - lower)
    return lower + margin, upper - margin


METHOD = Method(
    solve=interior_point,
    x_limits=lambda tuning: _inside(tuning.x_lower, tuning.x_upper, tuning.clip_margin),
    u_limits=lambda tuning: _inside(tuning.u_lower, tuning.u_upper, tuning.clip_margin),
    wind_limits=lambda tuning: (tuning.wx_max, tuning.wz_max),
)
"""Algorithm 1; the warm start is clipped strictly inside the bounds, or whole runs freeze with steps zero."""


def step(state: State, inputs: Inputs, tuning: Tuning) -> Step:
    """Run one frame of CMHE-FTE."""
    return estimator.step(state, inputs, tuning, METHOD)


def run(recording: Mapping[str, npt.ArrayLike], tuning: Tuning | None = None) -> dict[str, Array]:
    """Run CMHE-FTE over a recording: see `estimator.run`."""
    return estimator.run(recording, tuning or Tuning(), METHOD)
