"""The verification of paper 003's observers and filter: every output and what leads to it, from the sheet's own state."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import Generic, TypeVar

import numpy as np

from verification.reference.arrays import DEGREE, Array
from verification.reference.mho import ekf, estimator, fault_detection
from verification.reference.mho.estimator import Method
from verification.reference.mho.fault_detection import Detection
from verification.reference.mho.inputs import PORTS
from verification.reference.mho.mho_pe import mho_pe
from verification.reference.mho.tuning import MhoTuning
from verification.verifier.case import (
    TOLERANCE,
    ClosedLoop,
    Closeness,
    Compared,
    Decision,
    Expected,
    ReferenceCase,
    Values,
)
from verification.verifier.estimator_wires import taps
from verification.verifier.mho_scenarios import mho_scenarios

TABLES_ANGLE = 1e-3
"""How far the tables may move an angle in closed loop [deg]."""

TABLES_SPEED = 0.01
"""How far the tables may move an airspeed in closed loop [kt]."""

Step = TypeVar("Step")


@dataclass(frozen=True, eq=False)
class Quantity(Generic[Step]):
    """A compared quantity, how to take it from a frame of the reference, and, if remembered, its first value."""

    compared: Compared
    of_step: Callable[[Step], Array | float | bool]
    first: Array | float | None = None


@dataclass(frozen=True)
class Scales:
    """Sigma of everything: noise of Table I and what it makes of a state."""

    x: Array  # (3,)
    y: Array  # (3,)
    u: Array  # (3,)
    w: Array  # (3,)
    held: Array  # (6,)

    @staticmethod
    def of(tuning: MhoTuning) -> Scales:
        """The scales of a tuning."""
        angle, rate = tuning.noise_theta * DEGREE, tuning.noise_q * DEGREE
        force = 0.3215  # [kt/s^2] Table I
        y = np.array([tuning.noise_vt, tuning.noise_vz, angle])
        held = np.concatenate([y, [rate, force, force]])
        x = np.array([angle, tuning.noise_vt, angle])
        return Scales(x, y, np.array([force, force, rate]), tuning.Q**-0.5, held)


def _one(
    part: str,
    name: str,
    wire: str | tuple[str, ...],
    sigma: Array | float,
    get: Callable[[Step], Array | float | bool],
    unit: str = "",
) -> Quantity[Step]:
    return Quantity(Compared(name, wire, sigma, part=part, unit=unit), get)


def _memory(
    name: str,
    wire: str | tuple[str, ...],
    sigma: Array | float,
    get: Callable[[Step], Array | float | bool],
    first: Array | float,
) -> Quantity[Step]:
    return Quantity(Compared(name, wire, sigma, part="memory", following=True), get, first)


def _front(scales: Scales) -> Iterator[Quantity[estimator.Step]]:
    part = "missing samples and start"
    yield _one(part, "y_m", "now.y", scales.y, lambda s: s.inputs.y)
    yield _one(part, "u_m", "now.u", scales.u, lambda s: s.inputs.u)
    yield _one(part, "load", "now.load", 1.0, lambda s: s.inputs.load)
    part = "step (i)"
    yield _one(part, "x_bar_k-N", "horizon.x_prior", scales.x, lambda s: s.window.x_prior)
    yield _one(part, "horizon of y_m", "horizon.outputs.y", scales.y, lambda s: s.window.y)


def _iteration(scales: Scales, N: int, disturbed: bool) -> Iterator[Quantity[estimator.Step]]:
    part = "step (ii)"
    if disturbed:
        yield _one(part, "first guess of w", "disturbances.w_prior", scales.w, lambda s: s.window.w_prior)
    inside = "moved.x_next" if disturbed else "observer.x_next"
    states = tuple(f"step.stages[{i}].{inside}" for i in range(N))
    yield _one(part, "x_bar", states, scales.x, lambda s: s.solution.x_bar[1:])
    yield _one(part, "p (12)", "step.p", scales.x, lambda s: s.solution.p)
    if disturbed:
        yield _one(part, "w", "step.w", scales.w, lambda s: s.solution.w)
    part = "step (iii)"
    yield _one(part, "x*_k-N", "step.x_start", scales.x, lambda s: s.solution.x[0])
    after = tuple(f"step.after[{i}].x_next" for i in range(N))
    yield _one(part, "x*", after, scales.x, lambda s: s.solution.x[1:])


def _outputs(scales: Scales, get: Callable[[Step], Array]) -> Iterator[Quantity[Step]]:
    for i, (name, unit) in enumerate((("alpha_hat", "rad"), ("vt_hat", "kt"), ("theta_hat", "rad"))):

        def value(s: Step, i: int = i) -> float:
            return float(get(s)[i])

        yield _one("outputs", name, name, scales.x[i], value, unit)


STARTED, HELD, X_PRIOR, W_PRIOR = "now.started.before", "now.held.held", "horizon.prior.before", "disturbances.before"


def _past(of: str, N: int) -> tuple[str, ...]:
    return taps(f"horizon.{of}", N)


def _memories(scales: Scales, tuning: MhoTuning, disturbed: bool) -> Iterator[Quantity[estimator.Step]]:
    start, N = estimator.initial_state(tuning), tuning.N
    yield _memory("held inputs", HELD, scales.held, lambda s: s.state.held, start.held)
    yield _memory("started", STARTED, 1.0, lambda s: np.array([s.state.started]), np.zeros(1))
    yield _memory("past y_m", _past("outputs", N), scales.y, lambda s: s.state.y_past, start.y_past)
    yield _memory("past u_m", _past("inputs", N), scales.u, lambda s: s.state.u_past, start.u_past)
    yield _memory("a priori estimate", X_PRIOR, scales.x, lambda s: s.state.x_prior, start.x_prior)
    if disturbed:
        yield _memory("a priori disturbances", W_PRIOR, scales.w, lambda s: s.state.w_prior, start.w_prior)


def _state_wires(N: int, disturbed: bool) -> tuple[str, ...]:
    more = (W_PRIOR,) if disturbed else ()
    return (HELD, STARTED, X_PRIOR, *_past("outputs", N), *_past("inputs", N), *more)


def _state(values: Values, N: int, disturbed: bool) -> estimator.State:
    def stack(wires: tuple[str, ...]) -> Array:
        return np.array([values[wire] for wire in wires])

    return estimator.State(
        values[HELD],
        bool(values[STARTED][0]),
        stack(_past("outputs", N)),
        stack(_past("inputs", N)),
        values[X_PRIOR],
        values[W_PRIOR] if disturbed else np.zeros((N, 3)),
    )


def _inputs(values: Values) -> Array:
    return np.array([values[port] for port in PORTS])


def _expected(quantities: list[Quantity[Step]], step: Step) -> Expected:
    return Expected({q.compared.key: np.asarray(q.of_step(step), dtype=np.float64) for q in quantities})


def _initial(quantities: list[Quantity[Step]]) -> dict[str, Array]:
    return {q.compared.key: np.asarray(q.first, dtype=np.float64) for q in quantities if q.first is not None}


def _closed_loop(run: Callable[[Values], Values], decisions: tuple[Decision, ...] = ()) -> ClosedLoop:
    close = (
        Closeness("alpha_hat", TABLES_ANGLE, "deg", 1 / DEGREE),
        Closeness("vt_hat", TABLES_SPEED, "kt"),
        Closeness("theta_hat", TABLES_ANGLE, "deg", 1 / DEGREE),
    )
    return ClosedLoop(run, close[:1] if decisions else close, decisions)


def observer_case(
    sheet: str, method: Method, tuning: MhoTuning, *, disturbed: bool = False, tolerance: float = TOLERANCE
) -> ReferenceCase:
    """The verification of a moving horizon observer; ``disturbed`` if it estimates disturbances."""
    scales, N = Scales.of(tuning), tuning.N
    quantities = [
        *_front(scales),
        *_iteration(scales, N, disturbed),
        *_outputs(scales, lambda s: s.solution.x[-1]),
        *_memories(scales, tuning, disturbed),
    ]

    def expect(state: Values, inputs: Values) -> Expected:
        return _expected(quantities, estimator.step(_state(state, N, disturbed), _inputs(inputs), tuning, method))

    return ReferenceCase(
        sheet,
        mho_scenarios,
        _state_wires(N, disturbed),
        expect,
        tuple(replace(q.compared, tolerance=tolerance) for q in quantities),
        initial=_initial(quantities),
        closed_loop=_closed_loop(lambda inputs: estimator.run(inputs, tuning, method)),
    )


P_BEFORE, EKF_PRIOR = "P_before", "x_prior.before"
UPPER = np.triu_indices(3)


def ekf_case(tuning: MhoTuning) -> ReferenceCase:
    """The verification of the filter."""
    scales = Scales.of(tuning)
    covariance = np.outer(scales.x, scales.x)[UPPER]
    start = ekf.initial_state(tuning)
    part = "missing samples and start"
    quantities: list[Quantity[ekf.Step]] = [
        _one(part, "y_m", "now.y", scales.y, lambda s: s.inputs.y),
        _one(part, "u_m", "now.u", scales.u, lambda s: s.inputs.u),
        _one(part, "load", "now.load", 1.0, lambda s: s.inputs.load),
        _one("update", "x_k|k-1", "step.x_prior", scales.x, lambda s: s.x_prior),
        _one("update", "P_k|k-1", "step.P_prior", covariance, lambda s: s.P_prior[UPPER]),
        _one("update", "P_k|k", "step.update.P", np.outer(scales.x, scales.x), lambda s: s.P),
        *_outputs(scales, lambda s: s.x),
        _memory("held inputs", HELD, scales.held, lambda s: s.state.held, start.held),
        _memory("started", STARTED, 1.0, lambda s: np.array([s.state.started]), np.zeros(1)),
        _memory("x_k+1|k", EKF_PRIOR, scales.x, lambda s: s.state.x, start.x),
        _memory("P_k+1|k", P_BEFORE, covariance, lambda s: s.state.P[UPPER], start.P[UPPER]),
    ]

    def expect(state: Values, inputs: Values) -> Expected:
        P = np.zeros((3, 3))
        P[UPPER] = state[P_BEFORE]
        P = P + np.triu(P, 1).T
        before = ekf.State(state[HELD], bool(state[STARTED][0]), state[EKF_PRIOR], P)
        return _expected(quantities, ekf.step(before, _inputs(inputs), tuning))

    return ReferenceCase(
        "ekf",
        mho_scenarios,
        (HELD, STARTED, EKF_PRIOR, P_BEFORE),
        expect,
        tuple(q.compared for q in quantities),
        initial=_initial(quantities),
        closed_loop=_closed_loop(lambda inputs: ekf.run(inputs, tuning)),
    )


@dataclass(frozen=True)
class _Detected:
    """One frame of estimation and detection."""

    step: estimator.Step
    detection: Detection


def fault_detection_case(tuning: MhoTuning) -> ReferenceCase:
    """The verification of the detection of Fig. 8."""
    scales, N = Scales.of(tuning), tuning.N
    past = tuple(f"J.past.past[{i}].before" for i in range(tuning.n_eval))
    angle = scales.x[0]
    quantities: list[Quantity[_Detected]] = [
        _one("estimate", "x*", "step.x", scales.x, lambda s: s.step.solution.x[-1]),
        _one("outputs", "alpha_hat", "alpha_hat", angle, lambda s: s.step.solution.x[-1, 0], "rad"),
        _one("outputs", "residual", "residual", angle, lambda s: s.detection.residual, "rad"),
        _one("outputs", "alpha_rms", "alpha_rms", angle, lambda s: s.detection.rms, "rad"),
        _one("outputs", "alpha_faulty", "alpha_faulty", 1.0, lambda s: s.detection.faulty),
        _memory("past residuals", past, angle, lambda s: s.detection.past, np.zeros(tuning.n_eval)),
    ]

    def expect(state: Values, inputs: Values) -> Expected:
        step = estimator.step(_state(state, N, False), _inputs(inputs), tuning, mho_pe)
        residuals = np.array([state[wire] for wire in past])
        alpha_hat = float(step.solution.x[-1, 0])
        detection = fault_detection.detect(float(inputs["alpha"]), alpha_hat, residuals, tuning)
        return _expected(quantities, _Detected(step, detection))

    def run(inputs: Values) -> Values:
        alpha_hat = estimator.run(inputs, tuning, mho_pe)["alpha_hat"]
        judged = fault_detection.judge(inputs, alpha_hat, tuning)
        return {"alpha_hat": alpha_hat, "alpha_rms": judged.rms, "alpha_faulty": judged.faulty.astype(float)}

    threshold = tuning.alpha_threshold / DEGREE
    decision = Decision("alpha_faulty", "alpha_rms", threshold, TABLES_ANGLE, "deg", 1 / DEGREE)
    return ReferenceCase(
        "mho_fault_detection",
        mho_scenarios,
        (*_state_wires(N, False), *past),
        expect,
        tuple(q.compared for q in quantities),
        initial=_initial(quantities),
        closed_loop=_closed_loop(run, (decision,)),
    )
