"""One frame of the estimators of paper 001, and a run over a recording.

Frame t takes the output y_t and the input u_{t-1} that acted since the last frame. There is no estimate for t < N, and
no update one step ahead for t = N.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from verification.reference.arrays import Array, saturate
from verification.reference.cstr.algorithm_1 import DampedPass, Pass, estimate, estimate_first
from verification.reference.cstr.reactor import step as predict
from verification.reference.cstr.sensitivity import Update, update, update_first
from verification.reference.cstr.tuning import Tuning
from verification.reference.cstr.window import Information


@dataclass(frozen=True)
class Method:
    """Which of the estimators."""

    noises: bool
    """With the second term of (3), so that noises are estimated."""
    ahead: bool
    """Algorithm 2; else Algorithm 1."""
    sign: float = 1.0
    """Of K_t; -1 is the printed one."""


ALGORITHM_1 = Method(noises=True, ahead=False)
ALGORITHM_1_WITHOUT = Method(noises=False, ahead=False)
ALGORITHM_2 = Method(noises=True, ahead=True)
ALGORITHM_2_WITHOUT = Method(noises=False, ahead=True)


@dataclass(frozen=True)
class State:
    """What a frame leaves to the next."""

    count: int  # frames before this one, at most N + 1
    y_past: Array  # (N + 1,), the oldest first; Algorithm 1 does without the oldest
    u_past: Array  # (N,)
    x: Array  # (N + 1, 2), last frame's window
    x_bar: Array  # (2,), the prediction it was estimated from


@dataclass(frozen=True)
class Frame:
    """One frame: its results, and what led to them."""

    state: State  # for the next frame
    valid: bool
    x_hat: Array  # (2,), the estimate of the present state
    warm: Array  # (N + 1, 2), what the passes start from
    x_bar: Array  # (2,)
    passes: tuple[Pass, ...] | tuple[DampedPass, ...]
    x: Array  # (N + 1, 2), Algorithm 1's estimates of the window
    update: Update | None  # Algorithm 2's


def initial_state(tuning: Tuning) -> State:
    """Return the state before the first frame."""
    n = tuning.N + 1
    return State(0, np.zeros(n), np.zeros(n - 1), np.zeros((n, 2)), np.zeros(2))


def step(state: State, y: float, u: float, tuning: Tuning, method: Method) -> Frame:
    """Run one frame with the output y and the input u since the last frame."""
    y_now = saturate(np.array([y]), tuning.x2_min, tuning.x2_max)
    u_now = saturate(np.array([u]), 0.0, tuning.u_max)
    first = state.count == 0
    y_all = np.tile(y_now, tuning.N + 2) if first else np.append(state.y_past, y_now)
    u_all = np.tile(u_now, tuning.N + 1) if first else np.append(state.u_past, u_now)
    starting = state.count <= tuning.N

    warm = np.vstack([state.x[1:], predict(state.x[-1], u_now[0], tuning)])
    if starting:
        warm = np.column_stack([np.full(tuning.N + 1, tuning.x_bar_1), y_all[1:]])
    x_bar = tuning.x_bar_0 if starting else state.x[1]
    given = Information(x_bar, y_all[1:], u_all[1:])
    passes: tuple[Pass, ...] | tuple[DampedPass, ...]
    if method.noises:
        steps = estimate(warm, given, tuning)
        passes, x = tuple(steps), steps[-1].x
    else:
        damped = estimate_first(warm[0], given, tuning)
        passes, x = tuple(damped), damped[-1].best.x

    updated = None
    if method.ahead:
        before = Information(state.x_bar, y_all, u_all)
        updated = (update if method.noises else update_first)(state.x, before, tuning, method.sign)
    x_hat = x[-1] if updated is None or starting else updated.x[-1]
    valid = state.count >= tuning.N + method.ahead
    following = State(min(state.count + 1, tuning.N + 1), y_all[1:], u_all[1:], x, x_bar)
    return Frame(following, valid, x_hat, warm, x_bar, passes, x, updated)


def frames(recording: Mapping[str, npt.ArrayLike], tuning: Tuning, method: Method) -> list[Frame]:
    """Run a recording of `y` and `u`, one row a frame (u: what acted since the last frame)."""
    y = np.asarray(recording["y"], dtype=np.float64)
    u = np.asarray(recording["u"], dtype=np.float64)
    state, done = initial_state(tuning), []
    for y_t, u_t in zip(y, u, strict=True):
        done.append(step(state, float(y_t), float(u_t), tuning, method))
        state = done[-1].state
    return done


def run(recording: Mapping[str, npt.ArrayLike], tuning: Tuning, method: Method) -> dict[str, Array]:
    """Run a recording; return the sheets' outputs that every method has, one row a frame."""
    done = frames(recording, tuning, method)
    return {
        "x_hat": np.array([frame.x_hat for frame in done]),
        "window": np.array([frame.x for frame in done]),
        "valid": np.array([float(frame.valid) for frame in done]),
    }
