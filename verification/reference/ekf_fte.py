"""EKF-FTE: the same scheme with an extended Kalman filter in Step 3, paper 004, VI-A.

Of the window only the newest sample is left; in place of the others the filter carries a covariance. Q and R are the
covariances of the unknown inputs and of the measurements, as the paper says for a fair comparison; P, the weight of the
arrival cost, is the covariance at the start. The filter is linearised at the prediction (outputs) and at the estimate
(motion).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields, replace

import numpy as np
import numpy.typing as npt

from verification.reference import estimator
from verification.reference.arrays import Array
from verification.reference.estimator import Method, Outputs
from verification.reference.inputs import Inputs, frames
from verification.reference.interior_point import Iteration
from verification.reference.linearisation import QuadraticProgram
from verification.reference.model import transition_jacobian
from verification.reference.tuning import Tuning

__all__ = ["METHOD", "Inputs", "State", "Step", "Tuning", "initial_state", "run", "step"]

METHOD = Method(
    solve=lambda qp, tuning: [_iteration(qp, np.zeros(4))],
    x_limits=lambda tuning: (tuning.umhe_x_lower, tuning.umhe_x_upper),
    u_limits=lambda tuning: (-tuning.umhe_u_upper, tuning.umhe_u_upper),
    wind_limits=lambda tuning: (tuning.umhe_w_out_max, tuning.umhe_w_out_max),
)
"""Limits as in UMHE; what it solves depends on the covariance, so every frame puts its own update in place."""


@dataclass(frozen=True)
class State:
    """Everything remembered from one frame to the next."""

    common: estimator.State  # the scheme's, with a window of one sample
    P: Array  # (4, 4), P_{k|k-1} for the coming frame k


@dataclass(frozen=True)
class Update:
    """The measurement update of one frame."""

    P_hat: Array  # (4, 4), P_{k|k-1}
    C: Array  # (4, 4), rows masked
    K: Array  # (4, 4)
    P_f: Array  # (4, 4), P_{k|k}


@dataclass(frozen=True)
class Step:
    """What one frame gives."""

    common: estimator.Step
    update: Update
    state: State

    @property
    def outputs(self) -> Outputs:
        """The outputs of the frame."""
        return self.common.outputs


def initial_state(tuning: Tuning) -> State:
    """Return the memory before the first frame; the frames up to the start load most of it."""
    return State(estimator.initial_state(one_sample(tuning)), np.zeros((4, 4)))


def one_sample(tuning: Tuning) -> Tuning:
    """Return the tuning with a window of one sample."""
    return replace(tuning, n_horizon=1)


def step(state: State, inputs: Inputs, tuning: Tuning) -> Step:
    """Run one frame of EKF-FTE."""
    P_hat = state.P
    variances = np.diag(P_hat)
    usual = np.all((variances >= 0.0) & (variances <= tuning.ekf_p_factor * tuning.P))
    if not state.common.started or not usual:  # the covariance starts anew
        P_hat = np.diag(tuning.P)
    found: list[Update] = []

    def solve(qp: QuadraticProgram, tuning: Tuning) -> list[Iteration]:
        update, dx = measurement_update(P_hat, qp.C[0], qp.r_y[0], tuning)
        found.append(update)
        return [_iteration(qp, dx)]

    common = estimator.step(state.common, inputs, one_sample(tuning), replace(METHOD, solve=solve))
    x, theta, P_f = common.trace.x[-1], common.trace.inputs.theta, found[0].P_f
    A = transition_jacobian(x, theta, tuning)
    P_next = A @ P_f @ A.T + np.diag(tuning.t_s**2 * tuning.Q)  # B = t_s I
    following = replace(common.state, u_warm=np.zeros((0, 4)))  # no unknown input is estimated
    return Step(common, found[0], State(following, P_next))


def measurement_update(P_hat: Array, C: Array, r_y: Array, tuning: Tuning) -> tuple[Update, Array]:
    """Return the textbook's gain and covariance, and the correction of the state, shape (4,)."""
    S = C @ P_hat @ C.T + np.diag(tuning.R)
    K = P_hat @ C.T @ np.linalg.inv(S)
    return Update(P_hat, C, K, P_hat - K @ C @ P_hat), K @ r_y


def _iteration(qp: QuadraticProgram, dx: Array) -> Iteration:
    """The update as the one step of an estimator: step length 1 and no margin to lose."""
    none = np.zeros_like(qp.u)
    return Iteration(0.0, np.zeros_like(qp.x), none, dx[None], none, 0.0, 1.0, np.inf, dx[None], none)


def run(recording: Mapping[str, npt.ArrayLike], tuning: Tuning | None = None) -> dict[str, Array]:
    """Run EKF-FTE over a recording; return one array a name of `Outputs`, one row a frame.

    Raises:
        RecordingError: the recording lacks an input, or one has a wrong shape.
    """
    tuning = tuning or Tuning()
    state = initial_state(tuning)
    rows: list[Outputs] = []
    for inputs in frames(recording):
        done = step(state, inputs, tuning)
        state = done.state
        rows.append(done.outputs)
    return {field.name: np.array([getattr(row, field.name) for row in rows]) for field in fields(Outputs)}
