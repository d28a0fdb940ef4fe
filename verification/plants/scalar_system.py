"""The scalar system of paper 002 with its uniform measurement noise.

The paper's noise is "uniformly distributed with a variance of 0.1" and has a "mean value of 0.05"; both together would
be uniform on [-0.5, 0.6]. Uniform on [0, 0.1] has the mean, and gives the errors of Table I. The levels of u are not
given either, only that there are three in each second.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

T_S = 0.01
"""Sampling time [s]."""


@dataclass(frozen=True)
class ScalarSystem:
    """A run of x_(k+1) = x_k + T_s (-20 x_k^3 + 10 x_k^2 + u_k), y_k = x_k + v_k."""

    levels: tuple[float, ...] = (5.0, 10.0, 20.0)
    """The values of u during each second, one after the other; chosen: they give the ratios of Table I."""
    duration: float = 6.0
    """Length [s]; chosen: 600 samples, from which Table I's sum of errors of the biased stage follows."""
    x_0: float = 0.0
    """The true initial state."""
    noise: tuple[float, float] = (0.0, 0.1)
    """v is uniform between these."""

    @property
    def frames(self) -> int:
        """Number of samples."""
        return round(self.duration / T_S)

    def controls(self) -> Array:
        """u, (frames,)."""
        per_level = (np.arange(self.frames) * len(self.levels) * T_S + 1e-9) % len(self.levels)
        u: Array = np.array(self.levels)[per_level.astype(int)]
        return u

    def states(self) -> Array:
        """x, (frames,), exact but for rounding: the system has no disturbance."""
        x = np.empty(self.frames)
        x[0] = self.x_0
        u = self.controls()
        for k in range(self.frames - 1):
            x[k + 1] = x[k] + T_S * (-20.0 * x[k] ** 3 + 10.0 * x[k] ** 2 + u[k])
        return x

    def recording(self, seed: int) -> dict[str, Array]:
        """y, u and the true x_true, one row a frame, the same for the same seed."""
        x = self.states()
        v = np.random.default_rng([seed, 2]).uniform(*self.noise, self.frames)
        return {"y": x + v, "u": self.controls(), "x_true": x}


def absolute_error(estimates: Sequence[float] | Array, truth: Array) -> float:
    """Table I's measure: the sum of the absolute errors of all frames."""
    return float(np.abs(np.asarray(estimates) - truth).sum())
