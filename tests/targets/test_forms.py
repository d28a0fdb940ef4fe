"""The two forms of a frame against counts made by hand and against what any allocation must do."""

from __future__ import annotations

from collections import Counter
from pathlib import Path

import pytest

import saoflow
from saoflow.operations import Kind
from saoflow.scheduler.program import ProgramBody
from saoflow.targets import find_target, frame_cost
from saoflow.targets.instructions import Instruction, Machine
from saoflow.targets.memory_form import memory_form
from saoflow.targets.peephole import call_counts, flags, inlined, shared
from saoflow.targets.register_form import register_form
from tests.sheet_text import sheet_of

PPC = find_target("mpc755").instruction_set
ARM = find_target("cortex-m7").instruction_set

LINE = """
sheet: line
inputs: [u, v, w]
blocks:
  a: {mul: [u, v]}
  b: {add: [a, w]}
outputs: [b]
"""


def kinds(code: list[Instruction]) -> Counter[Machine]:
    return Counter(instruction.kind for instruction in code)


def test_one_line_in_registers(tmp_path: Path) -> None:
    """u * v + w: three loads, a product, a sum, a store."""
    program = sheet_of(tmp_path, LINE).frame_program
    found = kinds(register_form(program.groups[0].body, program.tables, PPC, False))
    real = {k: n for k, n in found.items() if k not in (Machine.INTEGER, Machine.BRANCH)}
    assert real == {Machine.LOAD: 3, Machine.MULTIPLY: 1, Machine.ADD: 1, Machine.STORE: 1}


def test_one_line_from_memory_and_back(tmp_path: Path) -> None:
    """Three inputs copied, two operations with two loads and a store each, one output copied."""
    program = sheet_of(tmp_path, LINE).frame_program
    found = kinds(memory_form(program.groups[0].body, program.tables, PPC, False))
    assert found[Machine.LOAD] == 3 + 2 * 2 + 1
    assert found[Machine.STORE] == 3 + 2 + 1
    assert found[Machine.MULTIPLY] == found[Machine.ADD] == 1


@pytest.mark.parametrize("isa", [PPC, ARM], ids=lambda isa: isa.name)
def test_values_beyond_the_registers_go_to_memory(tmp_path: Path, isa: object) -> None:
    """n sums made first and added up later: those beyond the registers are stored once and loaded once."""
    n = 48
    assert isinstance(isa, type(PPC))
    made = "\n".join(f"  i{k}: {{select: 'u[{k}]'}}\n  r{k}: {{add: [i{k}, v]}}" for k in range(n))
    later = ", ".join(f"r{k}" for k in range(n - 1, -1, -1))
    text = f"sheet: many\ninputs: {{u: {{shape: [{n}]}}, v: {{}}}}\nblocks:\n{made}\n  s: {{add: [{later}]}}\noutputs: [s]\n"
    program = sheet_of(tmp_path, text).frame_program
    assert [o.kind for o in program.groups[0].body.operations][:n] == [Kind.ADD] * n
    found = kinds(register_form(program.groups[0].body, program.tables, isa, False))
    saved = 1 if isa.save_many else isa.preserved
    spilled = found[Machine.STORE] - 1 - saved
    assert n - isa.registers <= spilled <= n - isa.registers + 3
    assert found[Machine.LOAD] - (n + 1) - saved == spilled


def test_a_comparison_is_a_flag_until_something_keeps_it(tmp_path: Path) -> None:
    """Branched on: compare and branch. Kept: the flag becomes a value (its measured share) and is stored."""
    text = "sheet: c\ninputs: [u, v]\nblocks:\n  f: {compare: [u, v], relation: '<'}\n  s: {switch: [f, u, v]}\noutputs: [%s]\n"
    found = {}
    for outputs in ("s", "s, f"):
        body = sheet_of(tmp_path, text % outputs).frame_program.groups[0].body
        assert (body.operations[0].results[0] in flags(body)) == (outputs == "s")
        found[outputs] = kinds(register_form(body, (), PPC, False))
    more = found["s, f"] - found["s"]
    shares = PPC.shares["registers"]
    assert more[Machine.INTEGER_STORE] == 1
    assert abs(more[Machine.INTEGER] - shares.value - shares.test) <= 1.0
    assert found["s"][Machine.COMPARE] == found["s, f"][Machine.COMPARE] == 1


