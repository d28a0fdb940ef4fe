"""States of a unit: saved, restored, serialised, set from outside, started again; instances share nothing."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from saoflow.fmi import Unit
from saoflow.pipeline import LoadedSheet
from tests.fmi.importer import Arrays, Importer, fmpy, random_inputs
from tests.sheet_text import same_bits

OUTPUTS = ["sum", "image", "memory", "both", "chosen"]


def part(inputs: Arrays, first: int, last: int) -> Arrays:
    """Some frames of a recording."""
    return {name: values[first:last] for name, values in inputs.items()}


def call(importer: Importer, name: str) -> Callable[..., Any]:
    """A state function by its name in FMI 3.0; FMI 2.0 spells it otherwise."""
    other = {"deserializeFMUState": "deSerializeFMUstate"}
    two = other.get(name, name.replace("FMUState", "FMUstate"))
    found: Callable[..., Any] = getattr(importer.slave, name if importer.unit.version == 3 else two)
    return found


def equal(found: Arrays, expected: Arrays, first: int, last: int) -> None:
    for name in OUTPUTS:
        assert same_bits(found[name], expected[name][first:last]), name


def test_saved_and_restored(instance: Importer, mixed: LoadedSheet) -> None:
    inputs = random_inputs(30)
    expected = mixed.simulator().run(inputs)
    instance.initialize()
    instance.run(part(inputs, 0, 10), OUTPUTS)
    state = call(instance, "getFMUState")()
    equal(instance.run(part(inputs, 10, 30), OUTPUTS, 10), expected, 10, 30)
    for _ in range(2):
        call(instance, "setFMUState")(state)
        assert instance.get("time") == 10 * 0.02
        assert same_bits(instance.get("sum"), expected["sum"][9])
        equal(instance.run(part(inputs, 10, 30), OUTPUTS, 10), expected, 10, 30)
    call(instance, "freeFMUState")(state)


def test_serialised_into_another_instance(unit: Unit, instance: Importer, mixed: LoadedSheet, tmp_path: Path) -> None:
    inputs = random_inputs(30)
    expected = mixed.simulator().run(inputs)
    instance.initialize()
    instance.run(part(inputs, 0, 10), OUTPUTS)
    state = call(instance, "getFMUState")()
    data = call(instance, "serializeFMUState")(state)
    call(instance, "freeFMUState")(state)
    (tmp_path / "other").mkdir()
    other = Importer(unit, tmp_path / "other")
    other.initialize()
    again = call(other, "deserializeFMUState")(data)
    call(other, "setFMUState")(again)
    equal(other.run(part(inputs, 10, 30), OUTPUTS, 10), expected, 10, 30)
    call(other, "freeFMUState")(again)
    other.close()


@pytest.mark.parametrize("place", [0, 9, 20, 60, -9])
def test_a_damaged_state_is_refused(instance: Importer, place: int) -> None:
    instance.initialize()
    state = call(instance, "getFMUState")()
    data = bytearray(call(instance, "serializeFMUState")(state))
    data[place] ^= 1
    with pytest.raises(fmpy.fmi1.FMICallException):
        call(instance, "deserializeFMUState")(bytes(data))
    with pytest.raises(fmpy.fmi1.FMICallException):
        call(instance, "deserializeFMUState")(bytes(data[:-9]))
    assert instance.messages == ["the serialised state is damaged, or another unit's"] * 2
    call(instance, "freeFMUState")(state)


def test_reset_starts_again(instance: Importer, mixed: LoadedSheet) -> None:
    inputs = random_inputs(12)
    expected = mixed.simulator().run(inputs)
    for _ in range(2):
        instance.initialize()
        equal(instance.run(inputs, OUTPUTS), expected, 0, 12)
        instance.slave.terminate()
        instance.slave.reset()


def test_delays_start_as_set(instance: Importer, mixed: LoadedSheet) -> None:
    """What a run leaves in the delays, set in a fresh instance: it goes on from there."""
    inputs = random_inputs(20)
    simulator = mixed.simulator()
    expected = simulator.run(inputs)
    names = ["state.late", "state.v_before", "state.P_before", "state.was"]
    instance.initialize()
    instance.run(part(inputs, 0, 7), OUTPUTS)
    kept = {name: instance.get(name) for name in names}
    instance.slave.reset()
    assert instance.get("state.late").tolist() == [-1.25] * 3
    assert instance.get("state.v_before").tolist() == [0.5, -7]
    assert instance.get("state.was").tolist() == [1, 1]
    for name in names:
        instance.set(name, kept[name])
    instance.initialize()
    equal(instance.run(part(inputs, 7, 20), OUTPUTS), expected, 7, 20)


def test_instances_share_nothing(unit: Unit, instance: Importer, mixed: LoadedSheet, tmp_path: Path) -> None:
    (tmp_path / "other").mkdir()
    other = Importer(unit, tmp_path / "other")
    runs = [(instance, random_inputs(15, 2)), (other, random_inputs(15, 3))]
    expected = [mixed.simulator().run(inputs) for _, inputs in runs]
    for importer, _ in runs:
        importer.initialize()
    for k in range(15):
        for (importer, inputs), right in zip(runs, expected, strict=True):
            equal(importer.run(part(inputs, k, k + 1), OUTPUTS, k), right, k, k + 1)
    other.close()


@pytest.mark.parametrize(
    ("name", "value", "reason"),
    [
        ("sum", 1.0, "cannot be set at all"),
        ("parameters.gain", 1.0, "cannot be set at all"),
        ("time", 1.0, "cannot be set at all"),
        ("state.v_before", np.zeros(2), "cannot be set in this mode of the unit"),
    ],
)
def test_what_cannot_be_set(instance: Importer, name: str, value: Any, reason: str) -> None:
    instance.initialize()
    with pytest.raises(fmpy.fmi1.FMICallException):
        instance.set(name, value)
    assert reason in instance.messages[0]


def test_unknown_variables_and_wrong_types(instance: Importer) -> None:
    real = "Float64" if instance.unit.version == 3 else "Real"
    flag = instance.by_name["flag"].valueReference
    for references in ([flag], [9999]):
        with pytest.raises(fmpy.fmi1.FMICallException):
            getattr(instance.slave, f"get{real}")(references)
    with pytest.raises(fmpy.fmi1.FMICallException):
        instance.slave.getString([0])
    assert "another type" in instance.messages[0]
    assert "no variable with value reference 9999" in instance.messages[1]
    with pytest.raises(fmpy.fmi1.FMICallException):
        instance.step(0)  # before initialisation
    assert "not allowed in this mode" in instance.messages[-1]
