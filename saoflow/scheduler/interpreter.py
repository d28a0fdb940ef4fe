"""The interpreter: frames of a program in Python, one flight with floats or a batch with numpy arrays.

Both give the same bits as the C code. Exact mode puts the function of a table in its place.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from saoflow.diagnosis import Diagnosis, DiagnosisError
from saoflow.formula import compile_array, compile_scalar
from saoflow.operations import Table
from saoflow.scheduler.program import FrameProgram
from saoflow.scheduler.python_printer import ARRAY, SCALAR, print_python
from saoflow.tables.evaluation import TabulateError, prepare

FrameFunction = Callable[[Sequence[Any], Sequence[Any]], tuple[tuple[Any, ...], tuple[Any, ...]]]


@dataclass(frozen=True, slots=True)
class Interpreter:
    """The frame functions of a program, by rate group: from inputs and state to results and new state."""

    program: FrameProgram
    frames: tuple[FrameFunction, ...]
    initial_state: tuple[Any, ...]
    arrays: bool
    """Whether elements are arrays (a batch, or binary32) or Python floats."""


def scalar_interpreter(program: FrameProgram, exact: bool = False) -> Interpreter:
    """For one flight in binary64."""
    assert program.real == 64
    names: dict[str, Any] = {"rz": _reciprocal_of_zero, "on": bool}
    for i, table in enumerate(program.tables):
        names[f"t{i}"] = _exact_scalar(table) if exact else _prepared(table, np.float64).scalar_function()
    frames = _compile(program, names, scalar=True)
    return Interpreter(program, frames, tuple(slot.initial for slot in program.states), False)


def array_interpreter(program: FrameProgram, exact: bool = False) -> Interpreter:
    """For a batch, in the real type of the program."""
    real = np.float64 if program.real == 64 else np.float32
    names: dict[str, Any] = {"where": np.where, "one": real(1.0), "on": _on}
    for i, table in enumerate(program.tables):
        names[f"t{i}"] = _exact_array(table, real) if exact else _prepared(table, real).array_function()
    frames = _compile(program, names, scalar=False)
    state = tuple(_typed(slot.initial, real) for slot in program.states)
    return Interpreter(program, frames, state, True)


def _compile(program: FrameProgram, names: dict[str, Any], scalar: bool) -> tuple[FrameFunction, ...]:
    source = print_python(program, SCALAR if scalar else ARRAY)
    real = np.float64 if program.real == 64 else np.float32
    for i, literal in enumerate(source.literals):
        names[f"k{i}"] = literal.value if scalar else _typed(literal.value, real)
    # The text is ours: generated from numbers, never from a sheet's names.
    exec(compile(source.text, f"<frame program of {program.sheet}>", "exec"), names)
    return tuple(names[f"frame{i}"] for i in range(len(program.groups)))


def _typed(value: float | bool, real: type[np.floating[Any]]) -> Any:
    return np.bool_(value) if isinstance(value, bool) else real(value)


def _prepared(table: Table, real: type[np.floating[Any]]) -> Any:
    try:
        return prepare(table, real)
    except TabulateError as problem:
        raise DiagnosisError(
            [Diagnosis(problem.code, problem.message, cause=problem.cause, remedy=problem.remedy)]
        ) from None


def _on(guard: Any) -> bool:
    """Whether what has a rate runs in this frame: in all flights of a batch alike."""
    return bool(np.ravel(guard)[0])


def _reciprocal_of_zero(x: float) -> float:
    """1 / x for a zero of either sign."""
    return math.copysign(math.inf, x)


def _exact_scalar(table: Table) -> Callable[..., float]:
    if table.function is None:
        return _prepared(table, np.float64).scalar_function()  # type: ignore[no-any-return]
    function = compile_scalar(table.function)
    ends = [(float(x[0]), float(x[-1])) for x in table.breakpoints]
    if len(ends) == 1:
        (low, high) = ends[0]

        def exact(u: float) -> float:
            u = u if u > low else low
            return function(u if u < high else high)

        return exact

    def exact2(*operands: float) -> float:
        return function(*(_limited(u, low, high) for u, (low, high) in zip(operands, ends, strict=True)))

    return exact2


def _limited(u: float, low: float, high: float) -> float:
    u = u if u > low else low
    return u if u < high else high


def _exact_array(table: Table, real: type[np.floating[Any]]) -> Callable[..., np.ndarray]:
    if table.function is None:
        return _prepared(table, real).array_function()  # type: ignore[no-any-return]
    function = compile_array(table.function)
    ends = [(real(x[0]), real(x[-1])) for x in table.breakpoints]

    def exact(*operands: np.ndarray) -> np.ndarray:
        limited = []
        for u, (low, high) in zip(operands, ends, strict=True):
            above = np.where(u > low, u, low)
            limited.append(np.where(above < high, above, high).astype(np.float64))
        return function(*limited).astype(real)

    return exact
