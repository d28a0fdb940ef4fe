"""An importer of units for the tests: fmpy's, driven by the names and shapes of a sheet's ports."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from saoflow.fmi import Unit, write_unit

fmpy = pytest.importorskip("fmpy")
pytest.importorskip("fmpy.validation")  # not imported by fmpy itself

Arrays = dict[str, np.ndarray]

MIXED = """\
sheet: mixed
doc: Booleans, a vector, a matrix, and delays of each; of a scalar, over three frames.
profile: sao
parameters: {gain: {value: 3, unit: m/s, doc: a number, source: "chosen: odd"}, M: [[1, 2], [3, 4.5]]}
inputs:
  u: {shape: [], unit: kt, doc: speed}
  v: {shape: [2], unit: rad}
  P: {shape: [2, 3]}
  on: {shape: [2], type: boolean, doc: switches}
  flag: {shape: [], type: boolean}
blocks:
  late: {delay: u, frames: 3, initial: -1.25, unit: kt}
  sum: {add: [u, late]}
  v_before: {delay: v, initial: [0.5, -7]}
  image: {mul: [M, v_before], product: matrix}
  memory: {add: [P, P_before]}
  P_before: {delay: memory, shape: [2, 3]}
  was: {delay: on, initial: 1, type: boolean, shape: [2]}
  both: {and: [on, was]}
  chosen: {switch: [flag, u, late]}
  not_flag: {not: flag}
outputs:
  sum: {from: sum, unit: kt}
  image: image
  memory: memory
  both: both
  chosen: chosen
  not_flag: not_flag
budget: {period: 0.02}
"""


class Importer:
    """One instance of a unit. Values go in and come out as arrays of the ports' shapes."""

    def __init__(self, unit: Unit, folder: Path, extracted: str = "") -> None:
        """Written to a folder and extracted there, unless it lies ``extracted`` already."""
        path = folder / f"unit{unit.version}.fmu"
        if not extracted:
            write_unit(unit, path)
        self.unit = unit
        self.folder = extracted or fmpy.extract(str(path), unzipdir=str(folder / f"extracted{unit.version}"))
        self.description = fmpy.read_model_description(self.folder)
        self.by_name = {v.name: v for v in self.description.modelVariables}
        self.messages: list[str] = []
        self.allocated: set[int] = set()
        """What the unit has from this importer (FMI 2.0 only)."""
        self.slave = self._slave()

    def _slave(self) -> Any:
        arguments = {
            "guid": self.description.guid if self.unit.version == 2 else self.description.instantiationToken,
            "unzipDirectory": self.folder,
            "modelIdentifier": self.description.coSimulation.modelIdentifier,
            "instanceName": "one",
        }
        if self.unit.version == 3:
            slave = fmpy.fmi3.FMU3Slave(**arguments)
            slave.instantiate(logMessage=lambda _, _status, _category, text: self.messages.append(text.decode()))
            return slave
        slave = fmpy.fmi2.FMU2Slave(**arguments)
        callbacks = fmpy.fmi2.fmi2CallbackFunctions()
        callbacks.logger = fmpy.fmi2.fmi2CallbackLoggerTYPE(
            lambda _, _name, _status, _category, text: self.messages.append(text.decode())
        )
        callbacks.allocateMemory = fmpy.fmi2.fmi2CallbackAllocateMemoryTYPE(self._allocate)
        callbacks.freeMemory = fmpy.fmi2.fmi2CallbackFreeMemoryTYPE(self._free)
        slave.instantiate(callbacks=callbacks)
        return slave

    def _allocate(self, count: int, size: int) -> int:
        address: int = fmpy.fmi2.calloc(count, size)
        self.allocated.add(address)
        return address

    def _free(self, address: int) -> None:
        self.allocated.remove(address)
        fmpy.fmi2.free(address)

    # -- modes

    def initialize(self, stop: float | None = None) -> None:
        """From instantiation to the first step."""
        if self.unit.version == 3:
            self.slave.enterInitializationMode(startTime=0.0, stopTime=stop)
        else:
            self.slave.setupExperiment(startTime=0.0, stopTime=stop)
            self.slave.enterInitializationMode()
        self.slave.exitInitializationMode()

    def close(self) -> None:
        """Free the instance; whatever it took from the importer has come back."""
        self.slave.freeInstance()
        assert not self.allocated

    # -- values

    def _references(self, name: str) -> tuple[str, list[int], tuple[int, ...]]:
        if name in self.by_name:
            variable = self.by_name[name]
            return variable.type, [variable.valueReference], tuple(variable.shape or ())
        parts = [n for n in self.by_name if n.startswith(f"{name}[") and n.endswith("]")]
        index = [tuple(int(i) for i in n[len(name) + 1 : -1].split(",")) for n in parts]
        shape = tuple(np.max(index, axis=0))
        assert index == list(product(*(range(1, n + 1) for n in shape))), "elements are not in row-major order"
        return self.by_name[parts[0]].type, [self.by_name[n].valueReference for n in parts], shape

    def set(self, name: str, value: Any) -> None:
        """Set a variable from an array of its shape."""
        kind, references, shape = self._references(name)
        assert np.shape(value) == shape
        flat = np.ravel(value).tolist()
        if kind == "Boolean":
            flat = [bool(v) for v in flat]
        getattr(self.slave, f"set{kind}")(references, flat)

    def get(self, name: str) -> np.ndarray:
        """A variable as an array of its shape."""
        kind, references, shape = self._references(name)
        read = getattr(self.slave, f"get{kind}")
        size = int(np.prod(shape))
        values = read(references, size) if self.unit.version == 3 else read(references)
        return np.array(values, dtype=np.float64).reshape(shape)

    # -- frames

    def step(self, frame: int, count: int = 1) -> None:
        """The step from a frame, over so many."""
        period = self.unit.period
        self.slave.doStep(frame * period, count * period)

    def run(self, inputs: Mapping[str, np.ndarray], outputs: list[str], first: int = 0) -> Arrays:
        """Step by step through the rows of a recording."""
        rows: dict[str, list[np.ndarray]] = {name: [] for name in outputs}
        for k in range(len(next(iter(inputs.values())))):
            for name, values in inputs.items():
                self.set(name, values[k])
            self.step(first + k)
            for name in outputs:
                rows[name].append(self.get(name))
        return {name: np.array(values) for name, values in rows.items()}


