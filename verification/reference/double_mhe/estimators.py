"""The four estimators of paper 002 over whole runs: what the sheets of the same names must give."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from verification.reference.double_mhe.model import Array, Window, convexified, f, linearised
from verification.reference.double_mhe.quadratic_program import estimate
from verification.reference.double_mhe.tuning import PAPER, Tuning

Estimator = Callable[[Window, Array, Tuning], Array]
"""From a window and its warm start (n,) to the estimates of its samples (n,)."""


def convexified_stage(window: Window, warm: Array, tuning: Tuning) -> Array:
    """The first stage: (4) with the model (2). It needs no warm start."""
    return estimate(convexified(window, tuning.t_s), window, tuning.first, tuning)


def linearised_stage(window: Window, x_bar: Array, tuning: Tuning) -> Array:
    """The second stage: (4) with the model (3) about the first stage's estimates, which are its arrival state too."""
    about = Window(window.y, window.u, float(x_bar[0]))
    return estimate(linearised(about, x_bar, tuning.t_s), about, tuning.second, tuning)


def nonlinear(window: Window, warm: Array, tuning: Tuning) -> Array:
    """(4) with the model (1): linearise about the last estimates and solve, a fixed number of times."""
    x = warm
    for _ in range(tuning.iterations):
        x = estimate(linearised(window, x, tuning.t_s), window, tuning.second, tuning)
    return x


def over_run(y: Array, u: Array, estimator: Estimator, tuning: Tuning) -> list[tuple[Window, Array]]:
    """Every frame's window and estimates.

    The arrival state is the guess until a sample leaves the window, then the last frame's estimate of x_l. The warm
    start is the last frame's estimates, and the model's prediction of the newest sample.
    """
    frames: list[tuple[Window, Array]] = []
    warm, s = np.array([tuning.guess]), tuning.guess
    for k in range(len(y)):
        first = max(0, k - tuning.n + 1)
        if first > 0:
            warm = warm[1:]
            s = float(warm[0])
        window = Window(y[first : k + 1], u[first:k], s)
        x = estimator(window, warm, tuning)
        frames.append((window, x))
        warm = np.append(x, f(x[-1:], u[k : k + 1], tuning.t_s))
    return frames


def _padded(rows: list[Array], tuning: Tuning) -> Array:
    """One row a frame of N estimates; samples before the first one hold the guess."""
    return np.array([np.concatenate([np.full(tuning.n - len(row), tuning.guess), row]) for row in rows])


def run_convexified(inputs: Mapping[str, Array], tuning: Tuning = PAPER) -> dict[str, Array]:
    """What the sheet `convexified_mhe` gives for y and u."""
    x = _padded([x for _, x in over_run(inputs["y"], inputs["u"], convexified_stage, tuning)], tuning)
    return {"x_hat": x[:, -1], "x": x}


def run_double(inputs: Mapping[str, Array], tuning: Tuning = PAPER) -> dict[str, Array]:
    """What the sheet `double_mhe` gives."""
    frames = over_run(inputs["y"], inputs["u"], convexified_stage, tuning)
    x_bar = [x for _, x in frames]
    x = _padded([linearised_stage(window, bar, tuning) for window, bar in frames], tuning)
    return {"x_hat": x[:, -1], "x": x, "x_bar": _padded(x_bar, tuning)}


def run_nonlinear(inputs: Mapping[str, Array], tuning: Tuning = PAPER) -> dict[str, Array]:
    """What the sheet `nonlinear_mhe` gives."""
    x = _padded([x for _, x in over_run(inputs["y"], inputs["u"], nonlinear, tuning)], tuning)
    return {"x_hat": x[:, -1], "x": x}


def run_linearised(inputs: Mapping[str, Array], tuning: Tuning = PAPER) -> dict[str, Array]:
    """What the sheet `linearised_mhe` gives for windows y, u, present, x_bar; of a missing sample it is its x_bar."""
    rows = []
    for y, u, present, x_bar in zip(inputs["y"], inputs["u"], inputs["present"], inputs["x_bar"], strict=True):
        first = int(np.argmax(present > 0.5))
        window = Window(y[first:], u[first:], float(x_bar[first]))
        x = linearised_stage(window, x_bar[first:], tuning)
        rows.append(np.concatenate([np.clip(x_bar[:first], tuning.low, tuning.high), x]))
    return {"x": np.array(rows)}
