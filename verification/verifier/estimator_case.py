"""The verification of cmhe_fte and umhe_fte: every output and every interior-point step, from the sheet's own state.

All scales come from P, Q and R: a state counts in sqrt(P), an unknown input in sqrt(Q), a measurement in sqrt(R), and
a matrix element in the ratio or product of the scales of its row and its column.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from verification.reference.arrays import KNOT, Array, Mask
from verification.reference.estimator import Outputs, State, Step, Trace
from verification.reference.interior_point import Iteration
from verification.reference.tuning import Tuning
from verification.verifier.case import Compared
from verification.verifier.estimator_wires import StateWires
from verification.verifier.factors import Factors


@dataclass(frozen=True)
class Scales:
    """Sigma of everything, SI unless said otherwise."""

    x: Array  # (4,)
    u: Array  # (4,)
    y: Array  # (4,)
    sensors: Array  # (2, 1): alpha [rad], V_c [m/s]
    y_bar: Array  # (8,): the rows of C_bar; a barrier's residual has weight 1
    theta: Array  # (6,): V_g, theta, q, A_x, A_z, z
    port: Array  # (7,): vg, vz, theta, q, ax, az, z in port units

    @staticmethod
    def of(tuning: Tuning) -> Scales:
        """The scales of a tuning."""
        x, u, y = np.sqrt(tuning.P), np.sqrt(tuning.Q), np.sqrt(tuning.R)
        # Inputs are not estimated: V_g counts as its measurement does, angles as alpha's, q and the forces as the
        # unknown inputs beside them in (20), and z in metres.
        theta = np.array([y[0], y[2], u[0], u[1], u[1], 1.0])
        port = np.array([y[0] / KNOT, y[1] / KNOT, y[2], u[0], u[1] / KNOT, u[1] / KNOT, 1.0])
        y_bar = np.concatenate([y, np.ones(4)])
        return Scales(x, u, y, np.array([[y[2]], [y[3]]]), y_bar, theta, port)


@dataclass(frozen=True)
class Seen:
    """One frame of the reference."""

    step: Step
    passes: tuple[Factors, ...]

    @property
    def trace(self) -> Trace:
        """What happened inside the frame."""
        return self.step.trace

    @property
    def outputs(self) -> Outputs:
        """Its outputs."""
        return self.step.outputs

    @property
    def state(self) -> State:
        """What it leaves to the next frame."""
        return self.step.state


Getter = Callable[[Seen], Array | Mask | float]


@dataclass(frozen=True, eq=False)
class Quantity:
    """A compared quantity and how to take it from what the reference gives."""

    compared: Compared
    of_reference: Getter


@dataclass(frozen=True, eq=False)
class Memory(Quantity):
    """A remembered quantity."""

    of_state: Callable[[State], Array | Mask | float]


def before_step_3(scales: Scales) -> Iterator[Quantity]:
    """Steps 0 to 2."""

    def pair(name: str, path: str, sigma: Array | float, part: str, get: Getter, unit: str = "") -> Quantity:
        wires = tuple(path.format(sensor) for sensor in ("alpha", "vc"))
        return Quantity(Compared(name, wires, sigma, part=part, unit=unit), get)

    def one(name: str, wire: str, sigma: Array | float, part: str, get: Getter, unit: str = "") -> Quantity:
        return Quantity(Compared(name, wire, sigma, part=part, unit=unit), get)

    part = "Step 0: missing samples and start-up"
    yield Quantity(
        Compared("sensors", ("now.alpha_or_zero", "now.vc_si"), scales.sensors, part=part),
        lambda s: s.trace.inputs.sensors,
    )
    yield pair("sensors valid", "now.{}_valid", 1.0, part, lambda s: s.trace.inputs.sensors_valid)
    yield one("Theta", "now.Theta", scales.theta, part, lambda s: s.trace.inputs.theta)
    yield one("inertial ok", "now.inertial_ok", 1.0, part, lambda s: s.trace.inputs.inertial_ok)
    yield one("load", "start.load", 1.0, part, lambda s: s.trace.start_up.load)
    yield one("inhibit", "start.inhibit", 1.0, part, lambda s: s.trace.start_up.inhibit)

    part = "Step 1: residuals and fault decision"
    yield pair("prediction", "{}_check.prediction", scales.sensors[:, 0], part, lambda s: s.trace.prediction)
    yield pair("wind from before", "{}_wind.wind", scales.x[[3, 2]], part, lambda s: s.trace.wind_held.wind)
    yield pair("prediction with it", "{}_check.held", scales.sensors[:, 0], part, lambda s: s.trace.held)
    yield pair("residuals (17)", "{}_check.r", scales.sensors, part, lambda s: s.trace.judgement.residual)
    yield pair("rms (18)", "{}_check.J", scales.sensors, part, lambda s: s.trace.judgement.rms)
    yield pair("over the threshold", "{}_check.over", 1.0, part, lambda s: s.trace.judgement.over)
    yield pair("in doubt", "{}_check.doubtful", 1.0, part, lambda s: s.trace.judgement.doubtful)
    yield pair("bad", "{}_check.bad", 1.0, part, lambda s: s.trace.judgement.bad)
    yield pair("faulty", "{}_check.faulty", 1.0, part, lambda s: s.trace.judgement.faulty)

    part = "Step 2: fusion and window"
    yield pair("fused (19)", "{}_fusion.y", scales.sensors[:, 0], part, lambda s: s.trace.fused.value)
    yield pair("lost", "{}_fusion.lost", 1.0, part, lambda s: s.trace.fused.lost)
    yield one("window of Theta", "Theta_window.y", scales.theta, part, lambda s: s.trace.window.theta)
    yield one("window of y", "y_window.y", scales.y, part, lambda s: s.trace.window.y)
    yield one("rows that count", "row", 1.0, part, lambda s: s.trace.window.row_mask)


def linearised(scales: Scales, samples: int) -> Iterator[Quantity]:
    """The quadratic program (42)."""
    part = "Step 3: quadratic program (42)"
    x, u, y = scales.x, scales.u, scales.y

    def one(name: str, wire: str | tuple[str, ...], sigma: Array, get: Getter) -> Quantity:
        return Quantity(Compared(name, wire, sigma, part=part), get)

    x_point = tuple(f"step3.x_point[{i}]" for i in range(samples))
    u_point = tuple(f"step3.u_point[{i}]" for i in range(samples - 1))
    yield one("x, the point", x_point, x, lambda s: s.trace.qp.x)
    yield one("u, the point", u_point, u, lambda s: s.trace.qp.u)
    yield one("A", "step3.qp.A", x[:, None] / x, lambda s: s.trace.qp.A)
    yield one("C", "step3.qp.C", y[:, None] / x, lambda s: s.trace.qp.C)
    yield one("f", "step3.qp.f", x, lambda s: s.trace.qp.f)
    yield one("r_u", "step3.qp.r_u", u, lambda s: s.trace.qp.r_u)
    yield one("r_y", "step3.qp.r_y", y, lambda s: s.trace.qp.r_y)


def factorization(path: str, number: int, samples: int, scales: Scales, repeat: str, after: int) -> Iterator[Quantity]:
    """Algorithm 2 inside pass ``number``, at ``path``, sample by sample: ``stages`` and, for the newest, ``last``."""
    for i in range(samples):
        inside = f"{path}stages[{i}].measured." if i < samples - 1 else f"{path}last."
        yield from one_sample(inside, number, i, scales, f"{repeat}sample {i + 1}", after)


def one_sample(path: str, number: int, i: int, scales: Scales, repeat: str, after: int) -> Iterator[Quantity]:
    """Lines 4 and 5 of Algorithm 2 for sample i, i from 0."""
    x, y = scales.x, scales.y_bar
    part = "Step 3: Algorithm 2"

    def one(name: str, wire: str, sigma: Array, get: Callable[[Factors], Array]) -> Quantity:
        compared = Compared(name, path + wire, sigma, part=part, after=after, repeat=repeat)
        return Quantity(compared, lambda s: get(s.passes[number])[i])

    yield one("C_bar", "C_bar", y[:, None] / x, lambda f: f.C_bar)
    yield one("Pi", "Pi", y[:, None] * x, lambda f: f.Pi)
    yield one("K", "K", x[:, None] / y, lambda f: f.K)
    yield one("P_f", "P_f", x[:, None] * x, lambda f: f.P_f)


def passes(scales: Scales, count: int, samples: int) -> Iterator[Quantity]:
    """Algorithm 1 of cmhe_fte: every pass in turn."""
    for j in range(count):
        yield from one_pass(scales, j, samples)


def one_pass(scales: Scales, j: int, samples: int) -> Iterator[Quantity]:
    """Pass j of Algorithm 1, j from 0."""
    x, u = scales.x, scales.u
    path, part, repeat = f"step3.ip[{j}].", "Step 3: Algorithm 1", f"pass {j + 1}"

    def stacked(name: str, wire: str, n: int, sigma: Array, get: Callable[[Factors], Array]) -> Quantity:
        wires = tuple(path + wire.format(i) for i in range(n))
        return Quantity(Compared(name, wires, sigma, part=part, after=j, repeat=repeat), lambda s: get(s.passes[j]))

    def one(
        name: str, wire: str, sigma: Array | float, get: Callable[[Iteration], Array | float], after: int = j
    ) -> Quantity:
        compared = Compared(name, path + wire, sigma, part=part, after=after, repeat=repeat)
        return Quantity(compared, lambda s: get(s.trace.iterations[j]))

    yield stacked("r_y (46e)", "samples[{}].r_y_bar", samples, scales.y_bar, lambda f: f.r_y)
    yield stacked("r_p (46c)", "transitions[{}].r_p", samples - 1, x, lambda f: f.r_p)
    yield stacked("Q_bar (46f)", "transitions[{}].Q_bar", samples - 1, u**2, lambda f: f.Q_bar)
    yield stacked("r_u (46d)", "transitions[{}].r_u_bar", samples - 1, u, lambda f: f.r_u)
    yield from factorization(path, j, samples, scales, f"{repeat}, ", j)
    yield one("direction of x", "direction_x", x, lambda i: i.direction_x)
    yield one("direction of u", "direction_u", u, lambda i: i.direction_u)
    yield one("v", "search.v", 1.0, lambda i: i.v)
    yield one("dx", "dx_next", x, lambda i: i.dx, after=j + 1)
    yield one("du", "du_next", u, lambda i: i.du, after=j + 1)


def only_step(scales: Scales, samples: int) -> Iterator[Quantity]:
    """The one step of umhe_fte."""
    yield from factorization("step3.", 0, samples, scales, "", 0)
    yield Quantity(
        Compared("direction of x", "step3.dx", scales.x, part="Step 3: Algorithm 2"),
        lambda s: s.trace.iterations[0].direction_x,
    )


def memory(wires: StateWires, scales: Scales, choices: int) -> Iterator[Memory]:
    """The state that the next frame begins with."""
    part = "memory"

    def one(
        name: str,
        wire: str | tuple[str, ...],
        sigma: Array | float,
        get: Callable[[State], Array | Mask | float],
        after: int = 0,
    ) -> Memory:
        compared = Compared(name, wire, sigma, part=part, after=after, following=True)
        return Memory(compared, lambda s: get(s.state), get)

    yield one("held inputs", wires.held, scales.port, lambda s: s.held)
    yield one("started", wires.started, 1.0, lambda s: s.started)
    yield one("inhibit count", wires.inhibit_count, 1.0, lambda s: s.inhibit_count)
    yield one("past Theta", wires.theta_past, scales.theta, lambda s: s.theta_past)
    yield one("past y", wires.y_past, scales.y, lambda s: s.y_past)
    yield one("past samples present", wires.mask_past, 1.0, lambda s: s.mask_past)
    yield one("past residuals of alpha", wires.residuals[0], scales.sensors[0, 0], lambda s: s.residuals[:, 0])
    yield one("past residuals of vc", wires.residuals[1], scales.sensors[1, 0], lambda s: s.residuals[:, 1])
    squares = scales.sensors[:, 0] ** 2
    yield one("past squares of alpha", wires.squares_held[0], squares[0], lambda s: s.squares_held[:, 0])
    yield one("past squares of vc", wires.squares_held[1], squares[1], lambda s: s.squares_held[:, 1])
    yield one("past bad of alpha", wires.bads[0], 1.0, lambda s: s.bads[:, 0])
    yield one("past bad of vc", wires.bads[1], 1.0, lambda s: s.bads[:, 1])
    yield one("past disagreement of alpha", wires.aparts[0], 1.0, lambda s: s.aparts[:, 0])
    yield one("past disagreement of vc", wires.aparts[1], 1.0, lambda s: s.aparts[:, 1])
    yield one("rms before", wires.rms_before, scales.sensors, lambda s: s.rms_before)
    yield one("wind kept", wires.wind_held, scales.x[[3, 2]], lambda s: s.wind_held)
    yield one("in doubt", wires.doubtful, 1.0, lambda s: s.doubtful)
    yield one("faulty", wires.faulty, 1.0, lambda s: s.faulty)
    yield one("warm start of x", wires.x_warm, scales.x, lambda s: s.x_warm, after=choices)
    yield one("warm start of u", wires.u_warm, scales.u, lambda s: s.u_warm, after=choices)


def after_step_3(scales: Scales, choices: int) -> Iterator[Quantity]:
    """The solution, the outputs and what is remembered."""
    x, u, y = scales.x, scales.u, scales.y

    def one(name: str, wire: str, sigma: Array | float, part: str, get: Getter, unit: str = "") -> Quantity:
        return Quantity(Compared(name, wire, sigma, part=part, unit=unit, after=choices), get)

    part = "Step 3: solution"
    yield one("x", "step3.x", x, part, lambda s: s.trace.x)
    yield one("u", "step3.u", u, part, lambda s: s.trace.u)
    yield one("x, one step ahead", "coming.x_next", x, part, lambda s: s.state.x_pred)

    part = "outputs"
    kt = 1.0 / KNOT
    yield one("alpha_hat", "alpha_hat", x[0], part, lambda s: s.outputs.alpha_hat, "rad")
    yield one("vc_hat", "vc_hat", y[3] * kt, part, lambda s: s.outputs.vc_hat, "kt")
    yield one("wx_hat", "wx_hat", x[2] * kt, part, lambda s: s.outputs.wx_hat, "kt")
    yield one("wz_hat", "wz_hat", x[3] * kt, part, lambda s: s.outputs.wz_hat, "kt")
    yield one("alpha_pred", "alpha_pred", x[0], part, lambda s: s.outputs.alpha_pred, "rad")
    yield one("vc_pred", "vc_pred", y[3] * kt, part, lambda s: s.outputs.vc_pred, "kt")
    yield one("alpha_rms", "alpha_rms", y[2], part, lambda s: s.outputs.alpha_rms, "rad")
    yield one("vc_rms", "vc_rms", y[3] * kt, part, lambda s: s.outputs.vc_rms, "kt")
    yield one("alpha_faulty", "alpha_faulty", 1.0, part, lambda s: s.outputs.alpha_faulty)
    yield one("vc_faulty", "vc_faulty", 1.0, part, lambda s: s.outputs.vc_faulty)
    yield one("configuration", "configuration", 1.0, part, lambda s: s.outputs.configuration)
