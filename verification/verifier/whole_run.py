"""A sheet against a plain function of whole runs: what a user writes for a sheet of their own."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from saoflow import Diagnosis, DiagnosisError, LoadedSheet
from verification.verifier.case import Array, FunctionReference, Scenario
from verification.verifier.comparison import Worst, relative_difference
from verification.verifier.frame_by_frame import Progress
from verification.verifier.report import Check


def compare_runs(
    sheet: LoadedSheet, reference: FunctionReference, scenarios: tuple[Scenario, ...], progress: Progress
) -> tuple[Check, ...]:
    """Compare all outputs of every scenario: with the functions in place of the tables, then with the tables.

    The second comparison carries no verdict: how far a table may move an output is the sheet's own affair.

    Raises :class:`saoflow.DiagnosisError` E604 if the function fails, or gives other outputs than the sheet.
    """
    exact, tables = sheet.simulator(exact=True), sheet.simulator()
    shapes = {port.name: port.type.shape for port in exact.program.outputs}
    outputs = list(shapes)
    tabulated = any(table.function is not None for table in exact.program.tables)
    worst = {(name, kind): Worst() for kind in ("exact", "tables") for name in outputs}
    for scenario in scenarios:
        right = _reference_outputs(reference, scenario, shapes, sheet.name)
        for kind, simulator in (("exact", exact), ("tables", tables)):
            if kind == "tables" and not tabulated:
                continue
            simulator.reset()
            got = simulator.run(scenario.inputs)
            for name in outputs:
                sigma = reference.sigma.get(name) or _magnitude(right[name])
                ratio = relative_difference(got[name], right[name], sigma) / reference.tolerance
                worst[name, kind].see(scenario, np.arange(float(len(scenario))), got[name], right[name], ratio)
        progress(len(scenario))
    tolerance = f"{reference.tolerance:g} max(|ref|, sigma)"
    checks = [worst[n, "exact"].check("run, exact functions", n, n, "", tolerance) for n in outputs]
    if tabulated:
        shown = [worst[n, "tables"].check("run, tables", n, n, "", "shown", judged=False) for n in outputs]
        checks += [replace(check, ratio=check.ratio * reference.tolerance) for check in shown]
    return tuple(checks)


def _magnitude(values: Array) -> float:
    finite = np.abs(values[np.isfinite(values)])
    return float(finite.max()) or 1.0 if finite.size else 1.0


def _reference_outputs(
    reference: FunctionReference, scenario: Scenario, shapes: Mapping[str, tuple[int, ...]], sheet: str
) -> dict[str, Array]:
    try:
        with np.errstate(all="ignore"):
            given = reference.run({name: np.array(column) for name, column in scenario.inputs.items()})
    except Exception as error:
        raise _unusable(sheet, f"it raised {type(error).__name__}: {error}") from error
    if not isinstance(given, Mapping):
        raise _unusable(sheet, f"it gave {type(given).__name__}, not a dictionary of arrays")
    if missing := [name for name in shapes if name not in given]:
        raise _unusable(sheet, f"it gave no {', '.join(missing)}; it gave {', '.join(map(str, given)) or 'nothing'}")
    right: dict[str, Array] = {}
    for name, shape in shapes.items():
        try:
            right[name] = np.asarray(given[name], dtype=np.float64)
        except (TypeError, ValueError) as error:
            raise _unusable(sheet, f"its {name} is not an array of numbers: {error}") from error
        if right[name].shape != (len(scenario), *shape):
            found, expected = list(right[name].shape), [len(scenario), *shape]
            raise _unusable(sheet, f"its {name} has shape {found}, expected is {expected}")
    return right


def _unusable(sheet: str, cause: str) -> DiagnosisError:
    return DiagnosisError(
        [
            Diagnosis(
                "E604",
                f"the reference of `{sheet}` cannot be used",
                cause=cause,
                remedy="a reference takes a dictionary of input arrays, one row a frame, and gives one of output arrays",
            )
        ]
    )


def random_scenarios(sheet: LoadedSheet, frames: int, seed: int) -> tuple[Scenario, ...]:
    """Runs with random inputs: standard normal; of widely different magnitudes; piecewise constant."""
    generator = np.random.default_rng([seed, 7])
    count = min(3, frames)
    lengths = [frames // count + (i < frames % count) for i in range(count)]
    scenarios = []
    for name, length in zip(("normal inputs", "wide inputs", "steps"), lengths, strict=False):
        inputs = {}
        for port in sheet.frame_program.inputs:
            values = _draw(name, (length, *port.type.shape), generator)
            inputs[port.name] = (values > 0.0).astype(np.float64) if port.type.boolean else values
        scenarios.append(Scenario(name, inputs, fault_free=True))
    return tuple(scenarios)


def _draw(kind: str, shape: tuple[int, ...], generator: np.random.Generator) -> Array:
    if kind == "steps":
        steps: Array = np.repeat(generator.normal(0.0, 3.0, shape), 10, axis=0)[: shape[0]]
        return steps
    values = generator.standard_normal(shape)
    return values * 10.0 ** generator.uniform(-3.0, 3.0, shape) if kind == "wide inputs" else values
