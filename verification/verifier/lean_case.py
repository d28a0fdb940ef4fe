"""What cmhe_fte_lean computes in Step 3, against the reference: the window as information, and every pass of Algorithm 1.

The lean sheets hold none of the paper's matrices, so the reference's A, C, f, r_y and Q_bar are brought into their
form here (docs/lean.md). The sheets count an unknown input in what it moves, v = f + t_s Delta u, with the sign of the
second one turned, and divide the cost by kappa.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from verification.reference.arrays import Array
from verification.reference.interior_point import Iteration
from verification.reference.linearisation import QuadraticProgram
from verification.reference.tuning import Tuning
from verification.verifier.case import Compared
from verification.verifier.estimator_case import Quantity, Scales

ALPHA_W = np.array([0, 2, 3])
"""alpha, W_x and W_z among the states: V_g goes a way of its own."""

SIGNS = np.array([[1.0], [-1.0]])
"""Of v, for the two transitions."""


@dataclass(frozen=True)
class WindowInformation:
    """The quadratic program (42) as the lean sheets hold it."""

    I: Array  # (3, 3, 3), alpha, W_x, W_z; in the first sample a_11 alpha for alpha
    I_V: Array  # (3,), V_g
    j: Array  # (3, 4), information vectors
    f0: Array  # (2, 4), v without unknown inputs


def window_information(qp: QuadraticProgram, tuning: Tuning) -> WindowInformation:
    """Return C' R^-1 C and C' R^-1 r_y of each sample, with the arrival cost in the first."""
    weighted = qp.C.transpose(0, 2, 1) / tuning.R
    information, vector = weighted @ qp.C, np.einsum("imn,in->im", weighted, qp.r_y)
    information[0] += np.diag(1.0 / tuning.P)
    scale = np.array([1.0 / qp.A[0, 0, 0], 1.0, 1.0, 1.0])
    information[0] *= scale[:, None] * scale
    vector[0] *= scale
    return WindowInformation(
        information[:, ALPHA_W[:, None], ALPHA_W], information[:, 1, 1], vector, SIGNS * (qp.f - tuning.t_s * qp.u)
    )


def lean_window(scales: Scales, tuning: Tuning) -> Iterator[Quantity]:
    """What a frame computes once of Step 3."""
    part, samples = "Step 3: quadratic program (42)", 3
    x = scales.x
    entries = x[ALPHA_W]

    def one(
        name: str, wire: str | tuple[str, ...], sigma: Array | float, get: Callable[[QuadraticProgram], Array | float]
    ) -> Quantity:
        return Quantity(Compared(name, wire, sigma, part=part), lambda s: get(s.trace.qp))

    def information(get: Callable[[WindowInformation], Array]) -> Callable[[QuadraticProgram], Array]:
        return lambda qp: get(window_information(qp, tuning))

    yield one("x, the point", tuple(f"step3.x_point[{i}]" for i in range(samples)), x, lambda qp: qp.x)
    yield one("u, the point", tuple(f"step3.u_point[{i}]" for i in range(samples - 1)), scales.u, lambda qp: qp.u)
    yield one("information", "step3.qp.I", 1.0 / (entries[:, None] * entries), information(lambda w: w.I))
    yield one("information on V_g", "step3.qp.I_V", 1.0 / x[1] ** 2, information(lambda w: w.I_V))
    yield one("information vectors", "step3.qp.j", 1.0 / x, information(lambda w: w.j))
    yield one("f0", "step3.qp.f0", x, information(lambda w: w.f0))
    yield one("1/a_11, first", "step3.qp.per_a_11", 1.0, lambda qp: 1.0 / qp.A[0, 0, 0])
    yield one("a_21/a_11, first", "step3.qp.a_V", x[1] / x[0], lambda qp: qp.A[0, 1, 0] / qp.A[0, 0, 0])
    yield one("a_11", "step3.qp.a_11", 1.0, lambda qp: qp.A[:, 0, 0])
    yield one("a_21", tuple(f"step3.qp.moved[{i}].a_21" for i in range(2)), x[1] / x[0], lambda qp: qp.A[:, 1, 0])


def pass_path(number: int, count: int) -> str:
    """Where the Newton step of a pass is: the last one stands alone, because it updates less."""
    return "step3.last." if number == count - 1 else f"step3.ip[{number}].newton."


def lean_passes(scales: Scales, tuning: Tuning, count: int) -> Iterator[Quantity]:
    """Algorithm 1: every pass in turn."""
    for number in range(count):
        yield from lean_pass(scales, tuning, number, count)


def lean_pass(scales: Scales, tuning: Tuning, number: int, count: int) -> Iterator[Quantity]:
    """One pass of Algorithm 1, number from 0."""
    part, repeat, path = "Step 3: Algorithm 1", f"pass {number + 1}", pass_path(number, count)
    x, u, t_s = scales.x, scales.u, tuning.t_s

    def one(
        name: str,
        wire: str | tuple[str, ...],
        sigma: Array | float,
        get: Callable[[Iteration], Array | float],
        after: int = number,
    ) -> Quantity:
        compared = Compared(name, wire, sigma, part=part, after=after, repeat=repeat)
        return Quantity(compared, lambda s: get(s.trace.iterations[number]))

    variances = tuple(f"{path}v_information[{i}].T" for i in range(2))
    yield Quantity(
        Compared("kappa t_s^2 Q_bar (46f)", variances, (t_s * u) ** 2, part=part, after=number, repeat=repeat),
        lambda s: s.trace.iterations[number].kappa * t_s**2 * s.passes[number].Q_bar,
    )
    yield one("direction of x", path + "direction_x", x, lambda i: i.direction_x)
    yield one("direction of u", path + "direction_u", u, lambda i: i.direction_u)
    yield one("reach", path + "search.v", 1.0, lambda i: i.v)
    if number < count - 1:
        moved = tuple(f"step3.ip[{number}].moved[{i}].next" for i in range(5))
        yield one("dx", moved[:3], x, lambda i: i.dx, after=number + 1)
        yield Quantity(
            Compared("v", moved[3:], t_s * u, part=part, after=number + 1, repeat=repeat),
            lambda s: SIGNS * (s.trace.qp.f + t_s * s.trace.iterations[number].du),
        )
