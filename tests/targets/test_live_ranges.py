"""Registers for lives of values against allocations made by hand."""

from __future__ import annotations

from saoflow.targets.live_ranges import Life, Registers, allocate

TWO = Registers(2, 1, 0)


def life(name: str, born: int, *reads: int, stored: bool = False) -> Life:
    return Life(name, born, reads, stored, True)


def test_all_fits() -> None:
    held = allocate([life("a", 0, 2), life("b", 1, 2), life("c", 2, 3)], 4, [], TWO)
    assert not held.in_memory
    assert held.saved == 1  # two at a time, and one of the two registers is the caller's


def test_the_longest_life_with_the_fewest_reads_goes() -> None:
    """Three at a time after place 2: a costs 2 over a length of 9, b 3 over 4, c 2 over 2."""
    held = allocate([life("a", 0, 9), life("b", 1, 3, 5), life("c", 2, 4)], 10, [], TWO)
    assert held.in_memory == {"a"}
    assert held.needs_load("a", 9) and not held.needs_load("b", 3)


def test_what_memory_holds_anyway_costs_no_store() -> None:
    """a and b alike, but b is an input: 1 load against a load and a store."""
    held = allocate([life("a", 0, 6), life("b", 0, 6, stored=True), life("c", 2, 4)], 7, [], TWO)
    assert held.in_memory == {"b"}


def test_across_a_call_only_preserved_registers_hold() -> None:
    held = allocate([life("a", 0, 5), life("b", 1, 4, 5)], 6, [3], TWO)
    assert held.in_memory == {"a"}
    assert held.saved == 1


def test_a_reloaded_value_is_kept_for_a_near_read() -> None:
    lives = [life("a", 0, 5, 6, 9), life("b", 1, 3, 3), life("c", 1, 2, 3)]
    assert allocate(lives, 10, [], TWO).inherited == frozenset()
    held = allocate(lives, 10, [], Registers(2, 1, 1))
    assert held.in_memory == {"a"}
    assert held.inherited == {("a", 6)}
