"""The reference cases of paper 001's estimators: where the quantities of the reference stand in their sheets."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from verification.reference.arrays import Array
from verification.reference.cstr.algorithm_1 import DampedPass, Pass
from verification.reference.cstr.estimator import (
    ALGORITHM_1,
    ALGORITHM_1_WITHOUT,
    ALGORITHM_2,
    ALGORITHM_2_WITHOUT,
    Frame,
    Method,
    State,
    run,
    step,
)
from verification.reference.cstr.sensitivity import Update
from verification.reference.cstr.tuning import Tuning
from verification.verifier.case import TOLERANCE, ClosedLoop, Closeness, Compared, Expected, ReferenceCase, Values
from verification.verifier.cstr_scenarios import plausible_scenarios, reactor_scenarios
from verification.verifier.estimator_wires import taps

SIGMA_X = np.array([0.01, 0.05])
"""Scale of a state: its noises."""

SIGMA_GRADIENT = 1e3
"""Scale of the gradient of J/2: what the cost makes of a hundredth of a state."""

SIGMA_TRIAL = 1e3
"""Scale of a trial's cost without noises: within a frame it goes from thousands to a few, and trials are compared."""

SIGMA_GRADIENT_FIRST = 1e5
"""The same without noises, where the Hessian reaches 1e9."""

TABLES = 1e-3
"""How far the table may move an estimate in closed loop."""

TOLERANCE_FIRST = 1e-9
"""Without noises, where every state of a window follows from the first: near a jump of the temperature that multiplies rounding."""


@dataclass(frozen=True, eq=False)
class Quantity:
    """A wire, and the reference's value of it."""

    compared: Compared
    of: Callable[[Frame], Array | float]


def wires_of(tuning: Tuning, method: Method) -> dict[str, tuple[str, ...]]:
    """The outputs of the sheet's delays, by the field of :class:`State`."""
    samples = tuning.N + 1 + method.ahead
    found = {
        "count": ("given.before",),
        "y_past": taps("given.y_window", samples - 1),
        "u_past": taps("given.u_window", samples - 2),
        "x": ("start.last",),
    }
    return found | ({"x_bar": ("x_bar_before",)} if method.ahead else {})


def state_of(values: Values, tuning: Tuning, method: Method) -> State:
    """The reference's state from one frame of wire values; what Algorithm 1 does not keep is zero."""
    wires = wires_of(tuning, method)

    def window(name: str, length: int) -> Array:
        kept = np.array([float(values[wire]) for wire in wires[name]])
        return np.concatenate([np.zeros(length - len(kept)), kept])

    return State(
        count=round(float(values["given.before"])),
        y_past=window("y_past", tuning.N + 1),
        u_past=window("u_past", tuning.N),
        x=values["start.last"],
        x_bar=values["x_bar_before"] if method.ahead else np.zeros(2),
    )


def quantities(tuning: Tuning, method: Method) -> Iterator[Quantity]:
    """What is compared, in the order in which a frame computes it."""
    yield Quantity(Compared("x_bar", "start.x_bar", SIGMA_X, part="start"), lambda f: f.x_bar)
    if method.noises:
        yield Quantity(Compared("warm start", "start.x", SIGMA_X, part="start"), lambda f: f.warm)
    for j in range(tuning.n_GN if method.noises else tuning.n_GN_first):
        yield from _pass(j) if method.noises else _damped_pass(j)
    if method.ahead:
        yield from _update(method)
    allowed = TOLERANCE if method.noises else TOLERANCE_FIRST
    yield Quantity(Compared("window", "window", SIGMA_X, allowed, part="outputs"), lambda f: f.x)
    yield Quantity(Compared("x_hat", "x_hat", SIGMA_X, allowed, part="outputs"), lambda f: f.x_hat)
    yield Quantity(Compared("valid", "valid", 1.0, part="outputs"), lambda f: float(f.valid))
    yield Quantity(Compared("count", "given.before", 1.0, part="memory", following=True), lambda f: f.state.count)
    yield Quantity(Compared("estimates", "start.last", SIGMA_X, allowed, part="memory", following=True), lambda f: f.state.x)


def _pass(j: int) -> Iterator[Quantity]:
    """A pass over a window with noises."""
    path, part, repeat = f"passes[{j}]", "passes", f"pass {j + 1}"

    def one(name: str, wire: str, sigma: Array | float, of: Callable[[Pass], Array]) -> Quantity:
        compared = Compared(name, f"{path}.{wire}", sigma, part=part, repeat=repeat)
        return Quantity(compared, lambda f: of(_noises(f.passes[j])))

    yield one("gradient", "gradient", SIGMA_GRADIENT, lambda p: p.at.gradient)
    yield one("free components", "free", 1.0, lambda p: np.where(p.hold, 0.0, 1.0))
    yield one("estimates", "x", SIGMA_X, lambda p: p.x)


