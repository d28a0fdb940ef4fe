"""The extended Kalman filter that paper 003 compares with, in the textbook's form.

Q^-1 and W^-1 are the covariances (5.2), M^-1 that of the start. Update by the Joseph form, prediction by the Jacobian
at the updated estimate. Its memory is the prediction for the coming frame.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from verification.reference.arrays import Array, saturate
from verification.reference.mho.inputs import Conditioned, condition
from verification.reference.mho.model import f, f_jacobian, first_state, h, h_jacobian
from verification.reference.mho.recording import frames
from verification.reference.mho.tuning import MhoTuning


@dataclass(frozen=True)
class State:
    """Everything remembered from one frame to the next."""

    held: Array  # (6,)
    started: bool
    x: Array  # (3,): x_k|k-1
    P: Array  # (3, 3): its covariance


@dataclass(frozen=True)
class Step:
    """What one frame gives."""

    inputs: Conditioned
    x_prior: Array  # (3,): x_k|k-1, limited, or what was loaded
    P_prior: Array  # (3, 3)
    x: Array  # (3,): x_k|k
    P: Array  # (3, 3)
    state: State


def initial_state(tuning: MhoTuning) -> State:
    """Return the memory before the first frame."""
    return State(tuning.nominal, False, np.zeros(3), np.zeros((3, 3)))


def step(state: State, inputs: Array, tuning: MhoTuning) -> Step:
    """Run one frame; `inputs` (6,) in the order of `inputs.PORTS`."""
    now, started = condition(inputs, state.held, state.started, tuning)
    x_prior, P_prior = state.x, state.P
    if now.load:
        x_prior, P_prior = first_state(now.y), np.diag(1.0 / tuning.M)
    x_prior = saturate(x_prior, *tuning.x_limits)

    C, noise = h_jacobian(x_prior, tuning), np.diag(1.0 / tuning.W)
    K = np.linalg.solve(C @ P_prior @ C.T + noise, C @ P_prior).T
    x = x_prior + K @ (now.y - h(x_prior, tuning))
    without = np.eye(3) - K @ C
    P = without @ P_prior @ without.T + K @ noise @ K.T

    A = f_jacobian(x, now.u, tuning)
    following = State(now.held, started, f(x, now.u, tuning), A @ P @ A.T + np.diag(1.0 / tuning.Q))
    return Step(now, x_prior, P_prior, x, P, following)


def steps(recording: Mapping[str, npt.ArrayLike], tuning: MhoTuning) -> Iterator[Step]:
    """Run a recording, frame by frame."""
    state = initial_state(tuning)
    for inputs in frames(recording):
        done = step(state, inputs, tuning)
        state = done.state
        yield done


def run(recording: Mapping[str, npt.ArrayLike], tuning: MhoTuning) -> dict[str, Array]:
    """Run a recording; return alpha_hat [rad], vt_hat [kt] and theta_hat [rad], one row a frame."""
    x = np.array([done.x for done in steps(recording, tuning)])
    return {"alpha_hat": x[:, 0], "vt_hat": x[:, 1], "theta_hat": x[:, 2]}
