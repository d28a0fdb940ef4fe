"""The scalar example of paper 002, its two linear models, and one window of data."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Window:
    """The samples l ... k that an estimator sees; as many as there are, at most N."""

    y: Array
    """Measurements, (n,)."""
    u: Array
    """Controls between them, (n - 1,)."""
    s: float
    """Arrival state s_l."""


@dataclass(frozen=True, eq=False)
class LinearModel:
    """x_(i+1) = A_i x_i + b_i and y_i = C_i x_i + d_i over a window: (4b), (4c) without disturbances."""

    a: Array  # (n - 1,)
    b: Array  # (n - 1,)
    c: Array  # (n,)
    d: Array  # (n,)


def f(x: Array, u: Array, t_s: float) -> Array:
    """(6a), with the u_k that is missing there in print."""
    return -20.0 * t_s * x**3 + 10.0 * t_s * x**2 + x + t_s * u


def slope(x: Array, t_s: float) -> Array:
    """A = df/dx, as the second stage's model in section VI has it."""
    return -60.0 * t_s * x**2 + 20.0 * t_s * x + 1.0


def convexified(window: Window, t_s: float) -> LinearModel:
    """(2) for the example: F_i = -20 T_s y_i^2 + 10 T_s y_i + 1, b_i = f(0, u_i), H_i = 1, h(0) = 0."""
    y = window.y[:-1]
    b = f(np.zeros(len(y)), window.u, t_s)
    return LinearModel(-20.0 * t_s * y**2 + 10.0 * t_s * y + 1.0, b, np.ones(len(window.y)), np.zeros(len(window.y)))


def linearised(window: Window, x_bar: Array, t_s: float) -> LinearModel:
    """(3) about ``x_bar`` (n,): b_i = f(x_bar_i, u_i) - A_i x_bar_i; h is the identity."""
    a = slope(x_bar[:-1], t_s)
    b = f(x_bar[:-1], window.u, t_s) - a * x_bar[:-1]
    return LinearModel(a, b, np.ones(len(window.y)), np.zeros(len(window.y)))
