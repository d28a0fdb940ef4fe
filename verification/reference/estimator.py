"""One frame of fault-tolerant estimation, Fig. 1 of paper 004: Steps 1 to 3 around a memory.

CMHE-FTE and UMHE-FTE share all of it but the `Method`: how the quadratic program is solved, where its
warm start is limited, and the bounds of the outputs.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields

import numpy as np
import numpy.typing as npt

from verification.reference.arrays import DEGREE, KNOT, Array, Mask, saturate
from verification.reference.conditioning import Conditioned, StartUp, condition, first_state, start_up
from verification.reference.fusion import Fused, fuse
from verification.reference.inputs import Inputs, frames
from verification.reference.interior_point import Iteration
from verification.reference.linearisation import QuadraticProgram, Window, linearise
from verification.reference.model import output, transition
from verification.reference.residuals import HeldWind, Judgement, hold_wind, judge
from verification.reference.tuning import Tuning

ALPHA_VC = np.array([2, 3])
"""Where alpha and V_c stand in y."""

WZ_WX = np.array([3, 2])
"""Where the winds stand in x that a common fault of the alpha or the V_c sensors looks like."""


@dataclass(frozen=True)
class Method:
    """What tells CMHE from UMHE."""

    solve: Callable[[QuadraticProgram, Tuning], list[Iteration]]
    x_limits: Callable[[Tuning], tuple[Array, Array]]  # of the warm start, (4,) each
    u_limits: Callable[[Tuning], tuple[Array, Array]]
    wind_limits: Callable[[Tuning], tuple[float, float]]  # of the outputs wx_hat, wz_hat, kt, either side


@dataclass(frozen=True)
class State:
    """Everything remembered from one frame to the next; SI but for `held`. Oldest sample first."""

    held: Array  # (7,) last valid vg, vz, theta, q, ax, az, z, in port units
    started: bool
    inhibit_count: int
    x_warm: Array  # (N, 4): x_{l|k-1} ... x_{k-1|k-1}, x_{k|k-1} for the coming frame k
    u_warm: Array  # (N - 1, 4): u_{l|k-1} ... u_{k-2|k-1}, and 0 for u_{k-1|k-1}
    theta_past: Array  # (N - 1, 6)
    y_past: Array  # (N - 1, 4)
    mask_past: Array  # (N - 1, 4): 1 where a measurement was present
    residuals: Array  # (N_eval - 1, 2, 3)
    squares_held: Array  # (N_eval - 1, 2, 3)
    bads: Mask  # (N_eval - 1, 2, 3)
    aparts: Mask  # (N_eval - 1, 2)
    rms_before: Array  # (2, 3), SI
    wind_held: Array  # (2,), W_z and W_x from before the sensors of alpha, V_c disagreed
    doubtful: Mask  # (2, 3)
    faulty: Mask  # (2, 3): confirmed alpha and V_c sensors

    @property
    def x_pred(self) -> Array:
        """x_{k|k-1}, shape (4,)."""
        predicted: Array = self.x_warm[-1]
        return predicted


@dataclass(frozen=True)
class Outputs:
    """One frame of outputs, named and measured as the ports of the sheet."""

    alpha_hat: float  # rad
    vc_hat: float  # kt
    wx_hat: float  # kt
    wz_hat: float  # kt
    alpha_pred: float  # rad
    vc_pred: float  # kt
    alpha_rms: Array  # (3,) rad
    vc_rms: Array  # (3,) kt
    alpha_faulty: Array  # (3,) 0 or 1
    vc_faulty: Array  # (3,) 0 or 1
    configuration: int  # 1 to 4


@dataclass(frozen=True)
class Trace:
    """What happened inside a frame."""

    inputs: Conditioned
    start_up: StartUp
    prediction: Array  # (2,) alpha and V_c, SI, before the saturation of the outputs
    wind_held: HeldWind
    held: Array  # (2,) the prediction with the wind from before
    judgement: Judgement
    fused: Fused
    window: Window
    qp: QuadraticProgram
    iterations: tuple[Iteration, ...]
    x: Array  # (N, 4), x_{i|k}
    u: Array  # (N - 1, 4), u_{i|k}


@dataclass(frozen=True)
class Step:
    """What one frame gives."""

    outputs: Outputs
    state: State
    trace: Trace


def initial_state(tuning: Tuning) -> State:
    """Return the memory before the first frame; the frames up to the start load most of it."""
    past = tuning.n_horizon - 1
    return State(
        held=tuning.inertial_nominal,
        started=False,
        inhibit_count=tuning.n_inhibit,
        x_warm=np.zeros((past + 1, 4)),
        u_warm=np.zeros((past, 4)),
        theta_past=np.zeros((past, 6)),
        y_past=np.zeros((past, 4)),
        mask_past=np.zeros((past, 4)),
        residuals=np.zeros((tuning.n_eval - 1, 2, 3)),
        squares_held=np.zeros((tuning.n_eval - 1, 2, 3)),
        bads=np.zeros((tuning.n_eval - 1, 2, 3), dtype=bool),
        aparts=np.zeros((tuning.n_eval - 1, 2), dtype=bool),
        rms_before=np.zeros((2, 3)),
        wind_held=np.zeros(2),
        doubtful=np.zeros((2, 3), dtype=bool),
        faulty=np.zeros((2, 3), dtype=bool),
    )


def step(state: State, inputs: Inputs, tuning: Tuning, method: Method) -> Step:
    """Run one frame."""
    # Step 0: missing samples, start-up
    now = condition(inputs, state.held, tuning)
    start = start_up(now, state.started, state.inhibit_count, state.faulty, tuning)
    x_warm, u_warm = state.x_warm, state.u_warm
    if start.load:
        x_warm, u_warm = np.tile(first_state(now, state.faulty), (len(x_warm), 1)), np.zeros_like(u_warm)

    # Step 1: residuals, their rms, fault decision
    prediction = output(x_warm[-1], now.theta, tuning)[0][ALPHA_VC]
    wind_held = hold_wind(
        now, x_warm[-1, WZ_WX], state.wind_held, state.aparts, state.doubtful, state.faulty, tuning
    )
    held = held_prediction(x_warm[-1], wind_held.wind, now.theta, tuning)
    judgement = judge(
        now,
        prediction,
        held,
        state.residuals,
        state.squares_held,
        state.rms_before,
        state.doubtful,
        state.bads,
        state.faulty,
        start.inhibit,
        tuning,
    )

    # Step 2: fusion
    fused = fuse(now, judgement, prediction, tuning)
    y = np.concatenate([now.inertial[:2], fused.value])
    present = np.concatenate([now.inertial_valid[:2], fused.present]).astype(float)

    # Step 3: estimation over the window, one SQP iteration
    mask = remember(present, state.mask_past, start.load)
    window = Window(
        theta=remember(now.theta, state.theta_past, start.load),
        y=remember(y, state.y_past, start.load),
        row_mask=mask * np.concatenate([[1.0, 1.0], ~fused.lost]),
    )
    qp = linearise(
        saturate(x_warm, *method.x_limits(tuning)), saturate(u_warm, *method.u_limits(tuning)), window, tuning
    )
    iterations = method.solve(qp, tuning)
    x, u = qp.x + iterations[-1].dx, qp.u + iterations[-1].du

    x_next = transition(x[-1], np.zeros(4), now.theta, tuning)  # x_{k+1|k}
    following = State(
        held=now.held,
        started=start.started,
        inhibit_count=start.inhibit_count,
        x_warm=np.vstack([x[1:], x_next]),
        u_warm=np.vstack([u[1:], np.zeros(4)]),
        theta_past=window.theta[1:],
        y_past=window.y[1:],
        mask_past=mask[1:],
        residuals=np.concatenate([state.residuals[1:], judgement.residual[None]]),
        squares_held=np.concatenate([state.squares_held[1:], judgement.square_held[None]]),
        bads=np.concatenate([state.bads[1:], judgement.bad[None]]),
        aparts=np.concatenate([state.aparts[1:], wind_held.apart[None]]),
        rms_before=judgement.rms,
        wind_held=wind_held.wind,
        doubtful=judgement.doubtful,
        faulty=judgement.faulty,
    )
    outputs = outputs_of(x[-1], now.theta, prediction, judgement, fused, tuning, method)
    trace = Trace(now, start, prediction, wind_held, held, judgement, fused, window, qp, tuple(iterations), x, u)
    return Step(outputs, following, trace)


def held_prediction(x: Array, wind: Array, theta: Array, tuning: Tuning) -> Array:
    """Return alpha and V_c as predicted, but with the winds `wind` (W_z for alpha, W_x for V_c), shape (2,).

    The inertial V_z of (15) ties alpha to W_z: with another wind the same V_z means another alpha.
    """
    w_z, w_x = wind
    alpha = x[0] - (w_z - x[3]) / theta[0]
    v_c = output(np.array([x[0], x[1], w_x, x[3]]), theta, tuning)[0][3]
    return np.array([alpha, v_c])


def remember(present: Array, past: Array, load: bool) -> Array:
    """Return the window that ends with the present sample; at a load it is the present sample throughout."""
    if load:
        return np.tile(present, (len(past) + 1, 1))
    return np.vstack([past, present])


def outputs_of(
    x: Array,
    theta: Array,
    prediction: Array,
    judgement: Judgement,
    fused: Fused,
    tuning: Tuning,
    method: Method,
) -> Outputs:
    """Return the outputs in port units, each inside its stated bounds."""
    alpha_low, alpha_high = tuning.alpha_min * DEGREE, tuning.alpha_max * DEGREE
    wx_limit, wz_limit = method.wind_limits(tuning)
    vc = output(x, theta, tuning)[0][3]

    def limited(value: float, low: float, high: float) -> float:
        return float(saturate(np.asarray(value), low, high))

    return Outputs(
        alpha_hat=limited(x[0], alpha_low, alpha_high),
        vc_hat=limited(vc / KNOT, 0.0, tuning.vc_out_max),
        wx_hat=limited(x[2] / KNOT, -wx_limit, wx_limit),
        wz_hat=limited(x[3] / KNOT, -wz_limit, wz_limit),
        alpha_pred=limited(prediction[0], alpha_low, alpha_high),
        vc_pred=limited(prediction[1] / KNOT, 0.0, tuning.vc_out_max),
        alpha_rms=saturate(judgement.rms[0], 0.0, tuning.alpha_rms_max * DEGREE),
        vc_rms=saturate(judgement.rms[1] / KNOT, 0.0, tuning.vc_rms_max),
        alpha_faulty=judgement.faulty[0].astype(float),
        vc_faulty=judgement.faulty[1].astype(float),
        configuration=fused.configuration,
    )


def run(recording: Mapping[str, npt.ArrayLike], tuning: Tuning, method: Method) -> dict[str, Array]:
    """Run a recording; return one array a name of `Outputs`, one row a frame.

    Raises:
        RecordingError: the recording lacks an input, or one has a wrong shape.
    """
    state = initial_state(tuning)
    rows: list[Outputs] = []
    for inputs in frames(recording):
        done = step(state, inputs, tuning, method)
        state = done.state
        rows.append(done.outputs)
    return {field.name: np.array([getattr(row, field.name) for row in rows]) for field in fields(Outputs)}
