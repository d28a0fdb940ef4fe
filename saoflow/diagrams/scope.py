"""What a name means inside one sheet: an input, a block's outputs, a fold's instances, or a parameter."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace

from saoflow.diagnosis import Diagnoses, Diagnosis, DiagnosisError, Note, Position, did_you_mean
from saoflow.diagrams.expression import Expression
from saoflow.diagrams.expression_value import Quantity, evaluate
from saoflow.diagrams.netlist import POISON, Node, SourceLines
from saoflow.diagrams.sheet import Argument


@dataclass(frozen=True, slots=True)
class Ports:
    """The output wires of one block by port name; of a fold or map, of each instance."""

    instances: tuple[dict[str, int], ...]
    stacked: bool
    """True for a fold or map: its outputs are stacks."""

    @property
    def names(self) -> list[str]:
        """The port names."""
        return list(self.instances[0]) if self.instances else []


POISONED = Ports((), False)
"""The ports of a block that is already diagnosed."""


@dataclass(slots=True)
class Scope:
    """The names of one sheet, and the nodes and wires made so far."""

    file: str
    sources: SourceLines
    found: Diagnoses
    inputs: dict[str, int] = field(default_factory=dict)
    blocks: dict[str, Ports] = field(default_factory=dict)
    parameters: dict[str, Quantity] = field(default_factory=dict)
    broken_parameters: set[str] = field(default_factory=set)
    nodes: list[Node] = field(default_factory=list)
    wire_count: int = 0
    constants: dict[str, int] = field(default_factory=dict)
    """Wires of parameters that are used as constants."""

    def new_wire(self) -> int:
        """The number of a further wire."""
        self.wire_count += 1
        return self.wire_count - 1

    def report(
        self,
        code: str,
        message: str,
        position: Position | None,
        cause: str,
        remedy: str,
        label: str = "",
        notes: Iterable[Note] = (),
    ) -> int:
        """Remember a diagnosis; returns POISON, so that a caller can return it as the wire."""
        self.found.add(
            Diagnosis(code, message, position, cause, remedy, label, tuple(notes), self.sources.line(position))
        )
        return POISON

    def expression_of(self, argument: Argument) -> Expression | None:
        """What is given as an expression; None after a diagnosis if it is none."""
        if argument.value is None:
            self.report(
                "E111",
                f"`{argument.name.text}` is no expression",
                argument.position,
                f"`{argument.text}` cannot be read as numbers, parameters and + - * / ^",
                "write a number or an expression of parameters",
            )
        return argument.value

    def value_of(self, expression: Expression, names: Mapping[str, Quantity] | None = None) -> Quantity | None:
        """The value of an expression of parameters; None after a diagnosis."""
        names = self.parameters if names is None else names
        try:
            return evaluate(expression, names, self.sources.lines(expression.position.file))
        except DiagnosisError as error:
            for diagnosis in error.diagnoses:
                if not any(f"`{name}`" in diagnosis.message for name in self.broken_parameters):
                    self.found.add(self._wire_meant(diagnosis))
            return None

    def _wire_meant(self, diagnosis: Diagnosis) -> Diagnosis:
        """A better cause where an unknown parameter is the name of a wire."""
        name = self.sources.word(diagnosis.position)
        if diagnosis.code != "E206" or name not in {*self.inputs, *self.blocks}:
            return diagnosis
        return replace(
            diagnosis,
            message=f"`{name}` is a wire, and a number is needed here",
            cause="numbers such as counts, shapes, indices and table data are fixed before the first frame",
            remedy="use a number or a parameter; what follows a wire is done with blocks",
        )

    def known(self) -> list[str]:
        """Every name of the sheet, for did-you-mean."""
        return [*self.inputs, *self.blocks, *self.parameters]

    def unknown_wire(self, name: str, position: Position) -> int:
        """Diagnose a name that means nothing here."""
        if name in self.broken_parameters:
            return POISON
        remedy = did_you_mean(name, self.known()) or "declare it, or correct the name"
        if name.lower() in ("true", "false"):
            remedy = f"give the constant a block: {{constant: {int(name.lower() == 'true')}, type: boolean}}"
        cause = "the sheet has no input, block or parameter of that name"
        return self.report("E202", f"unknown wire `{name}`", position, cause, remedy)
