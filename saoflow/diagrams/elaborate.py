"""From a sheet to its netlist: every parameter a number, every block a symbol, every shape and unit known."""

from __future__ import annotations

from collections.abc import Mapping

from saoflow.diagnosis import Diagnoses, Diagnosis, did_you_mean
from saoflow.diagrams.expression_value import Quantity
from saoflow.diagrams.netlist import Netlist, Structure, count_instances
from saoflow.diagrams.parameters import complete
from saoflow.diagrams.scope import Scope
from saoflow.diagrams.sheet import Sheet
from saoflow.diagrams.store import SheetStore
from saoflow.diagrams.structure import MOST_NODES, StructureBuilder
from saoflow.diagrams.wire_types import Typer
from saoflow.wires import WireType, wrong_unit_count


def elaborate(sheet: Sheet, store: SheetStore, given: Mapping[str, Quantity] | None = None) -> Netlist:
    """Elaborate a root sheet; ``given`` overrides its parameters by name. Raises DiagnosisError with all that is found."""
    found = Diagnoses()
    given = given or {}
    scope = Scope(sheet.file, store.sources, found)
    declared = [p.name.text for p in sheet.parameters]
    for name in given:
        if name not in declared:
            near = did_you_mean(name, declared)
            found.add(
                Diagnosis(
                    "E206",
                    f"`{sheet.name.text}` has no parameter `{name}`",
                    cause=f"its parameters are: {', '.join(declared) or 'none'}",
                    remedy=near or "name one of them",
                )
            )
    values = complete(scope, sheet, given, {}, None, set())
    found.raise_if_errors()
    structure = StructureBuilder(store, found).build(sheet, values, sheet.name.position)
    assert structure is not None
    misfits = False
    for port in structure.inputs:
        wrong = wrong_unit_count(port.units, port.shape or ())
        if wrong:
            misfits = True
            found.add(
                Diagnosis(
                    "E211",
                    f"the units of `{port.name}` do not fit its shape",
                    port.position,
                    f"{wrong}; without a shape, an input of the sheet that runs is a scalar",
                    "give the input a shape",
                    source_line=store.sources.line(port.position),
                )
            )
    if misfits:
        found.raise_if_errors()
    body = Typer(found, store.sources).body(structure, root_types(structure))
    found.raise_if_errors()
    shown = tuple((name, str(q.array) if q.text is None else q.text) for name, q in values.values)
    netlist = Netlist(body, shown, store.sources)
    blocks, _ = count_instances(netlist)
    if blocks > MOST_NODES:
        # Sheets without state are laid out once, but counted, drawn and traced instance by instance.
        cause = f"it has {blocks} blocks with all its sub-sheets laid out, and at most {MOST_NODES} can be followed"
        scope.report("E219", "the elaborated sheet is too large", sheet.name.position, cause, "lower the counts of folds and maps, or the levels of sheets")
        found.raise_if_errors()
    return netlist


def root_types(structure: Structure) -> tuple[WireType, ...]:
    """The types of a root sheet's inputs: as declared; a scalar where no shape is declared."""
    return tuple(WireType(port.shape or (), port.boolean, port.units) for port in structure.inputs)