def test_what_repeats_is_computed_once(tmp_path: Path) -> None:
    text = "sheet: c\ninputs: [u, v]\nblocks:\n  a: {mul: [u, v]}\n  b: {mul: [v, u]}\n  s: {add: [a, u]}\n  t: {add: [u, b]}\noutputs: [s, t]\n"
    body = sheet_of(tmp_path, text).frame_program.groups[0].body
    once = shared(body)
    assert [o.kind for o in once.operations] == [Kind.MULTIPLY, Kind.ADD]
    assert once.results[0] == once.results[1]


def test_gcc_lays_out_in_the_flagship_what_the_model_does() -> None:
    """Functions that GCC 12.2 -O2 -mcpu=750 left to be called, read off its assembly; two of its choices are missed."""
    called = ["p0", "p2", "p4", "p5", "p6", "p9", "p11", "p12", "p15", "p16", "p17", "p20", "p23"]
    program = saoflow.load("cmhe_fte").frame_program
    counts = call_counts(inlined(program), len(program.procedures))[: len(program.procedures)]
    assert {f"p{i}" for i, n in enumerate(counts) if n} ^ set(called) <= {"p2", "p9"}


def test_what_is_read_was_written_before() -> None:
    program = saoflow.load("cmhe_fte").frame_program
    for former, bodies in ((memory_form, program.bodies), (register_form, inlined(program))):
        for k, body in enumerate(bodies):
            written: set[int] = set()
            for instruction in former(body, program.tables, PPC, k < len(program.procedures)):
                assert all(r in written or r == -1 for r in instruction.reads)
                written.add(instruction.write)


def test_arithmetic_of_the_flagship_is_what_the_budget_counts() -> None:
    """Every product, sum and reciprocal of the report is there; look-ups add their interpolation."""
    sheet = saoflow.load("cmhe_fte")
    report, program = sheet.budget(), sheet.frame_program
    used = {line.kind: line.used for line in report.lines}
    linear = sum(t.uses for t, table in zip(report.tables, program.tables, strict=True) if table.linear)
    for form in frame_cost(program, find_target("mpc755")).forms:
        assert form.kinds[Machine.DIVIDE] == used["reciprocal"]
        arithmetic = form.kinds[Machine.ADD] + form.kinds[Machine.MULTIPLY]
        counted = used["add"] + used["subtract"] + used["multiply"] + 3 * linear
        negations = sum(
            times * sum(o.kind is Kind.MULTIPLY and any(getattr(a, "value", 0) == -1.0 for a in o.operands)
                        for o in body.operations)
            for body, times in zip(program.bodies, call_counts(program.bodies, len(program.procedures)), strict=True)
        )  # fmt: skip
        assert arithmetic == counted - negations


def test_inlining_keeps_the_operations() -> None:
    program = saoflow.load("cmhe_fte").frame_program

    def total(bodies: tuple[ProgramBody, ...]) -> Counter[Kind]:
        found: Counter[Kind] = Counter()
        for body, times in zip(bodies, call_counts(bodies, len(program.procedures)), strict=True):
            for o in body.operations:
                found[o.kind] += times
        return found

    before, after = total(program.bodies), total(inlined(program))
    assert after[Kind.CALL] < before[Kind.CALL]
    assert {k: n for k, n in before.items() if k is not Kind.CALL} == {
        k: n for k, n in after.items() if k is not Kind.CALL
    }


def test_registers_are_cheaper_than_memory_and_single_no_dearer_than_double() -> None:
    sheet = saoflow.load("cmhe_fte")
    for name in ("mpc755", "cortex-r5f"):
        memory, registers = frame_cost(sheet.frame_program, find_target(name)).forms
        assert registers.cycles < memory.cycles and registers.instructions < memory.instructions
        single = frame_cost(sheet.program(32), find_target(name)).forms
        assert single[1].cycles < registers.cycles
