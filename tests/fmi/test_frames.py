"""Frames in a unit are the frames of ``run``, to the last bit; steps that are no frames are refused."""

from __future__ import annotations

import gzip
from pathlib import Path

import numpy as np
import pytest

import saoflow
from saoflow.fmi import Unit, build_unit, write_unit
from saoflow.pipeline import LoadedSheet
from tests.fmi.importer import Arrays, Importer, fmpy, random_inputs, scalar_columns, simulated
from tests.sheet_text import same_bits

RECORDING = Path(__file__).parents[2] / "verification/recordings/a320_turbulence_280kt_20000ft.csv.gz"


def flight(sheet: LoadedSheet, frames: int) -> Arrays:
    """Frames of a recorded flight: its truth, and three noisy sensors each for alpha and vc."""
    with gzip.open(RECORDING, "rt", encoding="utf-8") as file:
        table = np.genfromtxt(file, delimiter=",", names=True, max_rows=frames)
    noise = np.random.default_rng(0)
    inputs = {name: table[name].copy() for name in sheet.input_types if name not in ("alpha", "vc")}
    inputs["alpha"] = table["alpha_true"][:, None] + noise.normal(0, 2e-3, (frames, 3))
    inputs["vc"] = table["vc_true"][:, None] + noise.normal(0, 0.5, (frames, 3))
    return inputs


def test_small_sheet_to_the_bit(instance: Importer, mixed: LoadedSheet) -> None:
    inputs = random_inputs(40)
    expected = mixed.simulator().run(inputs)
    instance.initialize()
    found = instance.run(inputs, list(expected))
    for name, values in expected.items():
        assert same_bits(found[name], values), name
    assert instance.get("time") == pytest.approx(40 * 0.02, abs=1e-12)


@pytest.mark.parametrize("version", [3, 2])
def test_binary32_to_the_bit(version: int, mixed: LoadedSheet, tmp_path: Path) -> None:
    inputs = random_inputs(20)
    expected = mixed.simulator(real=32).run(inputs)
    unit = build_unit(mixed, version, real=32, optimisation="-O0")
    importer = Importer(unit, tmp_path)
    assert fmpy.validation.validate_fmu(str(tmp_path / f"unit{version}.fmu")) == []
    importer.initialize()
    found = importer.run(inputs, list(expected))
    for name, values in expected.items():
        assert same_bits(found[name], values.astype(np.float64)), name
    importer.close()


@pytest.fixture(scope="module")
def flown() -> tuple[LoadedSheet, Arrays, Arrays]:
    """The flagship, 200 frames of a flight with a failed sensor and missing samples, and what the interpreter gives."""
    sheet = saoflow.load("cmhe_fte")
    inputs = flight(sheet, 200)
    inputs["alpha"][60:, 1] += 0.1
    inputs["vc"][90:95, 2] = np.nan
    inputs["q"][120] = np.inf
    expected = sheet.simulator().run(inputs)
    assert expected["alpha_faulty"][-1].tolist() == [0, 1, 0]
    return sheet, inputs, expected


@pytest.mark.parametrize("version", [3, 2])
def test_flagship_to_the_bit(version: int, flown: tuple[LoadedSheet, Arrays, Arrays], tmp_path: Path) -> None:
    sheet, inputs, expected = flown
    unit = build_unit(sheet, version, optimisation="-O0")
    importer = Importer(unit, tmp_path)
    assert fmpy.validation.validate_fmu(str(tmp_path / f"unit{version}.fmu")) == []
    importer.initialize()
    found = importer.run(inputs, list(expected))
    for name, values in expected.items():
        assert same_bits(found[name], values), name
    importer.close()
    if version == 2:
        found = simulated(tmp_path / "unit2.fmu", unit, inputs, expected)
        for name, values in scalar_columns(expected).items():
            assert same_bits(found[name], values), name


def test_fmpy_simulates_the_unit_by_itself(mixed: LoadedSheet, tmp_path: Path) -> None:
    """With scalars: fmpy cannot put vectors and scalars into one table of inputs."""
    inputs = random_inputs(30)
    expected = mixed.simulator().run(inputs)
    for version in (3, 2):
        unit = build_unit(mixed, version, scalar=True, optimisation="-O0")
        path = write_unit(unit, tmp_path / f"{version}.fmu")
        found = simulated(path, unit, inputs, expected)
        for name, values in scalar_columns(expected).items():
            assert same_bits(found[name], values), name


def test_a_step_of_several_frames_holds_the_inputs(instance: Importer, mixed: LoadedSheet) -> None:
    inputs = {name: np.repeat(values[:1], 5, axis=0) for name, values in random_inputs(5).items()}
    expected = mixed.simulator().run(inputs)
    instance.initialize()
    for name, values in inputs.items():
        instance.set(name, values[0])
    instance.step(0, 2)
    instance.step(2, 3)
    for name, values in expected.items():
        assert same_bits(instance.get(name), values[-1]), name


@pytest.mark.parametrize(
    ("point", "size", "reason"),
    [
        (0.0, 0.03, "not a whole multiple of the frame period 0.02"),
        (0.0, 0.0200001, "not a whole multiple"),
        (0.0, 0.0, "not a whole multiple"),
        (0.0, -0.02, "not a whole multiple"),
        (0.0, float("nan"), "not a whole multiple"),
        (0.0, float("inf"), "not a whole multiple"),
        (0.02, 0.02, "not where the unit stands"),
        (float("nan"), 0.02, "not where the unit stands"),
        (0.0, 0.4, "beyond the stop time"),
    ],
)
def test_a_wrong_step_is_refused_and_changes_nothing(
    instance: Importer, mixed: LoadedSheet, point: float, size: float, reason: str
) -> None:
    inputs = random_inputs(3)
    expected = mixed.simulator().run(inputs)
    instance.initialize(stop=0.1)
    with pytest.raises(fmpy.fmi1.FMICallException):
        instance.slave.doStep(point, size)
    assert len(instance.messages) == 1
    assert reason in instance.messages[0]
    found = instance.run(inputs, list(expected))
    for name, values in expected.items():
        assert same_bits(found[name], values), name


def test_steps_that_add_up_rounding_are_frames(instance: Importer) -> None:
    instance.initialize()
    time = 0.0
    for k in range(20_000):
        instance.slave.doStep(time, 0.02)
        time += 0.02
        if k == 10_000:
            assert time != (k + 1) * 0.02
    assert instance.get("time") == 20_000 * 0.02


def test_before_the_first_step_outputs_are_the_first_frames(unit: Unit, instance: Importer, mixed: LoadedSheet) -> None:
    inputs = {name: values[:1] for name, values in random_inputs(4, seed=4).items()}
    expected = mixed.simulator().run(inputs)
    for name, values in inputs.items():
        instance.set(name, values[0])
    instance.initialize()
    for _ in range(2):  # looking does not change the state
        assert same_bits(instance.get("sum"), expected["sum"][0])
        assert same_bits(instance.get("memory"), expected["memory"][0])
    instance.step(0)
    assert same_bits(instance.get("memory"), expected["memory"][0])
