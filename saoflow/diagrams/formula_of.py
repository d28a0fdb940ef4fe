"""From an expression in x and y to the formula that a table approximates."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from saoflow.diagnosis import Diagnosis, DiagnosisError, did_you_mean
from saoflow.diagrams.expression import Binary, Call, Expression, Name, Unary
from saoflow.diagrams.expression_value import Quantity, evaluate, names_in
from saoflow.formula import FUNCTIONS, NAMED, Formula, FormulaError

_BINARY = {"+": "add", "-": "subtract", "*": "multiply", "/": "divide", "^": "power"}


def formula_of(expression: Expression, parameters: Mapping[str, Quantity]) -> Formula:
    """The formula in x (and y); other names are parameters. A bare name is a named function: ``sin``.

    Raises DiagnosisError E208 or E209.
    """
    if isinstance(expression, Name) and expression.text not in ("x", "y"):
        if expression.text in NAMED:
            return NAMED[expression.text]
        raise DiagnosisError(
            [
                Diagnosis(
                    "E208",
                    f"unknown function `{expression.text}`",
                    expression.position,
                    f"named functions: {', '.join(NAMED)}",
                    did_you_mean(expression.text, NAMED) or "name one of them, or write a formula in x: (1 + x)^3.5",
                )
            ]
        )
    try:
        return _formula(expression, parameters)
    except FormulaError as error:
        raise DiagnosisError(
            [Diagnosis("E208", "this is no formula", expression.position, str(error), "write a formula in x: x^2 + 1")]
        ) from None


def _formula(expression: Expression, parameters: Mapping[str, Quantity]) -> Formula:
    variables = [n.text for n in names_in(expression) if n.text in ("x", "y")]
    if not variables:
        return _constant(expression, parameters)
    match expression:
        case Name():
            return Formula(expression.text)
        case Unary(operator="-"):
            return Formula("negate", (_formula(expression.operand, parameters),))
        case Unary():
            return _formula(expression.operand, parameters)
        case Binary():
            operands = (_formula(expression.left, parameters), _formula(expression.right, parameters))
            return Formula(_BINARY[expression.operator], operands)
        case Call() if expression.function.text in FUNCTIONS and len(expression.arguments) == 1:
            return Formula(expression.function.text, (_formula(expression.arguments[0], parameters),))
        case Call():
            near = did_you_mean(expression.function.text, FUNCTIONS)
            raise FormulaError(f"`{expression.function.text}` is not among {', '.join(FUNCTIONS)}; {near}".rstrip("; "))
    raise FormulaError("only + - * / ^, numbers, parameters, x, y and functions of them")


def _constant(expression: Expression, parameters: Mapping[str, Quantity]) -> Formula:
    value = np.asarray(evaluate(expression, parameters).array, dtype=np.float64)
    if value.ndim:
        raise FormulaError("an array cannot stand in a formula")
    return Formula("constant", (), float(value))
