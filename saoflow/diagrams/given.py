"""The parameters given to one block, evaluated as its symbol asks for them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from saoflow.blocks.library import AnySymbol
from saoflow.blocks.symbol import Given, Parameter
from saoflow.diagnosis import DiagnosisError, did_you_mean
from saoflow.diagrams.declarations import unit_of
from saoflow.diagrams.expression import Array
from saoflow.diagrams.formula_of import formula_of
from saoflow.diagrams.scope import Scope
from saoflow.diagrams.sheet import Argument


def given_parameters(scope: Scope, symbol: AnySymbol, arguments: Sequence[Argument]) -> dict[str, Given] | None:
    """By name; None after a diagnosis."""
    known = {p.name: p for p in symbol.parameters}
    given: dict[str, Given] = {}
    fine = True
    for argument in arguments:
        name = argument.name.text
        if name not in known:
            names = [*known, *(p.name for p in symbol.ports)]
            scope.report(
                "E206",
                f"`{symbol.name}` has no parameter `{name}`",
                argument.name.position,
                f"its parameters are: {', '.join(known) or 'none'}; "
                f"its inputs are: {', '.join(p.name for p in symbol.ports) or 'none'}",
                did_you_mean(name, names) or "leave it out",
            )
            fine = False
            continue
        value = _one_given(scope, known[name], argument)
        fine = fine and value is not None
        if value is not None:
            given[name] = value
    return given if fine else None


def _one_given(scope: Scope, parameter: Parameter, argument: Argument) -> Given | None:
    if parameter.kind in ("word", "flag"):
        return Given(word=argument.text)
    if parameter.kind == "unit":
        items = argument.value.items if isinstance(argument.value, Array) else None
        return unit_of(scope, items, argument.text, argument.position)
    expression = scope.expression_of(argument)
    if expression is None:
        return None
    try:
        if parameter.kind == "formula":
            formula = formula_of(expression, scope.parameters)
            return Given(formula=formula, word=argument.text or str(formula))
    except DiagnosisError as error:
        for diagnosis in error.diagnoses:
            scope.found.add(replace(diagnosis, source_line=scope.sources.line(diagnosis.position)))
        return None
    quantity = scope.value_of(expression)
    if quantity is None:
        return None
    if quantity.text is not None:
        scope.report(
            "E208",
            f"`{argument.name.text}` must be a number",
            argument.position,
            f"it is the word `{quantity.text}`",
            "write a number or an expression of parameters",
        )
        return None
    return Given(np.asarray(quantity.array, dtype=np.float64), quantity.unit)
