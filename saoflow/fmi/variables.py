"""The variables of a unit: ports, remembered values and parameters of a sheet, as FMI sees them.

Ports are ``input`` and ``output`` variables. What delays remember are ``local`` variables ``state.PATH``, whose start
values are the initial values in the sheets. Parameters became numbers when the code was generated; a value that cannot
change is a ``constant`` in FMI (``parameters.NAME``), never a ``parameter``, which an importer could set.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import product
from typing import TYPE_CHECKING

from saoflow.codegen.interface import Interface
from saoflow.fmi.unit_definitions import UnitDefinition, shown_unit
from saoflow.units import DIMENSIONLESS, Unit, Units
from saoflow.wires import WireType

if TYPE_CHECKING:
    from saoflow.diagrams.sheet import Sheet, UnitText
    from saoflow.pipeline import LoadedSheet
    from saoflow.scheduler.program import FrameProgram

Value = float | bool

TIME = UnitDefinition("s", Unit.parse("s"))


@dataclass(frozen=True, slots=True)
class Variable:
    """A variable of the model description; its value reference is its place in the list.

    ``place``: the member of Memory in C where its first element lies, or the number of its first constant, or nothing
    (time). ``start`` holds one value per element (none for outputs and time).
    """

    name: str
    type: str
    """``Float64``, ``Float32`` or ``Boolean``."""
    causality: str
    variability: str
    shape: tuple[int, ...]
    start: tuple[Value, ...]
    units: tuple[UnitDefinition | None, ...]
    """One per element."""
    description: str
    place: str | int | None

    @property
    def size(self) -> int:
        """How many scalars."""
        return len(self.units)

    @property
    def unit(self) -> UnitDefinition | None:
        """The unit, where all elements have the same."""
        return self.units[0] if all(unit == self.units[0] for unit in self.units) else None


def variables(sheet: LoadedSheet, program: FrameProgram, interface: Interface) -> tuple[Variable, ...]:
    """All variables of a unit: time, inputs, outputs, remembered values, parameters. Names are unique."""
    real = "Float64" if program.real == 64 else "Float32"
    found = [*_ports(sheet, program, interface, real), *_states(sheet, program, interface, real), *_parameters(sheet)]
    taken = {variable.name for variable in found}
    clock = Variable(
        _free("time", taken), "Float64", "independent", "continuous", (), (), (TIME,), "Simulation time.", None
    )
    return (clock, *found)


def _ports(sheet: LoadedSheet, program: FrameProgram, interface: Interface, real: str) -> Iterator[Variable]:
    written = _written_units(sheet.sheet)
    for port, name in zip(program.inputs, interface.inputs, strict=True):
        zero: Value = False if port.type.boolean else 0.0
        yield Variable(
            port.name,
            "Boolean" if port.type.boolean else real,
            "input",
            "discrete",
            port.type.shape,
            (zero,) * port.type.size,
            _units(port.type, written.get(("input", port.name))),
            port.doc,
            f"input.{name}",
        )
    taken = {port.name for port in (*program.inputs, *program.outputs)}
    for port, name in zip(program.outputs, interface.outputs, strict=True):
        shown = port.name
        if any(port.name == other.name for other in program.inputs):  # a port that comes in and goes out
            shown = _free(f"{port.name}_out", taken)
            taken.add(shown)
        yield Variable(
            shown,
            "Boolean" if port.type.boolean else real,
            "output",
            "discrete",
            port.type.shape,
            (),
            _units(port.type, written.get(("output", port.name))),
            port.doc,
            f"output.{name}",
        )


def _free(name: str, taken: set[str]) -> str:
    """The name, with as many underscores as make it another than those taken."""
    while name in taken:
        name += "_"
    return name


def _states(sheet: LoadedSheet, program: FrameProgram, interface: Interface, real: str) -> Iterator[Variable]:
    types = _delay_types(sheet)
    for field in interface.states:
        wire = types.get(field.path)
        slots = program.states[field.first : field.first + field.size]
        # A delay of several frames remembers its wire several times: then the elements are a plain list.
        fits = wire is not None and wire.size == field.size
        of_element = wire.element_units() if wire is not None else (None,)
        yield Variable(
            f"state.{field.path}",
            "Boolean" if field.boolean else real,
            "local",
            "discrete",
            wire.shape if wire is not None and fits else (field.size,) if field.size > 1 else (),
            tuple(slot.initial for slot in slots),
            tuple(_defined(of_element[slot.element % len(of_element)], None) for slot in slots),
            f"What the delay {field.path} remembers.",
            f"state.{field.name}",
        )


def _delay_types(sheet: LoadedSheet) -> dict[str, WireType]:
    """The type of what every node of the netlist gives out, by the node's path (the first output)."""
    from saoflow.diagrams.netlist import flat_nodes

    return {
        path: body.type_of(node.outputs[0])
        for path, node, body in flat_nodes(sheet.netlist.root)
        if node.outputs and not node.feeds_through
    }


