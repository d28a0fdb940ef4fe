"""One frame of a moving horizon observer of paper 003: its three steps around a memory."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from verification.reference.arrays import Array, saturate
from verification.reference.mho.inputs import Conditioned, condition
from verification.reference.mho.model import first_state
from verification.reference.mho.recording import frames
from verification.reference.mho.tuning import MhoTuning
from verification.reference.mho.window import Solution, Window

Method = Callable[[Window, MhoTuning], Solution]
"""`mho_pe.mho_pe`, `mho_pe.mho_wod` or `mho_wd.mho_wd`."""


@dataclass(frozen=True)
class State:
    """Everything remembered from one frame to the next, oldest sample first."""

    held: Array  # (6,) last valid inputs
    started: bool
    y_past: Array  # (N, 3)
    u_past: Array  # (N, 3)
    x_prior: Array  # (3,): x*_k-N|k-1, before it is limited
    w_prior: Array  # (N, 3): w*_k-N|k-1 ... w*_k-2|k-1, 0


@dataclass(frozen=True)
class Step:
    """What one frame gives."""

    inputs: Conditioned
    window: Window
    solution: Solution
    state: State


def initial_state(tuning: MhoTuning) -> State:
    """Return the memory before the first frame; the frames up to the start load most of it."""
    zeros = np.zeros((tuning.N, 3))
    return State(tuning.nominal, False, zeros, zeros, np.zeros(3), zeros)


def step(state: State, inputs: Array, tuning: MhoTuning, method: Method) -> Step:
    """Run one frame; `inputs` (6,) in the order of `inputs.PORTS`."""
    now, started = condition(inputs, state.held, state.started, tuning)
    y, u = np.vstack([state.y_past, now.y]), np.vstack([state.u_past, now.u])
    x_prior, w_prior = state.x_prior, state.w_prior
    if now.load:  # the window holds the first sample throughout
        y, u = np.tile(now.y, (tuning.N + 1, 1)), np.tile(now.u, (tuning.N + 1, 1))
        x_prior, w_prior = first_state(now.y), np.zeros_like(w_prior)
    window = Window(
        y, u[:-1], saturate(x_prior, *tuning.x_limits), saturate(w_prior, -tuning.w_limit, tuning.w_limit)
    )
    solution = method(window, tuning)
    # Step (i) of the next frame, whose window begins one sample later. Correction: the guess is w*_k-N+1|k ...
    # w*_k-1|k and 0 for the new transition; the paper's list has one entry more, which does not exist.
    w_next = np.vstack([solution.w[1:], np.zeros(3)])
    following = State(now.held, started, y[1:], u[1:], solution.x[1], w_next)
    return Step(now, window, solution, following)


def steps(recording: Mapping[str, npt.ArrayLike], tuning: MhoTuning, method: Method) -> Iterator[Step]:
    """Run a recording, frame by frame."""
    state = initial_state(tuning)
    for inputs in frames(recording):
        done = step(state, inputs, tuning, method)
        state = done.state
        yield done


def run(recording: Mapping[str, npt.ArrayLike], tuning: MhoTuning, method: Method) -> dict[str, Array]:
    """Run a recording; return alpha_hat [rad], vt_hat [kt] and theta_hat [rad], one row a frame."""
    x = np.array([done.solution.x[-1] for done in steps(recording, tuning, method)])
    return {"alpha_hat": x[:, 0], "vt_hat": x[:, 1], "theta_hat": x[:, 2]}
