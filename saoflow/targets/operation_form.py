"""One scalar operation as machine instructions, once its operands are where the form wants them."""

from __future__ import annotations

import math
from collections.abc import Sequence

from saoflow.operations import Kind, Table
from saoflow.scheduler.program import Operation
from saoflow.targets.instructions import Machine, Stream
from saoflow.targets.peephole import is_doubling, is_negation
from saoflow.targets.target import Shares

SIMPLE = {
    Kind.ADD: Machine.ADD,
    Kind.SUBTRACT: Machine.ADD,
    Kind.MULTIPLY: Machine.MULTIPLY,
    Kind.RECIPROCAL: Machine.DIVIDE,
}
"""Operations that are one instruction everywhere."""


def search_steps(table: Table) -> int:
    """Comparisons of the search for the interval along all axes: the same for every input."""
    return sum(math.ceil(math.log2(axis.size)) for axis in table.breakpoints if axis.size > 1)


def machine_of(operation: Operation) -> Machine | None:
    """The one instruction of an operation, or None where it is several."""
    if is_negation(operation):
        return Machine.MOVE
    if is_doubling(operation):
        return Machine.ADD
    return SIMPLE.get(operation.kind)


def emit_operation(
    stream: Stream,
    operation: Operation,
    operands: Sequence[int],
    shares: Shares,
    tables: Sequence[Table],
    rest: Machine = Machine.INTEGER,
) -> int:
    """The instructions of an operation on values in registers, without calls and state; the number of the result.

    ``rest`` is the kind of what a measured share has beyond the instructions known by name.
    """
    simple = machine_of(operation)
    if simple is not None:
        return stream.emit(simple, *operands)
    match operation.kind:
        case Kind.MINIMUM | Kind.MAXIMUM:
            flag = stream.emit(Machine.COMPARE, *operands)
            taken = stream.emit(Machine.BRANCH, flag)
            return stream.emit_share(Machine.MOVE if rest is Machine.INTEGER else rest, shares.minimum - 2, taken)
        case Kind.LESS | Kind.LESS_EQUAL:
            flag = stream.emit(Machine.COMPARE, *operands)
            extra = shares.or_equal if operation.kind is Kind.LESS_EQUAL else 0.0
            return stream.emit_share(rest, shares.compare - 1 + extra, flag)
        case Kind.AND | Kind.OR | Kind.NOT:
            return stream.emit_share(rest, shares.logic, *operands)
        case Kind.SELECT:
            taken = stream.emit(Machine.BRANCH, operands[0])
            return stream.emit_share(rest, shares.select - 1, taken, *operands[1:])
        case Kind.LOOKUP:
            return _emit_lookup(stream, tables[operation.detail], operands, shares, rest)
    raise ValueError(operation.kind)


def _emit_lookup(stream: Stream, table: Table, operands: Sequence[int], shares: Shares, rest: Machine) -> int:
    """Limits, a search whose steps each load, compare and branch, and the interpolation."""
    flat = len(table.breakpoints) == 1
    limited = operands[0]
    for u in operands:
        flag = stream.emit(Machine.COMPARE, u)
        flag = stream.emit(Machine.COMPARE, stream.emit(Machine.BRANCH, flag))
        limited = stream.emit(Machine.BRANCH, flag)
    index = limited
    for _ in range(search_steps(table)):
        address = stream.emit_share(rest, shares.lookup_step - 3, index)
        index = stream.emit(Machine.BRANCH, stream.emit(Machine.COMPARE, stream.emit(Machine.LOAD, address), limited))
    fixed = 4 * len(operands)
    if flat and table.linear:
        at = stream.emit_share(rest, max(0.0, shares.lookup - fixed - 6), index)
        x, y, slope = (stream.emit(Machine.LOAD, at) for _ in range(3))
        away = stream.emit(Machine.MULTIPLY, stream.emit(Machine.ADD, limited, x), slope)
        return stream.emit(Machine.ADD, y, away)
    if flat:
        at = stream.emit_share(rest, max(0.0, shares.lookup - fixed - 6), index)
        return stream.emit(Machine.LOAD, at)
    if not table.linear:
        return stream.emit(Machine.LOAD, stream.emit_share(rest, max(0.0, shares.lookup_2d - fixed - 18), index))
    at = stream.emit_share(rest, max(0.0, shares.lookup_2d - fixed - 18), index)
    loads = [stream.emit(Machine.LOAD, at) for _ in range(8)]
    p, q = (stream.emit(Machine.MULTIPLY, stream.emit(Machine.ADD, limited, loads[k]), loads[k + 1]) for k in (0, 2))
    a, b = (stream.emit(Machine.ADD, loads[k], stream.emit(Machine.MULTIPLY, q, loads[k + 1])) for k in (4, 6))
    return stream.emit(Machine.ADD, a, stream.emit(Machine.MULTIPLY, p, stream.emit(Machine.ADD, b, a)))
