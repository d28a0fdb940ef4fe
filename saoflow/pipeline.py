"""The road from YAML to frames, in one place: each stage by name, made once, printable.

text --read--> sheet --elaborate--> netlist --order--> schedule --lower--> frame program --simplify--> frame program
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from saoflow.collector import collector_paused
from saoflow.diagnosis import Diagnosis, DiagnosisError, Note, Position, did_you_mean
from saoflow.diagrams.expression_parser import parse_expression
from saoflow.diagrams.expression_value import Quantity, evaluate
from saoflow.diagrams.sheet import Sheet
from saoflow.diagrams.store import SheetStore
from saoflow.scheduler.program import FrameProgram
from saoflow.scheduler.simulator import Simulator
from saoflow.wires import WireType

# Each stage is imported when it first runs: a sheet whose compiled frames are kept needs none of them.
if TYPE_CHECKING:
    import networkx as nx

    from saoflow.diagrams.netlist import Netlist
    from saoflow.scheduler.budget import BudgetReport
    from saoflow.scheduler.schedule import Schedule

STAGES = ("sheet", "netlist", "schedule", "program", "python")
"""What ``saoflow show --stage`` prints."""


@dataclass(eq=False)
class LoadedSheet:
    """A sheet and every stage after it. Each stage raises DiagnosisError with all that it finds."""

    sheet: Sheet
    store: SheetStore
    given: Mapping[str, Quantity] = field(default_factory=dict)

    @property
    def name(self) -> str:
        """The sheet's name."""
        return self.sheet.name.text

    @cached_property
    def netlist(self) -> Netlist:
        """Every parameter a number, every block a symbol, every shape and unit known."""
        from saoflow.diagrams.elaborate import elaborate

        with collector_paused():
            return elaborate(self.sheet, self.store, self.given)

    @cached_property
    def schedule(self) -> Schedule:
        """The nodes in the order in which they run, checked by a second piece of code."""
        from saoflow.scheduler.schedule import order
        from saoflow.scheduler.validate import validate_schedule

        netlist = self.netlist
        with collector_paused():
            schedule = order(netlist)
            validate_schedule(schedule)
        return schedule

    def program(self, real: int = 64, probes: Collection[str] = ()) -> FrameProgram:
        """What one frame executes, in ``real`` bits, with the probed wires among its results."""
        from saoflow.scheduler.lowering import lower
        from saoflow.scheduler.simplify import simplify
        from saoflow.scheduler.validate import validate_program

        schedule = self.schedule
        with collector_paused():
            program = simplify(lower(schedule, real=real, probes=probes))
            validate_program(program)
        return program

    @cached_property
    def frame_program(self) -> FrameProgram:
        """The program in binary64 without probes: what is counted."""
        return self.program()

    @property
    def input_types(self) -> dict[str, WireType]:
        """Shape, kind and unit of every input, by name."""
        body = self.netlist.root
        return {port.name: body.type_of(port.wire) for port in body.structure.inputs}

    @property
    def output_types(self) -> dict[str, WireType]:
        """Shape, kind and unit of every output, by name."""
        body = self.netlist.root
        return {port.name: body.type_of(port.wire) for port in body.structure.outputs}

    def check(self) -> None:
        """Read, elaborate and order. Raises DiagnosisError; where what is given makes the errors, the last one says so."""
        try:
            _ = self.schedule
        except DiagnosisError as error:
            blame = self._blame(error) if self.given else None
            if blame is None:
                raise
            raise DiagnosisError([*error.diagnoses, blame]) from None

    def _blame(self, error: DiagnosisError) -> Diagnosis | None:
        """Errors deep inside say little about the value that is to blame: a word about it, if without it there are none."""
        if any(d.position is None or d.code == "E208" for d in error.diagnoses):
            return None  # they name the value themselves
        try:
            LoadedSheet(self.sheet, self.store).check()
        except DiagnosisError:
            return None
        given = ", ".join(f"{name} = {_shown(value)}" for name, value in self.given.items())
        declared = [p for p in self.sheet.parameters if p.name.text in self.given]
        notes = tuple(
            Note(f"`{p.name.text}`{f', {p.doc},' if p.doc else ''} is declared here", p.name.position) for p in declared
        )
        cause = "without what is given (`--set`), the sheet has no errors"
        return Diagnosis("E603", f"`{self.name}` cannot be with {given}", None, cause, "give another value", notes=notes)

    def budget(self) -> BudgetReport:
        """Operations per frame by kind and by sub-sheet, against the sheet's budget."""
        from saoflow.scheduler.budget import budget_report

        return budget_report(self.frame_program, self.netlist)

    def simulator(
        self, backend: str = "interpreter", *, real: int = 64, probes: Collection[str] = (), exact: bool = False
    ) -> Simulator:
        """Frames of this sheet. ``exact`` puts the functions of tables in their place (``interpreter`` only).

        Backend ``c`` gives the bits of ``interpreter``; without a C compiler it warns and is the interpreter. Raises
        DiagnosisError E401 for a sheet over its budget, E303 for an unknown probe, E603, E607.
        """
        if real not in (32, 64):
            raise DiagnosisError(
                [Diagnosis("E603", f"real cannot be {real}", cause="reals have 64 or 32 bits", remedy="use real=64")]
            )
        if backend == "c":
            from saoflow.codegen.backend import native_simulator

            compiled = native_simulator(self, real, probes, exact)
            if compiled is not None:
                return compiled
        elif backend != "interpreter":
            raise DiagnosisError(
                [
                    Diagnosis(
                        "E607",
                        f"there is no backend `{backend}`",
                        cause="frames run in the interpreter, or in compiled C",
                        remedy=did_you_mean(backend, ("interpreter", "c")) or "use backend `interpreter` or `c`",
                    )
                ]
            )
        self.budget().raise_if_over()
        return Simulator(self.program(real, probes), exact)

    def graph(self) -> nx.MultiDiGraph:
        """The netlist as a networkx graph: a node per symbol instance, an edge per wire."""
        from saoflow.diagrams.graph import netlist_graph

        return netlist_graph(self.netlist)


