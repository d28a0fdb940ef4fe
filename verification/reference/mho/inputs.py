"""Step 0, before paper 003's: missing samples, and when an estimator starts.

The paper supposes that every sample arrives. Here an input outside its physical range (NaN and infinity are) keeps its
last valid value. The estimator starts at the first frame in which all inputs are valid.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from verification.reference.arrays import Array
from verification.reference.mho.tuning import MhoTuning

PORTS = ("vt", "vz", "theta", "q", "ax", "az")
"""The inputs of an estimator, in the order of `Conditioned.held`: kt, kt, rad, rad/s, kt/s^2, kt/s^2."""


@dataclass(frozen=True)
class Conditioned:
    """One frame of finite inputs."""

    held: Array  # (6,) the last valid inputs, in the order of PORTS
    load: bool  # this frame's sample fills the memory

    @property
    def y(self) -> Array:
        """Measured outputs V_t, V_z, theta, (3,)."""
        return self.held[:3]

    @property
    def u(self) -> Array:
        """Measured inputs A_x, A_z, q, (3,)."""
        return self.held[[4, 5, 3]]


def condition(inputs: Array, held: Array, started: bool, tuning: MhoTuning) -> tuple[Conditioned, bool]:
    """Return the conditioned inputs and whether the estimator has started; `inputs` (6,) in the order of PORTS."""
    low, high = tuning.input_range
    valid = (low <= inputs) & (inputs <= high)
    return Conditioned(np.where(valid, inputs, held), load=not started), started or bool(valid.all())
