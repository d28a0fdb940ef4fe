"""What a unit says of itself: variables, units, start values, descriptions; fmpy finds nothing to complain of."""

from __future__ import annotations

import math
import zipfile
from pathlib import Path
from xml.etree import ElementTree

import pytest

import saoflow
from saoflow.fmi import Unit, build_unit, write_unit
from saoflow.fmi.unit_definitions import base_unit, shown_unit
from saoflow.pipeline import LoadedSheet
from saoflow.units import Unit as PhysicalUnit
from tests.fmi.importer import fmpy
from tests.sheet_text import sheet_of

SHEETS = Path(__file__).parents[1] / "sheets/good"
GOOD = sorted([*SHEETS.glob("*.yaml"), *SHEETS.glob("*/main.yaml")])


def description(unit: Unit) -> ElementTree.Element:
    """The XML of a unit."""
    return ElementTree.fromstring(dict(unit.files)["modelDescription.xml"])


def findings(unit: Unit, folder: Path) -> list[str]:
    """What fmpy finds wrong with a unit."""
    path = write_unit(unit, folder / "unit.fmu")
    found: list[str] = fmpy.validation.validate_fmu(str(path))
    return found


@pytest.mark.parametrize("version", [3, 2])
@pytest.mark.parametrize("path", GOOD, ids=lambda path: f"{path.parent.stem}-{path.stem}")
def test_valid_for_every_kind_of_sheet(path: Path, version: int, tmp_path: Path) -> None:
    sheet = saoflow.load(str(path))
    stated = sheet.netlist.root.structure.budget is not None and sheet.netlist.root.structure.budget.period
    unit = build_unit(sheet, version, period=None if stated else 0.1, binary=False)
    assert findings(unit, tmp_path) == []


@pytest.mark.parametrize("scalar", [False, True])
def test_variables_of_fmi_3(mixed: LoadedSheet, scalar: bool, tmp_path: Path) -> None:
    unit = build_unit(mixed, 3, scalar=scalar, binary=False)
    assert findings(unit, tmp_path) == []
    root = description(unit)
    variables = {v.get("name"): v for v in root.find("ModelVariables") or ()}
    u = variables["u"]
    assert (u.tag, u.get("unit"), u.get("start"), u.get("description")) == ("Float64", "kt", "0.0", "speed")
    interface = root.find("CoSimulation")
    assert interface is not None
    assert interface.get("fixedInternalStepSize") == "0.02"
    assert interface.get("canHandleVariableCommunicationStepSize") == "false"
    if scalar:
        names = [name for name in variables if (name or "").startswith("P[")]
        assert names == ["P[1,1]", "P[1,2]", "P[1,3]", "P[2,1]", "P[2,2]", "P[2,3]"]
        assert variables["parameters.M[2,2]"].get("start") == "4.5"
        assert variables["state.late[3]"].get("start") == "-1.25"
        return
    assert [d.get("start") for d in variables["P"]] == ["2", "3"]
    assert variables["v"].get("unit") == "rad"
    on = variables["on"]
    assert (on.tag, on.get("start"), [d.get("start") for d in on]) == ("Boolean", "false false", ["2"])
    before = variables["state.v_before"]
    assert (before.get("start"), before.get("causality"), before.get("initial")) == ("0.5 -7.0", "local", "exact")
    gain = variables["parameters.gain"]
    assert (gain.get("start"), gain.get("variability"), gain.get("unit")) == ("3.0", "constant", "m/s")
    assert gain.get("description") == "a number. Source: chosen: odd"


def test_variables_of_fmi_2(mixed: LoadedSheet) -> None:
    root = description(build_unit(mixed, 2, binary=False))
    variables = {v.get("name"): v for v in root.iter("ScalarVariable")}
    real = variables["v[2]"].find("Real")
    assert real is not None
    assert (real.get("unit"), real.get("start")) == ("rad", "0.0")
    assert variables["on[1]"].find("Boolean") is not None
    assert root.get("variableNamingConvention") == "structured"
    assert [f.get("name") for f in root.iter("File")] == ["mixed.c", "fmi2-unit.c"]


def test_parameters_as_they_are_set(tmp_path: Path) -> None:
    text = "sheet: s\nparameters: {k: {value: 2, unit: kt}, twice: {value: 2*k}}\ninputs: {u: {}}\n"
    text += "blocks: {y: {mul: [u, k]}}\noutputs: [y]\nbudget: {period: 1}\n"
    plain, other = (build_unit(sheet_of(tmp_path, text, **given), 3, binary=False) for given in ({}, {"k": "5.5"}))
    assert plain.token != other.token
    starts = {v.name: v.start for v in other.variables if v.variability == "constant"}
    assert starts == {"parameters.k": (5.5,), "parameters.twice": (11.0,)}


