"""The XML files of a unit: ``modelDescription.xml``, and for FMI 3.0 ``sources/buildDescription.xml``."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from xml.etree import ElementTree

from saoflow.fmi.unit_definitions import base_unit
from saoflow.fmi.variables import Value, Variable, structured

_UNPRINTABLE = re.compile("[^\t\n\r\u0020-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")
COMPILER_OPTIONS = "-std=c99 -O2 -ffp-contract=off"


@dataclass(frozen=True, slots=True)
class Facts:
    """What the description says of the unit as a whole. ``period`` in s."""

    version: int
    name: str
    identifier: str
    doc: str
    tool: str
    period: float
    sources: tuple[str, ...]


def model_description(facts: Facts, variables: Sequence[Variable], token: str) -> bytes:
    """``modelDescription.xml`` of FMI 2.0 or 3.0; variables in the order of their value references."""
    two = facts.version == 2
    root = ElementTree.Element(
        "fmiModelDescription",
        {
            "fmiVersion": "2.0" if two else "3.0",
            "modelName": facts.name,
            "guid" if two else "instantiationToken": token,
            "description": plain(facts.doc),
            "generationTool": facts.tool,
            "variableNamingConvention": "structured" if structured([v.name for v in variables]) else "flat",
        },
    )
    _interface(root, facts)
    _units(root, variables)
    categories = ElementTree.SubElement(root, "LogCategories")
    ElementTree.SubElement(
        categories, "Category", name="logStatusError", description="What is refused, and why; logged always."
    )
    ElementTree.SubElement(root, "DefaultExperiment", startTime="0", stepSize=_number(facts.period))
    listed = ElementTree.SubElement(root, "ModelVariables")
    for reference, variable in enumerate(variables):
        (_scalar_variable if two else _variable)(listed, reference, variable)
    _structure(root, two, variables)
    return _text(root)


def build_description(facts: Facts) -> bytes:
    """``sources/buildDescription.xml`` of FMI 3.0."""
    root = ElementTree.Element("fmiBuildDescription", fmiVersion="3.0")
    configuration = ElementTree.SubElement(
        root,
        "BuildConfiguration",
        modelIdentifier=facts.identifier,
        description="C99; every operation must be rounded as written: no contraction, no fast mathematics.",
    )
    files = ElementTree.SubElement(
        configuration, "SourceFileSet", language="C99", compiler="gcc", compilerOptions=COMPILER_OPTIONS
    )
    for name in facts.sources:
        ElementTree.SubElement(files, "SourceFile", name=name)
    return _text(root)


def plain(text: str) -> str:
    """Text on one line, without what XML cannot hold."""
    return " ".join(_UNPRINTABLE.sub("?", text).split())


# -- parts of the model description


def _interface(root: ElementTree.Element, facts: Facts) -> None:
    two = facts.version == 2
    state = "state" if two else "State"
    offers = {
        "modelIdentifier": facts.identifier,
        "needsExecutionTool": "false",
        "canBeInstantiatedOnlyOncePerProcess": "false",
        f"canGetAndSetFMU{state}": "true",
        f"canSerializeFMU{state}": "true",
        "canHandleVariableCommunicationStepSize": "false",
    }
    if not two:
        offers |= {"fixedInternalStepSize": _number(facts.period), "hasEventMode": "false"}
    interface = ElementTree.SubElement(root, "CoSimulation", offers)
    if two:
        files = ElementTree.SubElement(interface, "SourceFiles")
        for name in facts.sources:
            ElementTree.SubElement(files, "File", name=name)


def _units(root: ElementTree.Element, variables: Sequence[Variable]) -> None:
    used = {unit.name: unit for variable in variables for unit in variable.units if unit is not None}
    units = ElementTree.SubElement(root, "UnitDefinitions")
    for name in sorted(used):
        unit = ElementTree.SubElement(units, "Unit", name=name)
        base = base_unit(used[name])
        if base is not None:
            attributes = {power: str(exponent) for power, exponent in base.exponents}
            if base.factor != 1.0:
                attributes["factor"] = _number(base.factor)
            ElementTree.SubElement(unit, "BaseUnit", attributes)


def _variable(parent: ElementTree.Element, reference: int, variable: Variable) -> None:
    """FMI 3.0: an element per variable, arrays with their dimensions."""
    element = ElementTree.SubElement(parent, variable.type, _common(reference, variable))
    _value(element, variable)
    for size in variable.shape:
        ElementTree.SubElement(element, "Dimension", start=str(size))


def _scalar_variable(parent: ElementTree.Element, reference: int, variable: Variable) -> None:
    """FMI 2.0: scalars only, and one type of reals."""
    outer = ElementTree.SubElement(parent, "ScalarVariable", _common(reference, variable))
    _value(ElementTree.SubElement(outer, "Boolean" if variable.type == "Boolean" else "Real"), variable)


def _common(reference: int, variable: Variable) -> dict[str, str]:
    attributes = {"name": variable.name, "valueReference": str(reference)}
    description = plain(variable.description)
    if variable.unit is None and any(variable.units):
        units = ", ".join("1" if unit is None else unit.name for unit in variable.units)
        description = f"{description.rstrip('.')}. Units by element: {units}.".removeprefix(". ")
    if description:
        attributes["description"] = description
    attributes |= {"causality": variable.causality, "variability": variable.variability}
    if variable.causality == "output":
        attributes["initial"] = "calculated"
    elif variable.causality == "local":
        attributes["initial"] = "exact"
    return attributes


def _value(element: ElementTree.Element, variable: Variable) -> None:
    if variable.start:
        element.set("start", " ".join(map(_number, variable.start)))
    if variable.unit is not None:
        element.set("unit", variable.unit.name)


def _structure(root: ElementTree.Element, two: bool, variables: Sequence[Variable]) -> None:
    """Outputs hold between frames and depend on nothing then; at the start they are the first frame's."""
    structure = ElementTree.SubElement(root, "ModelStructure")
    # FMI 2.0 counts variables from 1; FMI 3.0 names them by value reference.
    key, first = ("index", 1) if two else ("valueReference", 0)
    outputs = [str(i + first) for i, variable in enumerate(variables) if variable.causality == "output"]
    if two:
        held = ElementTree.SubElement(structure, "Outputs") if outputs else structure
        for number in outputs:
            ElementTree.SubElement(held, "Unknown", {key: number, "dependencies": ""})
        unknown = ElementTree.SubElement(structure, "InitialUnknowns") if outputs else structure
        for number in outputs:
            ElementTree.SubElement(unknown, "Unknown", {key: number})
        return
    for number in outputs:
        ElementTree.SubElement(structure, "Output", {key: number, "dependencies": ""})
    for number in outputs:
        ElementTree.SubElement(structure, "InitialUnknown", {key: number})


# -- text


def _number(value: Value) -> str:
    """A value as XML Schema writes it, to the last bit."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if math.isfinite(value):
        return repr(float(value))
    return "NaN" if math.isnan(value) else "INF" if value > 0 else "-INF"


def _text(root: ElementTree.Element) -> bytes:
    ElementTree.indent(root)
    text: bytes = ElementTree.tostring(root, encoding="UTF-8", xml_declaration=True)
    return text + b"\n"
