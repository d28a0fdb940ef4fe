"""The verification of ekf_fte: Steps 0 to 2 and the outputs as for the others, and the filter in place of the window."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np

from verification.reference import ekf_fte as reference
from verification.reference.arrays import Array
from verification.reference.ekf_fte import State
from verification.reference.inputs import INERTIAL, Inputs
from verification.reference.tuning import Tuning
from verification.verifier.case import ClosedLoop, Compared, Expected, ReferenceCase, Values
from verification.verifier.estimator_case import Memory, Scales, Seen, after_step_3, before_step_3, memory
from verification.verifier.estimator_wires import StateWires, state_wires
from verification.verifier.scenarios import flight_scenarios

UPPER = np.triu_indices(4)
"""Where the ten remembered elements of the covariance stand: its upper triangle, row by row."""

WINDOW = frozenset({"window of Theta", "window of y", "rows that count", "past Theta", "past y", "past samples present",
                    "warm start of x", "warm start of u", "x", "u"})  # fmt: skip
"""Quantities of the others that a filter has not, or not for a window."""


@dataclass(frozen=True)
class EkfWires:
    """The outputs of the sheet's delays: what :class:`verification.reference.ekf_fte.State` holds."""

    common: StateWires
    x: str = "x_before"
    P: str = "P_before"

    @staticmethod
    def of(tuning: Tuning) -> EkfWires:
        """The wires of a tuning: without a window, the places of the warm start stand in."""
        common = state_wires(reference.one_sample(tuning))
        return EkfWires(replace(common, x_warm=EkfWires.x, u_warm=EkfWires.P))

    def state(self, values: Values) -> State:
        """The reference's state from one frame of wire values."""
        common = replace(
            self.common.state(values),
            x_warm=values[self.x][None],
            u_warm=np.zeros((0, 4)),
            theta_past=np.zeros((0, 6)),
            y_past=np.zeros((0, 4)),
            mask_past=np.zeros((0, 4)),
        )
        return State(common, unpacked(values[self.P]))


def packed(P: Array) -> Array:
    """The upper triangle of a symmetric matrix (4, 4), row by row, shape (10,)."""
    upper: Array = P[UPPER]
    return upper


def unpacked(upper: Array) -> Array:
    """The symmetric matrix (4, 4) of its upper triangle."""
    P = np.zeros((4, 4))
    P[UPPER] = upper
    P.T[UPPER] = upper
    return P


@dataclass(frozen=True, eq=False)
class Filtered:
    """A compared quantity of the filter, and how to take it from the reference's step."""

    compared: Compared
    of_reference: Callable[[reference.Step], Array]


def filtered(scales: Scales) -> Iterator[Filtered]:
    """Step 3 of ekf_fte."""
    x, y, C_bar = scales.x, scales.y, scales.y_bar
    part = "Step 3: filter"

    def one(name: str, wire: str, sigma: Array | float, get: Callable[[reference.Step], Array]) -> Filtered:
        return Filtered(Compared(name, wire, sigma, part=part), get)

    def below(matrix: Array) -> Array:
        return np.concatenate([matrix, np.zeros_like(matrix)])  # the barriers' rows, which a filter has not

    yield one("rows that count", "row", 1.0, lambda s: s.common.trace.window.row_mask[0])
    yield one("x, the point", "step3.x_point", x, lambda s: s.common.trace.qp.x[0])
    yield one("P_hat", "step3.P_hat", x[:, None] * x, lambda s: s.update.P_hat)
    yield one("C_bar", "step3.bare.C_bar", C_bar[:, None] / x, lambda s: below(s.update.C))
    yield one("r_y", "step3.sample.r_y", y, lambda s: s.common.trace.qp.r_y[0])
    yield one("K", "step3.measured.K", x[:, None] / C_bar, lambda s: below(s.update.K.T).T)
    yield one("P_f", "step3.P_f", x[:, None] * x, lambda s: s.update.P_f)
    yield one("x", "step3.x", x, lambda s: s.common.trace.x[0])
    yield one("P_hat, one step ahead", "covariance.P_hat", x[:, None] * x, lambda s: s.state.P)


def remembered(scales: Scales) -> Iterator[Filtered]:
    """The filter's own state that the next frame begins with."""
    x = scales.x

    def one(name: str, wire: str, sigma: Array, get: Callable[[State], Array]) -> Filtered:
        return Filtered(Compared(name, wire, sigma, part="memory", following=True), lambda s: get(s.state))

    yield one("x, predicted", EkfWires.x, x, lambda s: s.common.x_pred)
    yield one("P, predicted", EkfWires.P, packed(x[:, None] * x), lambda s: packed(s.P))


def ekf_case(tuning: Tuning, loop: ClosedLoop) -> ReferenceCase:
    """The verification of ekf_fte with a tuning."""
    scales, wires = Scales.of(tuning), EkfWires.of(tuning)
    before = [q for q in before_step_3(scales) if q.compared.name not in WINDOW]
    after = [q for q in after_step_3(scales, 0) if q.compared.name not in WINDOW]
    common = [q for q in memory(wires.common, scales, 0) if q.compared.name not in WINDOW]
    own, kept = list(filtered(scales)), list(remembered(scales))

    def expect(state: Values, inputs: Values) -> Expected:
        sensors = np.stack([inputs["alpha"], inputs["vc"]])
        now = Inputs(sensors=sensors, inertial=np.array([inputs[name] for name in INERTIAL]))
        # A diverging reference is found by the comparison, not by a warning.
        with np.errstate(all="ignore"):
            step = reference.step(wires.state(state), now, tuning)
        seen = Seen(step.common, ())
        values = {q.compared.key: q.of_reference(seen) for q in (*before, *after, *common)}
        values |= {q.compared.key: q.of_reference(step) for q in (*own, *kept)}
        return Expected({key: np.asarray(value, dtype=np.float64) for key, value in values.items()})

    start = reference.initial_state(tuning)
    initial = {q.compared.key: np.asarray(q.of_state(start.common), float) for q in common if isinstance(q, Memory)}
    for predicted, value in zip(kept, (start.common.x_pred, packed(start.P)), strict=True):
        initial[predicted.compared.key] = value
    return ReferenceCase(
        "ekf_fte",
        flight_scenarios,
        wires.common.all,
        expect,
        (
            *(q.compared for q in before),
            *(q.compared for q in own),
            *(q.compared for q in after),
            *(q.compared for q in common),
            *(q.compared for q in kept),
        ),
        initial=initial,
        closed_loop=loop,
    )