def _parameters(sheet: LoadedSheet) -> Iterator[Variable]:
    from saoflow.diagnosis import Diagnoses
    from saoflow.diagrams.parameters import complete
    from saoflow.diagrams.scope import Scope

    source = sheet.sheet
    values = complete(Scope(source.file, sheet.store.sources, Diagnoses()), source, sheet.given, {}, None, set())
    declared = {p.name.text: p for p in source.parameters}
    written = _written_units(source)
    first = 0
    for name, quantity in values.values:
        if quantity.text is not None or not quantity.array.size:
            continue
        wire = WireType(tuple(quantity.array.shape), False, quantity.unit)
        texts = [declared[name].doc.rstrip("."), f"Source: {declared[name].source}" if declared[name].source else ""]
        yield Variable(
            f"parameters.{name}",
            "Float64",
            "local",
            "constant",
            wire.shape,
            tuple(float(v) for v in quantity.array.ravel()),
            _units(wire, written.get(("parameter", name))),
            ". ".join(text for text in texts if text),
            first,
        )
        first += wire.size


# -- units


def _written_units(sheet: Sheet) -> dict[tuple[str, str], str]:
    """The units as the sheet writes them (``rad`` stays ``rad``), where one is written for a whole wire."""
    ports: list[tuple[str, str, UnitText | None]] = [("input", p.name.text, p.unit) for p in sheet.inputs]
    ports += [("output", p.name.text, p.unit) for p in sheet.outputs]
    ports += [("parameter", p.name.text, p.unit) for p in sheet.parameters]
    return {(kind, name): unit.items for kind, name, unit in ports if unit and isinstance(unit.items, str)}


def _units(wire: WireType, written: str | None) -> tuple[UnitDefinition | None, ...]:
    if wire.boolean:
        return (None,) * wire.size
    return tuple(_defined(unit, written) for unit in wire.element_units())


def _defined(unit: Units, written: str | None) -> UnitDefinition | None:
    if not isinstance(unit, Unit) or (unit is DIMENSIONLESS and written is None):
        return None
    return shown_unit(unit, written)


# -- names and scalars


def scalars(variable: Variable) -> Iterator[Variable]:
    """The elements of a variable, each a scalar: ``alpha[1]``, ``P[1,2]`` (structured names of FMI)."""
    if not variable.shape:
        yield variable
        return
    places = product(*(range(1, n + 1) for n in variable.shape))
    for k, index in enumerate(places):
        place = variable.place
        yield replace(
            variable,
            name=f"{variable.name}[{','.join(map(str, index))}]",
            shape=(),
            start=variable.start[k : k + 1],
            units=variable.units[k : k + 1],
            place=place + k if isinstance(place, int) else f"{place}[{k}]",
        )


_STRUCTURED = re.compile(
    r"[A-Za-z_][A-Za-z0-9_]*(\[\d+(,\d+)*\])?(\.[A-Za-z_][A-Za-z0-9_]*(\[\d+(,\d+)*\])?)*", re.ASCII
)


def structured(names: Sequence[str]) -> bool:
    """Whether all names follow FMI's naming convention ``structured`` (else it is ``flat``)."""
    return all(_STRUCTURED.fullmatch(name) for name in names)
