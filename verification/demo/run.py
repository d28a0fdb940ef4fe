"""The road of the demonstration: sheets from YAML, readings through them, the reference beside them."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import fields
from types import ModuleType

import numpy as np

import saoflow
from verification.demo.result import Arrays, DemoResult, Method
from verification.demo.scenario import Scenario

Progress = Callable[[str, int, int], None]
"""Told what is being done, how much of it is done, and how much there is."""

SHEETS = ("cmhe_fte", "umhe_fte")


def run_demo(scenario: Scenario, progress: Progress | None = None) -> DemoResult:
    """Run the scenario through both sheets and both references.

    Raises DiagnosisError (a sheet with errors, or over its budget: E401) or of flights and sensors (E7xx).
    """
    tell = progress or (lambda what, done, total: None)
    recording = scenario.record()
    inputs = recording.inputs()
    methods = [_method(name, inputs, tell) for name in SHEETS]
    return DemoResult(scenario, recording, methods[0], methods[1])


def _method(name: str, inputs: Arrays, tell: Progress) -> Method:
    frames = len(inputs["vg"])
    tell(f"{name}: read, checked, ordered", 0, 3)
    sheet = saoflow.load(name)
    sheet.check()
    tell(f"{name}: read, checked, ordered", 1, 3)
    budget = sheet.budget()
    budget.raise_if_over()
    tell(f"{name}: read, checked, ordered", 2, 3)
    flying, exact = sheet.simulator(), sheet.simulator(exact=True)
    tell(f"{name}: read, checked, ordered", 3, 3)
    start = time.perf_counter()
    outputs = flying.run(inputs, progress=lambda done: tell(f"{name}: flying, tables", done, frames))
    seconds = time.perf_counter() - start
    tell(f"{name}: flying, tables", frames, frames)
    without = exact.run(inputs, progress=lambda done: tell(f"{name}: flying, exact functions", done, frames))
    tell(f"{name}: flying, exact functions", frames, frames)
    return Method(sheet, budget, outputs, without, _reference(name, inputs, tell), seconds)


def _reference(name: str, inputs: Arrays, tell: Progress) -> Arrays:
    """The numpy reference's outputs, (frames, *shape)."""
    from verification.reference.estimator import Outputs
    from verification.reference.inputs import frames as frames_of
    from verification.reference.tuning import Tuning

    module = _module(name)
    tuning = Tuning()
    state = module.initial_state(tuning)
    rows: list[Outputs] = []
    total = len(inputs["vg"])
    for k, frame in enumerate(frames_of(inputs)):
        done = module.step(state, frame, tuning)
        state = done.state
        rows.append(done.outputs)
        if not k % 32:
            tell(f"{name}: numpy reference", k, total)
    tell(f"{name}: numpy reference", total, total)
    return {field.name: np.array([getattr(row, field.name) for row in rows]) for field in fields(Outputs)}


def _module(name: str) -> ModuleType:
    from verification.reference import cmhe_fte, umhe_fte

    return {"cmhe_fte": cmhe_fte, "umhe_fte": umhe_fte}[name]
