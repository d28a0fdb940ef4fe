"""The data file against the published table, and every number with its source."""

from __future__ import annotations

import tomllib
from typing import Any

import pytest

from saoflow.diagnosis import DiagnosisError
from saoflow.targets import find_target, targets
from saoflow.targets.instructions import Machine
from saoflow.targets.target import DATA

PUBLISHED = """
operation      mpc755  e300c3  e500v2  e500mc  cortex-m7  cortex-r5f
add 32         3/1     3/1     4/1     10/4    3/1        3/1
add 64         3/1     3/1     6/1     10/4    3/1        10/3
multiply 32    3/1     3/1     4/1     8/2     3/1        3/1
multiply 64    4/2     4/2     6/1     8/2     6/3        10/3
divide 32      17/17   18/18   29/29   38/38   16/5       17/2
divide 64      31/31   33/33   32/32   68/68   31/4       97/3
load 32        2/1     2/1     3/1     4/1     2/1        2/1
load 64        2/1     2/1     3/1     4/1     3/1        8/1
store 64       1/1     2/1     3/1     3/1     0/1        8/1
"""
"""Latency/interval in cycles, copied by hand from the compilers' models (docs/cost_model.md)."""


def test_numbers_are_those_published() -> None:
    head, *rows = PUBLISHED.strip().splitlines()
    names = head.split()[1:]
    for row in rows:
        kind, real, *cells = row.split()
        for name, cell in zip(names, cells, strict=True):
            timing = find_target(name).timing(Machine(kind), int(real))
            assert f"{timing.latency}/{timing.interval}" == cell, (name, row)


def test_every_timing_clock_and_width_has_a_source() -> None:
    for target in targets().values():
        assert target.clock_source and target.issue_source
        for kind in Machine:
            for real in (32, 64) if kind in target.kinds() else ():
                assert target.timing(kind, real).source, (target.name, kind)


def test_sources_are_named_at_the_head_of_the_file() -> None:
    head = DATA.read_text(encoding="utf-8").split("[", 1)[0]
    known = ("gcc 7xx", "gcc e300", "gcc e500mc", "gcc m7", "gcc r4f", "gcc r4", "llvm e500", "llvm e500mc", "llvm m7")
    assert all(name in head for name in known)
    for target in targets().values():
        for kind in target.kinds():
            source = target.timing(kind, 64).source
            assert source.startswith(known), (target.name, kind, source)


def test_no_key_of_the_file_is_left_unread() -> None:
    data: dict[str, Any] = tomllib.loads(DATA.read_text(encoding="utf-8"))
    for entry in data["targets"].values():
        chained = data["instruction_sets"][entry["instruction_set"]]["multiply_add"]
        left_out = set() if chained else {Machine.MULTIPLY_ADD.value}
        assert set(entry["timings"]) == {kind.value for kind in Machine} - left_out
        assert entry["instruction_set"] in data["instruction_sets"]
        assert set(entry) <= {
            "title", "instruction_set", "clock_mhz", "clock_source", "issue_width", "issue_source", "units", "notes",
            "timings",
        }  # fmt: skip


def test_an_unknown_target_is_told_what_is_near() -> None:
    with pytest.raises(DiagnosisError) as caught:
        find_target("cortex_m7")
    (diagnosis,) = caught.value.diagnoses
    assert diagnosis.code == "E608"
    assert "cortex-m7" in diagnosis.remedy and "mpc755" in diagnosis.cause
