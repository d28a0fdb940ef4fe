"""The in-order pipeline against schedules worked out by hand from the published latencies."""

from __future__ import annotations

import pytest

from saoflow.targets import find_target
from saoflow.targets.instructions import Instruction, Machine
from saoflow.targets.pipeline import cycles

A, M, D, L, S, B, I = (
    Machine.ADD, Machine.MULTIPLY, Machine.DIVIDE, Machine.LOAD, Machine.STORE, Machine.BRANCH, Machine.INTEGER,
)  # fmt: skip


def independent(*kinds: Machine) -> list[Instruction]:
    return [Instruction(kind, (), k + 1) for k, kind in enumerate(kinds)]


def chain(*kinds: Machine) -> list[Instruction]:
    return [Instruction(kind, (k,), k + 1) for k, kind in enumerate(kinds)]


@pytest.mark.parametrize(
    ("target", "real", "code", "expected"),
    [
        ("mpc755", 64, [], 0),
        ("mpc755", 64, chain(A, A, A), 9),  # each waits for the one before: 3 x 3
        ("mpc755", 64, independent(A, A, A, A), 6),  # one a cycle, issued in 0..3, the last ready at 3 + 3
        ("mpc755", 64, independent(M, M, M), 8),  # every second cycle: 0, 2, 4, ready at 4 + 4
        ("mpc755", 32, independent(M, M, M), 5),  # single precision: 0, 1, 2, ready at 2 + 3
        ("mpc755", 64, independent(D, D), 62),  # not pipelined
        ("mpc755", 64, independent(L, A, L, A), 4),  # two a cycle on two units: 0, 0, 1, 1; ready at 1 + 3
        ("mpc755", 64, independent(I, I, I), 2),  # two integer units, two a cycle
        ("mpc755", 64, independent(B, I, I), 1),  # a branch takes no slot
        ("mpc755", 64, independent(D, A, I), 34),  # in order: the add waits for the divider, the rest behind it
        ("mpc755", 64, chain(L, A, S), 6),  # 2 + 3 + 1
        ("e500mc", 64, independent(A, A), 14),  # half the clock: every fourth cycle, 4 + 10
        ("cortex-m7", 64, independent(L, A, L), 5),  # a load of a double issues alone: 0, 1, 2; ready at 2 + 3
        ("cortex-m7", 32, independent(L, A, L), 3),  # of a single, beside an add: 0, 0, 1; ready at 0 + 3, 1 + 2
        ("cortex-r5f", 64, independent(A, A), 13),  # every third cycle: 3 + 10
        ("cortex-r5f", 64, independent(D), 97),
    ],
)
def test_cycles_worked_out_by_hand(target: str, real: int, code: list[Instruction], expected: int) -> None:
    assert cycles(code, find_target(target), real) == expected


def test_never_shorter_than_the_busiest_unit_or_the_longest_chain() -> None:
    target = find_target("mpc755")
    code = independent(*([M, A, L] * 50)) + [Instruction(M, (k,), k + 1) for k in range(150, 180)]
    assert cycles(code, target, 64) >= max(2 * 80 + 50, 30 * 4)
