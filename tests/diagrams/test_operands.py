"""Operands that are constants."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from saoflow import DiagnosisError, load
from tests.sheet_text import sheet_of

PI = """\
sheet: turns
inputs: [x]
blocks:
  turn: {mul: [x, pi]}
  back: {add: [turn, -pi]}
  both: {concatenate: [pi, x]}
outputs: [turn, back, both]
"""


def test_pi_alone_is_an_operand(tmp_path: Path) -> None:
    out = sheet_of(tmp_path, PI).simulator().run({"x": [3.0]})
    assert out["turn"] == 3 * math.pi and out["back"] == 3 * math.pi - math.pi
    assert out["both"].tolist() == [[math.pi, 3.0]]


def test_a_wire_of_that_name_is_meant_where_there_is_one(tmp_path: Path) -> None:
    text = "sheet: own\ninputs: [pi]\nblocks: {y: {add: [pi, pi]}}\noutputs: [y]\n"
    assert sheet_of(tmp_path, text).simulator().run({"pi": [1.0]})["y"] == 2


def test_a_value_given_from_outside_is_told_where_its_range_is_declared(tmp_path: Path) -> None:
    path = tmp_path / "gain.yaml"
    path.write_text("sheet: gain\nparameters: {k: {value: 1, range: [0, 5]}}\ninputs: [x]\nblocks: {y: {mul: [x, k]}}\noutputs: [y]\n")
    with pytest.raises(DiagnosisError) as caught:
        load(str(path), {"k": 9}).check()
    (found,) = caught.value.diagnoses
    assert found.position is not None and (found.position.line, found.position.column) == (2, 35)
    assert "`--set`" in found.cause and "it is 9" in found.cause
