"""The numbers of paper 002, section VI, and those chosen where it is silent."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Weights:
    """Weights of one estimator's cost; they are inverse variances, without a unit."""

    p: float
    """Arrival cost."""
    q: float
    """Input disturbance."""
    r: float
    """Output disturbance."""


@dataclass(frozen=True)
class Tuning:
    """Everything the estimators share."""

    n: int = 10
    """Samples of the window."""
    t_s: float = 0.01
    """Sampling time [s]."""
    first: Weights = Weights(0.01, 0.01, 1.0)
    """The convexified stage."""
    second: Weights = Weights(0.1, 1e-4, 1e-5)
    """The linearised stage, and the nonlinear estimator."""
    low: float = -1.0
    """Least state."""
    high: float = 2.0
    """Largest state."""
    guess: float = 0.0
    """State at the first sample, as the estimators believe: the paper's true one; -1 is its wrong one."""
    passes: int = 4
    """Active-set passes of one quadratic program; chosen."""
    iterations: int = 3
    """Linearisations of the nonlinear problem in a frame; chosen."""


PAPER = Tuning()
"""The paper's numbers."""