def _shown(value: Quantity) -> str:
    """A given value in few characters."""
    array = np.asarray(value.array)
    return value.text or (f"{float(array):g}" if not array.ndim else f"an array of {array.size}")


def load(name: str, parameters: Mapping[str, Any] | None = None) -> LoadedSheet:
    """Read a sheet by path or shipped name; ``parameters`` override its named parameters (numbers, lists, YAML text).

    Raises DiagnosisError.
    """
    store = SheetStore()
    sheet = store.open(str(name))
    given: dict[str, Quantity] = {}
    refused: list[Diagnosis] = []
    for key, value in (parameters or {}).items():
        try:
            given[key] = quantity_of(key, value)
        except DiagnosisError as error:
            refused += error.diagnoses
    if refused:
        raise DiagnosisError(refused)
    return LoadedSheet(sheet, store, given)


def quantity_of(name: str, value: Any) -> Quantity:
    """A parameter value from Python or the command line. Raises DiagnosisError E603, E111."""
    if isinstance(value, str):
        return evaluate(parse_expression(value, Position(f"--set {name}", 1, 1, len(value)), value), {}, (value,))
    try:
        array = np.asarray(value, dtype=np.float64)
    except (TypeError, ValueError, OverflowError):
        array = np.array(np.nan)
    if not array.size or not np.isfinite(array).all():
        raise DiagnosisError(
            [
                Diagnosis(
                    "E603",
                    f"parameter `{name}` cannot be {value!r:.60}",
                    cause="it is no finite number or rectangular list of such numbers",
                    remedy="give a number, a list, or text such as 2*pi",
                )
            ]
        )
    return Quantity(array, None)
