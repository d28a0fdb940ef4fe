"""Every number of the reactor and of its estimators in one place, with its source or reason.

The paper gives the reactor's constants (two of them wrongly or not at all), N, P, x_bar_0 and the noises. Step, Q, R,
the set X and every number of an iteration are this project's choice.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from verification.reference.arrays import Array
from verification.reference.tuning import count, quantity

PAPER = "paper 001, V"
CHOSEN = "chosen: "


@dataclass(frozen=True)
class Tuning:
    """All parameters of the reactor and its estimators. `dataclasses.fields(Tuning)` carries source of each."""

    # The reactor
    theta: float = quantity(20.0, "1", "Hicks and Ray (1971); missing in paper 001")
    k_0: float = quantity(300.0, "1", PAPER)
    E_a: float = quantity(5.0, "1", PAPER)
    x_f: float = quantity(0.395, "1", PAPER)
    x_cw: float = quantity(0.38, "1", PAPER)
    alpha: float = quantity(1.95e-4, "1", "Hicks and Ray (1971); printed 1.95e4")
    h: float = quantity(0.5, "1", CHOSEN + "theta/40; plants/cstr.py says why")
    u_max: float = quantity(2000.0, "1", CHOSEN + "five times the flow of the set-points")

    # The estimator
    N: int = count(3, PAPER + ": transitions of the window, N + 1 samples")
    p: float = quantity(30.0, "1", PAPER + ": P = 30 I")
    x_bar_1: float = quantity(0.15, "1", PAPER + ": prediction of the first concentration")
    x_bar_2: float = quantity(0.15, "1", PAPER + ": prediction of the first temperature")
    sigma_w1: float = quantity(0.01, "1", PAPER + ": Q_11 = 1/sigma^2 is chosen")
    sigma_w2: float = quantity(0.05, "1", PAPER + ": Q_22 = 1/sigma^2 is chosen")
    sigma_y: float = quantity(0.0125, "1", PAPER + ": R = 1/sigma^2 is chosen")

    # The set X
    x1_min: float = quantity(0.0, "1", CHOSEN + "a concentration is not negative")
    x1_max: float = quantity(1.0, "1", CHOSEN + "the concentration of the feed")
    x2_min: float = quantity(0.1, "1", CHOSEN + "below any temperature, and below x_bar_0")
    x2_max: float = quantity(1.4, "1", CHOSEN + "x_f + 1: the feed, burnt without cooling")

    # Iterations
    n_GN: int = count(4, CHOSEN + "Gauss-Newton passes a frame")
    push_min: float = quantity(1e-6, "1", CHOSEN + "least gradient of J/2 that holds a component: above rounding")
    n_GN_first: int = count(10, CHOSEN + "the same without noises, where the passes are damped")
    damping: float = quantity(10.0, "1", CHOSEN + "without noises, added to the Hessian before the first pass")
    relax: float = quantity(0.1, "1", CHOSEN + "times the damping after a success; divides it after a failure")
    damping_min: float = quantity(1e-3, "1", CHOSEN + "far below P")
    damping_max: float = quantity(1e9, "1", CHOSEN + "stands still")
    J_margin: float = quantity(1e-9, "1", CHOSEN + "a cost counts as larger from this fraction on: above rounding")
    n_f: int = count(5, CHOSEN + "Newton passes of an implicit Euler step")
    optimal: float = quantity(1.0, "1", CHOSEN + "largest free element of the gradient of J/2 that counts as zero in (24)")

    @cached_property
    def P(self) -> Array:
        """Weight of the arrival cost (4), shape (2, 2)."""
        return self.p * np.eye(2)

    @cached_property
    def Q(self) -> Array:
        """Weight of the disturbances in (3), shape (2, 2): the inverse variances of the noise that acts."""
        return np.diag([self.sigma_w1**-2, self.sigma_w2**-2])

    @cached_property
    def R(self) -> float:
        """Weight of the output in (3): the inverse variance of the noise that acts."""
        return self.sigma_y**-2

    @cached_property
    def x_bar_0(self) -> Array:
        """A-priori prediction of the first state, shape (2,)."""
        return np.array([self.x_bar_1, self.x_bar_2])

    @cached_property
    def lower(self) -> Array:
        """Lower bounds of X, shape (2,)."""
        return np.array([self.x1_min, self.x2_min])

    @cached_property
    def upper(self) -> Array:
        """Upper bounds of X, shape (2,)."""
        return np.array([self.x1_max, self.x2_max])
