"""Places on the stack against offsets counted by hand."""

from __future__ import annotations

from pathlib import Path

from saoflow.operations import Literal
from saoflow.targets import find_target
from saoflow.targets.live_ranges import Life
from saoflow.targets.register_form import small_constant
from saoflow.targets.stack_frame import StackFrame
from tests.sheet_text import sheet_of

ARM = find_target("cortex-m7").instruction_set
PPC = find_target("mpc755").instruction_set
SHEET = "sheet: line\ninputs: [u]\nblocks:\n  a: {mul: [u, u]}\noutputs: [a]\n"


def frame(tmp_path: Path, lives: list[Life], isa: object = ARM) -> StackFrame:
    assert isinstance(isa, type(ARM))
    return StackFrame(sheet_of(tmp_path, SHEET).frame_program.groups[0].body, lives, 0, isa, False)


def test_vldr_reaches_128_doubles_then_addw_then_two(tmp_path: Path) -> None:
    """Offsets 0 to 1020 reach 128 doubles, to 4095 another 384."""
    lives = [Life(k, 0, (1,), False, True) for k in range(600)]
    found = [frame(tmp_path, lives).slot(k) for k in range(600)]
    assert [found.count(n) for n in (0, 1, 2)] == [128, 384, 88]
    assert not any(frame(tmp_path, lives, PPC).slot(k) for k in range(600))


def test_what_is_read_most_lies_nearest(tmp_path: Path) -> None:
    lives = [Life(k, 0, (1,) if k < 200 else (1, 1), False, True) for k in range(220)]
    found = frame(tmp_path, lives)
    assert not any(found.slot(k) for k in range(200, 220))
    assert sum(found.slot(k) for k in range(200)) == 220 - 128


def test_lives_apart_share_a_place(tmp_path: Path) -> None:
    body = sheet_of(tmp_path, SHEET).frame_program.groups[0].body
    lives = [Life(k, 0 if k < 100 else 2, (1,) if k < 100 else (3,), False, True) for k in range(200)]
    assert len(body.operations) < 4
    assert not any(frame(tmp_path, lives).slot(k) for k in range(200))


def test_state_beyond_an_offset_costs_its_address(tmp_path: Path) -> None:
    found = frame(tmp_path, [])
    assert [found.state(k) for k in (-1, 0, 127, 128, 5000)] == [0, 0, 0, 1, 1]


def test_constants_of_a_move_are_the_256_of_the_architecture() -> None:
    """VFPExpandImm (Arm architecture reference manual): sign, three bits of exponent, four of fraction."""
    known = {(-1) ** s * (1 + f / 16) * 2.0**e for s in (0, 1) for e in range(-3, 5) for f in range(16)}
    assert len(known) == 256
    assert all(small_constant(Literal(v)) for v in known)
    assert not any(small_constant(Literal(v)) for v in (0.0, 0.1, 32.0, 0.0625, 1 + 1 / 32, 31.5, 1e300, float("inf")))
