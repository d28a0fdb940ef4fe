"""The reference cases of the shipped sheets, as the entry points of `saoflow.references` name them."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence

import numpy as np

from verification.reference import cmhe_fte as cmhe_reference
from verification.reference import ekf_fte as ekf_reference
from verification.reference import umhe_fte as umhe_reference
from verification.reference.estimator import Method, Trace, initial_state
from verification.reference.estimator import run as run_reference
from verification.reference.estimator import step as step_reference
from verification.reference.inputs import INERTIAL, Inputs
from verification.reference.tuning import Tuning
from verification.verifier.case import Choice, ClosedLoop, Closeness, Decision, Expected, ReferenceCase, Values
from verification.verifier.ekf_case import ekf_case
from verification.verifier.estimator_case import (
    Memory,
    Quantity,
    Scales,
    Seen,
    after_step_3,
    before_step_3,
    linearised,
    memory,
    only_step,
    passes,
)
from verification.verifier.estimator_wires import StateWires, state_wires
from verification.verifier.factors import Factors, constrained_factors, unconstrained_factors
from verification.verifier.lean_case import lean_passes, lean_window, pass_path
from verification.verifier.scenarios import flight_scenarios

TABLES_ALPHA = 1e-3
"""How far the tables may move an angle of attack in closed loop [deg]."""

TABLES_SPEED = 0.02
"""How far the tables may move an airspeed in closed loop [kt]."""


def closed_loop(run: Callable[[Values], Values], tuning: Tuning) -> ClosedLoop:
    """The closed loop with tables against the reference's own run."""
    degrees = 180.0 / math.pi
    threshold = tuning.alpha_threshold, tuning.vc_threshold
    return ClosedLoop(
        run=run,
        close=(
            Closeness("alpha_hat", TABLES_ALPHA, "deg", degrees),
            Closeness("vc_hat", TABLES_SPEED, "kt"),
            Closeness("alpha_pred", TABLES_ALPHA, "deg", degrees),
            Closeness("vc_pred", TABLES_SPEED, "kt"),
            Closeness("wx_hat", None, "kt"),
            Closeness("wz_hat", None, "kt"),
            Closeness("alpha_rms", None, "deg", degrees),
            Closeness("vc_rms", None, "kt"),
        ),
        decisions=(
            Decision("alpha_faulty", "alpha_rms", threshold[0], TABLES_ALPHA, "deg", degrees, tuning.n_eval),
            Decision("vc_faulty", "vc_rms", threshold[1], TABLES_SPEED, "kt", 1.0, tuning.n_eval),
        ),
    )


def _case(
    sheet: str,
    method: Method,
    tuning: Tuning,
    wires: StateWires,
    quantities: Sequence[Quantity],
    factors: Callable[[Trace, Tuning], list[Factors]],
    line_searches: Sequence[str],
) -> ReferenceCase:
    def expect(state: Values, inputs: Values) -> Expected:
        now = Inputs(
            sensors=np.stack([inputs["alpha"], inputs["vc"]]), inertial=np.array([inputs[name] for name in INERTIAL])
        )
        # A diverging reference is found by the comparison, not by a warning.
        with np.errstate(all="ignore"):
            step = step_reference(wires.state(state), now, tuning, method)
            seen = Seen(step, tuple(factors(step.trace, tuning)))
        iterations = dict(zip(choices, step.trace.iterations, strict=False))
        return Expected(
            {key: np.asarray(q.of_reference(seen), dtype=np.float64) for key, q in by_key.items()},
            {name: np.array(iteration.s) for name, iteration in iterations.items()},
            {name: iteration.margin for name, iteration in iterations.items()},
        )

    start = initial_state(tuning)
    initial = {
        q.compared.key: np.asarray(q.of_state(start), dtype=np.float64) for q in quantities if isinstance(q, Memory)
    }
    by_key = {quantity.compared.key: quantity for quantity in quantities}
    choices = tuple(f"step length of pass {j + 1}" for j in range(len(line_searches)))
    return ReferenceCase(
        sheet,
        flight_scenarios,
        wires.all,
        expect,
        tuple(quantity.compared for quantity in quantities),
        tuple(Choice(name, wire) for name, wire in zip(choices, line_searches, strict=True)),
        initial,
        closed_loop(lambda inputs: run_reference(inputs, tuning, method), tuning),
    )


def cmhe_case(tuning: Tuning) -> ReferenceCase:
    """The verification of cmhe_fte with a tuning."""
    count, samples = tuning.n_kappa * tuning.n_qp, tuning.n_horizon
    scales, wires = Scales.of(tuning), state_wires(tuning)

    def quantities() -> Iterator[Quantity]:
        yield from before_step_3(scales)
        yield from linearised(scales, tuning.n_horizon)
        yield from passes(scales, count, samples)
        yield from after_step_3(scales, count)
        yield from memory(wires, scales, count)

    searches = [f"step3.ip[{j}].search.s" for j in range(count)]
    return _case("cmhe_fte", cmhe_reference.METHOD, tuning, wires, list(quantities()), constrained_factors, searches)


def lean_case(tuning: Tuning) -> ReferenceCase:
    """The verification of cmhe_fte_lean with a tuning: the same reference, outputs and memory as cmhe_fte."""
    count = tuning.n_kappa * tuning.n_qp
    scales, wires = Scales.of(tuning), state_wires(tuning)

    def quantities() -> Iterator[Quantity]:
        yield from before_step_3(scales)
        yield from lean_window(scales, tuning)
        yield from lean_passes(scales, tuning, count)
        yield from after_step_3(scales, count)
        yield from memory(wires, scales, count)

    searches = [f"{pass_path(j, count)}search.s" for j in range(count)]
    method = cmhe_reference.METHOD
    return _case("cmhe_fte_lean", method, tuning, wires, list(quantities()), constrained_factors, searches)


def umhe_case(tuning: Tuning) -> ReferenceCase:
    """The verification of umhe_fte with a tuning."""
    scales, wires = Scales.of(tuning), state_wires(tuning)

    def quantities() -> Iterator[Quantity]:
        yield from before_step_3(scales)
        yield from linearised(scales, tuning.n_horizon)
        yield from only_step(scales, tuning.n_horizon)
        yield from after_step_3(scales, 0)
        yield from memory(wires, scales, 0)

    return _case("umhe_fte", umhe_reference.METHOD, tuning, wires, list(quantities()), unconstrained_factors, ())


cmhe_fte = cmhe_case(Tuning())
cmhe_fte_lean = lean_case(Tuning())
umhe_fte = umhe_case(Tuning())
ekf_fte = ekf_case(Tuning(), closed_loop(lambda inputs: ekf_reference.run(inputs, Tuning()), Tuning()))