@pytest.mark.parametrize(
    ("text", "factor", "exponents"),
    [
        ("kt", 1852 / 3600, {"m": 1, "s": -1}),
        ("kt/s^2", 1852 / 3600, {"m": 1, "s": -3}),
        ("rad", 1.0, {"rad": 1}),
        ("rad/s", 1.0, {"rad": 1, "s": -1}),
        ("deg", math.pi / 180, {"rad": 1}),
        ("deg/s^2", math.pi / 180, {"rad": 1, "s": -2}),
        ("rad^2/s^2", 1.0, {"rad": 2, "s": -2}),
        ("1", 1.0, {}),
        ("m", 1.0, {"m": 1}),
        ("ft", 0.3048, {"m": 1}),
        ("hPa", 100.0, {"kg": 1, "m": -1, "s": -2}),
        ("lbf", 0.45359237 * 9.80665, {"kg": 1, "m": 1, "s": -2}),
        ("degC", 1.0, {"K": 1}),
        ("V/A", 1.0, {"kg": 1, "m": 2, "s": -3, "A": -2}),
        ("%", 0.01, {}),
        ("g0*kg", 9.80665, {"kg": 1, "m": 1, "s": -2}),
    ],
)
def test_units_in_si(text: str, factor: float, exponents: dict[str, int]) -> None:
    shown = shown_unit(PhysicalUnit.parse(text), text)
    assert shown.name == text
    base = base_unit(shown)
    assert base is not None
    assert base.factor == pytest.approx(factor, rel=1e-12)
    assert dict(base.exponents) == exponents


def test_a_unit_that_fmi_cannot_express() -> None:
    assert base_unit(shown_unit(PhysicalUnit.parse("Pa^(1/2)"), None)) is None


def test_a_written_unit_that_is_another_is_not_shown() -> None:
    assert shown_unit(PhysicalUnit.parse("kt"), "rad").name == "kt"


def test_units_by_element(tmp_path: Path) -> None:
    text = "sheet: s\ninputs: {u: {shape: [2], unit: [kt, rad], doc: two}}\nblocks: {y: {add: [u, u]}}\n"
    sheet = sheet_of(tmp_path, text + "outputs: [y]\nbudget: {period: 1}\n")
    three, two = (build_unit(sheet, version, binary=False) for version in (3, 2))
    u = next(v for v in description(three).iter("Float64") if v.get("name") == "u")
    assert u.get("unit") is None
    assert u.get("description") == "two. Units by element: kt, 1."
    assert [v.find("Real").get("unit") for v in description(two).iter("ScalarVariable")][1:3] == ["kt", None]  # type: ignore[union-attr]
    assert findings(three, tmp_path) == findings(two, tmp_path) == []


def test_text_that_xml_cannot_hold(tmp_path: Path) -> None:
    text = 'sheet: s\ndoc: "a <b> & \\"c\\" \\x07\\nline"\ninputs: {u: {doc: "*/ <&"}}\nblocks: {y: {add: [u, 1]}}\n'
    unit = build_unit(sheet_of(tmp_path, text + "outputs: [y]\nbudget: {period: 1}\n"), 3, optimisation="-O0")
    assert findings(unit, tmp_path) == []
    assert description(unit).get("description") in ('a <b> & "c" ? line', 'a <b> & "c" line')


def test_names_of_other_alphabets_keywords_and_time(tmp_path: Path) -> None:
    text = "sheet: s\ninputs: {time: {}, int: {}, größe: {}, struct: {}}\n"
    text += "blocks: {y: {add: [time, int, größe, struct]}}\noutputs: [y]\nbudget: {period: 1}\n"
    for version in (3, 2):
        unit = build_unit(sheet_of(tmp_path, text), version, optimisation="-O0")
        assert findings(unit, tmp_path) == []
        assert [v.name for v in unit.variables[:5]] == ["time_", "time", "int", "größe", "struct"]
        assert description(unit).get("variableNamingConvention") == "flat"


def test_a_port_that_comes_in_and_goes_out(tmp_path: Path) -> None:
    text = (
        "sheet: s\ninputs: {x: {}, x_out: {}}\nblocks: {y: {add: [x, x_out]}}\noutputs: [x, y]\nbudget: {period: 1}\n"
    )
    unit = build_unit(sheet_of(tmp_path, text), 3, binary=False)
    assert findings(unit, tmp_path) == []
    assert [(v.name, v.causality) for v in unit.variables[3:]] == [("x_out_", "output"), ("y", "output")]


def test_without_inputs_or_state(tmp_path: Path) -> None:
    text = "sheet: s\nblocks: {y: {constant: 2.5}}\noutputs: [y]\nbudget: {period: 0.5}\n"
    for version in (3, 2):
        unit = build_unit(sheet_of(tmp_path, text), version, optimisation="-O0")
        assert findings(unit, tmp_path) == []
        result = fmpy.simulate_fmu(str(tmp_path / "unit.fmu"), stop_time=1.0)
        assert result["y"].tolist() == [2.5] * 3


def test_the_same_bytes_each_time(mixed: LoadedSheet, tmp_path: Path) -> None:
    first, second = (write_unit(build_unit(mixed, 3, binary=False), tmp_path / f"{n}.fmu") for n in "ab")
    assert first.read_bytes() == second.read_bytes()
    with zipfile.ZipFile(first) as file:
        assert sorted(file.namelist()) == [
            "modelDescription.xml",
            "sources/buildDescription.xml",
            "sources/fmi-memory.h",
            "sources/fmi-model.h",
            "sources/fmi-unit.h",
            "sources/fmi3-api.h",
            "sources/fmi3-refusals.h",
            "sources/fmi3-unit.c",
            "sources/mixed.c",
            "sources/mixed.h",
        ]
