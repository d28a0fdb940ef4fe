"""Numpy references of lag.yaml: as a plain function, and as a case that starts from the sheet's state."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from verification.verifier import (
    Choice,
    ClosedLoop,
    Closeness,
    Compared,
    Decision,
    Expected,
    ReferenceCase,
    Scenario,
)

SHARE, HIGH = 0.25, 0.8


def frame(before, u, share=SHARE):
    """Return y, the step and the squared length of the way."""
    way = np.sin(np.clip(u, -5.0, 5.0)) - before
    length2 = way @ way
    step = 0.5 if length2 >= 0.5 else 1.0
    return before + share * step * way, step, length2


def run(inputs, share=SHARE, high=HIGH):
    """Return the outputs of a whole run."""
    y, rows = np.zeros(2), []
    for u in inputs["u"]:
        y = frame(y, u, share)[0]
        rows.append(y)
    latched = np.logical_or.accumulate(np.array(rows) > high)
    return {"y": np.array(rows), "latched": latched.astype(float)}


def expect(state, inputs, share=SHARE):
    """Return what a frame gives from the sheet's state."""
    y, step, length2 = frame(state["before"], inputs["u"], share)
    way = np.sin(np.clip(inputs["u"], -5.0, 5.0)) - state["before"]
    return Expected({"way": way, "y": y, "remembered": y}, {"step": np.array(step)}, {"step": abs(length2 / 0.5 - 1.0)})


def scenarios(frames, seed):
    """Return two runs, one called fault-free."""
    u = np.random.default_rng(seed).normal(0.0, 1.0, (frames, 2))
    slow = np.sin(np.arange(1, frames + 1) / 10.0)[:, None] * [1.0, 0.5]
    return [Scenario("noise", {"u": u}), Scenario("slow", {"u": slow}, fault_free=True, first_frame=100)]


case = ReferenceCase(
    "lag",
    scenarios,
    state_wires=("before",),
    expect=expect,
    compared=(
        Compared("way", "way", 1.0),
        Compared("y", "y", 1.0, after=1),
        Compared("remembered", "before", 1.0, after=1, following=True),
    ),
    choices=(Choice("step", "step"),),
    closed_loop=ClosedLoop(run, (Closeness("y", 1e-3, ""),), (Decision("latched", "y", HIGH, 1e-3, ""),)),
)


def case_with(**changes):
    """Return the case with fields replaced."""
    return replace(case, **changes)


not_a_reference = 7


def fails(inputs):
    """Raise, as a user's function may."""
    raise ZeroDivisionError("by hand")


def wrong_shape(inputs):
    """Give one column of two."""
    right = run(inputs)
    return right | {"y": right["y"][:, 0]}


def words(inputs):
    """Give text."""
    return run(inputs) | {"y": "high"}


def forgets(inputs):
    """Leave an output out."""
    return {"y": inputs["u"]}


failing_case = replace(case, expect=lambda state, inputs: fails(inputs))
misfit_case = replace(case, compared=(Compared("way", "length2", 1.0),))