def random_inputs(frames: int, seed: int = 1) -> Arrays:
    """Frames for the sheet ``mixed``, with values that are not numbers among them."""
    draw = np.random.default_rng(seed)
    inputs = {
        "u": draw.normal(size=frames),
        "v": draw.normal(size=(frames, 2)),
        "P": draw.normal(size=(frames, 2, 3)),
        "on": draw.integers(0, 2, size=(frames, 2)),
        "flag": draw.integers(0, 2, size=frames),
    }
    inputs["u"][frames // 2] = np.nan
    inputs["v"][1, 0] = np.inf
    inputs["P"][:, 0, 0] = -0.0
    return inputs


def scalar_columns(arrays: Mapping[str, np.ndarray]) -> Arrays:
    """Arrays by frame as columns, named as scalars are: ``P[1,2]``."""
    columns = {}
    for name, values in arrays.items():
        for index in np.ndindex(values.shape[1:]):
            element = f"[{','.join(str(i + 1) for i in index)}]" if index else ""
            columns[f"{name}{element}"] = values[(slice(None), *index)]
    return columns


def simulated(path: Path, unit: Unit, inputs: Arrays, outputs: Mapping[str, np.ndarray]) -> Arrays:
    """What fmpy records when it simulates a unit of scalars by itself, as columns; without the row before the first step."""
    columns = scalar_columns(inputs)
    booleans = {v.name for v in unit.variables if v.type == "Boolean"}
    frames = len(next(iter(columns.values())))
    kinds = [(name, np.bool_ if name in booleans else np.float64) for name in columns]
    table = np.zeros(frames, dtype=[("time", np.float64), *kinds])
    table["time"] = np.arange(frames) * unit.period
    for name, values in columns.items():
        table[name] = values
    names = list(scalar_columns(outputs))
    result = fmpy.simulate_fmu(
        str(path), input=table, stop_time=frames * unit.period, output_interval=unit.period, output=names
    )
    return {name: result[name][1:].astype(np.float64) for name in names}
