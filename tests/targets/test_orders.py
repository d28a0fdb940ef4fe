"""The orders that the model takes from GCC against orders made by hand, and what every order must keep."""

from __future__ import annotations

from pathlib import Path

import pytest

import saoflow
from saoflow.operations import Kind, Literal
from saoflow.scheduler.program import Operation, ProgramBody
from saoflow.targets import find_target
from saoflow.targets.early_schedule import scheduled_early
from saoflow.targets.expression_order import expression_order
from saoflow.targets.peephole import branches, inlined, shared
from tests.sheet_text import sheet_of

TARGETS = ("mpc755", "cortex-m7", "cortex-r5f")


def operation(kind: Kind, result: int, *operands: int | Literal) -> Operation:
    return Operation(kind, (result,) if result >= 0 else (), operands, -1, 0)


def most_alive(operations: tuple[Operation, ...]) -> int:
    """Values that are read later, at the worst place."""
    last = {a: k for k, o in enumerate(operations) for a in o.operands if isinstance(a, int)}
    born = {r: k for k, o in enumerate(operations) for r in o.results}
    return max(sum(born[a] <= k < last[a] for a in born if a in last) for k in range(len(operations)))


def test_what_is_read_once_stands_where_it_is_read() -> None:
    """3 = 0 * 1 is read twice and stays; 4 and 5 are read by 6 alone, and 6 by the store alone."""
    product, other, square, total, store = (
        operation(Kind.MULTIPLY, 3, 0, 1),
        operation(Kind.MULTIPLY, 4, 0, 2),
        operation(Kind.MULTIPLY, 5, 3, 3),
        operation(Kind.ADD, 6, 4, 5),
        operation(Kind.WRITE, -1, 6),
    )
    first = operation(Kind.WRITE, -1, 3)
    assert expression_order([product, other, square, total, first, store], (), False) == [
        product, first, other, square, total, store
    ]  # fmt: skip


def test_the_larger_operand_of_a_sum_comes_first() -> None:
    small, a, b, total = (
        operation(Kind.MULTIPLY, 3, 0, 1),
        operation(Kind.MULTIPLY, 4, 0, 2),
        operation(Kind.MULTIPLY, 5, 4, 1),
        operation(Kind.ADD, 6, 3, 5),
    )
    assert expression_order([small, a, b, total], (6,), False) == [a, b, small, total]


def test_nothing_moves_past_a_branch() -> None:
    product, limit, total = (
        operation(Kind.MULTIPLY, 3, 0, 1),
        operation(Kind.MINIMUM, 4, 2, 0),
        operation(Kind.ADD, 5, 3, 4),
    )
    assert expression_order([product, limit, total], (5,), False) == [product, limit, total]
    assert expression_order([product, limit, total], (5,), True) == [limit, product, total]


def test_of_a_value_between_two_constants_one_branch_stays() -> None:
    """As in GCC's code for Cortex-M7: ble past the second comparison; a wire as limit, or a selection, is it or vsel."""
    low, high = operation(Kind.MAXIMUM, 1, 0, Literal(-5.0)), operation(Kind.MINIMUM, 2, 1, Literal(5.0))
    assert branches([low, high], True) == [True, False]
    assert branches([low, operation(Kind.MINIMUM, 2, 1, 3)], True) == [False, False]
    assert branches([low, high], False) == [True, True]


def test_a_selection_branches_where_one_side_alone_needs_a_value() -> None:
    product, chosen = operation(Kind.MULTIPLY, 3, 0, 1), operation(Kind.SELECT, 4, 2, 3, 0)
    assert branches([product, chosen], True) == [False, True]
    assert branches([product, chosen, operation(Kind.ADD, 5, 3, 4)], True) == [False, False, False]


@pytest.mark.parametrize("name", TARGETS)
def test_every_operation_comes_once_and_after_what_it_reads(name: str) -> None:
    program = saoflow.load("cmhe_fte").frame_program
    for k, body in enumerate(inlined(program)):
        whole = shared(body)
        made = scheduled_early(whole, find_target(name), 64, k < len(program.procedures))
        _is_ordered(made)
        assert sorted(o.kind.name for o in made.operations if o.kind not in (Kind.READ, Kind.WRITE)) == sorted(
            o.kind.name for o in whole.operations if o.kind not in (Kind.READ, Kind.WRITE)
        )


def _is_ordered(body: ProgramBody) -> None:
    known = set(body.parameters)
    negations = {r for o in body.operations if Literal(-1.0) in o.operands for r in o.results}
    for o in body.operations:
        unknown = {a for a in o.operands if isinstance(a, int)} - known
        assert not unknown or o.results[0] in negations or unknown <= negations, o
        known |= set(o.results)
    assert {a for a in body.results if isinstance(a, int)} <= known


@pytest.mark.parametrize("name", TARGETS)
def test_pressure_stays_within_the_registers_where_it_can(tmp_path: Path, name: str) -> None:
    """60 products of their own, each an output: in the sheet's order all inputs and results would be alive at once."""
    made = "\n".join(f"  r{k}: {{mul: ['u[{k}]', 'w[{k}]']}}" for k in range(60))
    outputs = ", ".join(f"r{k}" for k in range(60))
    text = f"sheet: wide\ninputs: {{u: {{shape: [60]}}, w: {{shape: [60]}}}}\nblocks:\n{made}\noutputs: [{outputs}]\n"
    body = shared(sheet_of(tmp_path, text).frame_program.groups[0].body)
    target = find_target(name)
    assert most_alive(scheduled_early(body, target, 64, False).operations) <= target.instruction_set.registers