def _damped_pass(j: int) -> Iterator[Quantity]:
    """A pass for the first state of a window without noises."""
    path, part, repeat = f"passes[{j}]", "passes", f"pass {j + 1}"

    def one(name: str, wire: str, sigma: Array | float, of: Callable[[DampedPass], Array | float]) -> Quantity:
        compared = Compared(name, f"{path}.{wire}", sigma, TOLERANCE_FIRST, part=part, repeat=repeat)
        return Quantity(compared, lambda f: of(_damped(f.passes[j])))

    yield one("cost", "cost.J", SIGMA_TRIAL, lambda p: p.at.J)
    yield one("better", "better", 1.0, lambda p: float(p.better))
    yield one("gradient of the best", "gradient", SIGMA_GRADIENT_FIRST, lambda p: p.best.gradient)
    yield one("free components", "free", 1.0, lambda p: np.where(p.hold, 0.0, 1.0))
    yield one("trial", "trial", SIGMA_X, lambda p: p.trial)


def _update(method: Method) -> Iterator[Quantity]:
    """Steps 2 and 3 of Algorithm 2."""

    def one(name: str, wire: str, sigma: Array | float, of: Callable[[Update], Array | float]) -> Quantity:
        compared = Compared(name, f"ahead.{wire}", sigma, allowed, part="one step ahead")
        return Quantity(compared, lambda f: of(_updated(f)))

    allowed, slope = (TOLERANCE, SIGMA_GRADIENT) if method.noises else (TOLERANCE_FIRST, SIGMA_GRADIENT_FIRST)

    yield one("reference", "reference", SIGMA_X, lambda u: u.reference)
    yield one("gradient left", "stationary", slope, lambda u: u.stationary)
    yield one("second order", "second_order", 1.0, lambda u: float(u.second_order))
    yield one("x^u", "updated", SIGMA_X, lambda u: u.updated)
    yield one("cost of the reference", "J_reference", 1.0, lambda u: u.J_reference)
    yield one("cost of x^u", "J_updated", 1.0, lambda u: u.J_updated)
    yield one("accepted", "accepted", 1.0, lambda u: float(u.accepted))
    yield one("x^+", "x", SIGMA_X, lambda u: u.x)


def _updated(frame: Frame) -> Update:
    assert frame.update is not None
    return frame.update


def _noises(found: Pass | DampedPass) -> Pass:
    assert isinstance(found, Pass)
    return found


def _damped(found: Pass | DampedPass) -> DampedPass:
    assert isinstance(found, DampedPass)
    return found


def reactor_case(sheet: str, tuning: Tuning, method: Method) -> ReferenceCase:
    """The verification of one of the sheets with a tuning."""
    all_quantities = list(quantities(tuning, method))
    # Without noises a cost that is better by a hair with the table is another path of the damped passes
    limit = TABLES if method.noises else None

    def expect(state: Values, inputs: Values) -> Expected:
        # A reference that diverges is found by the comparison, not by a warning.
        with np.errstate(all="ignore"):
            frame = step(
                state_of(state, tuning, method), float(inputs["y"]), float(inputs["u"]), tuning, method
            )
        return Expected({q.compared.key: np.asarray(q.of(frame), dtype=np.float64) for q in all_quantities})

    return ReferenceCase(
        sheet,
        reactor_scenarios if method.noises else plausible_scenarios,
        tuple(wire for wires in wires_of(tuning, method).values() for wire in wires),
        expect,
        tuple(q.compared for q in all_quantities),
        initial={q.compared.key: np.zeros(()) if q.compared.name == "count" else np.zeros((tuning.N + 1, 2))
                 for q in all_quantities if q.compared.following},
        closed_loop=ClosedLoop(
            lambda inputs: run(inputs, tuning, method),
            (Closeness("x_hat", limit, ""), Closeness("window", limit, ""), Closeness("valid", 0.5, "")),
        ),
    )


cstr_mhe = reactor_case("cstr_mhe", Tuning(), ALGORITHM_1)
"""Algorithm 1."""

cstr_mhe_no_est = reactor_case("cstr_mhe_no_est", Tuning(), ALGORITHM_1_WITHOUT)
"""Algorithm 1 without estimated noises."""

cstr_ahead = reactor_case("cstr_ahead", Tuning(), ALGORITHM_2)
"""Algorithm 2."""

cstr_ahead_no_est = reactor_case("cstr_ahead_no_est", Tuning(), ALGORITHM_2_WITHOUT)
"""Algorithm 2 without estimated noises."""
