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


def test_errors_that_a_given_value_makes_are_laid_at_its_door(tmp_path: Path) -> None:
    path = tmp_path / "taps.yaml"
    text = "sheet: taps\nparameters: {n: {value: 2, doc: how many}}\ninputs: {x: {shape: [n]}}\nblocks: {y: {sum_of: x, n: n}}\noutputs: [y]\n"
    path.write_text(text)
    for given in ({"n": 2.5}, {"n": 0}):
        with pytest.raises(DiagnosisError) as caught:
            load(str(path), given).check()
        assert [d.code for d in caught.value.diagnoses[:-1]].count("E603") == 0
        last = caught.value.diagnoses[-1]
        assert last.code == "E603" and last.message == f"`taps` cannot be with n = {given['n']:g}"
        assert [(n.text, n.position and n.position.line) for n in last.notes] == [("`n`, how many, is declared here", 2)]
    path.write_text(text.replace("[y]", "[z]"))  # a sheet that is wrong anyway
    with pytest.raises(DiagnosisError) as caught:
        load(str(path), {"n": 0}).check()
    assert "E603" not in [d.code for d in caught.value.diagnoses]


def test_sheets_that_double_at_every_level_are_refused_at_once(tmp_path: Path) -> None:
    for i in range(30):
        inner = f"n{i + 1}" if i < 29 else "reciprocal"
        text = f"sheet: n{i}\ninputs: [x]\nblocks: {{a: {{{inner}: x}}, b: {{{inner}: a}}}}\noutputs: [b]\n"
        (tmp_path / f"n{i}.yaml").write_text(text)
    with pytest.raises(DiagnosisError) as caught:
        load(str(tmp_path / "n0.yaml")).check()
    (found,) = caught.value.diagnoses
    assert found.code == "E219" and found.cause.startswith("it has 2147483648 blocks")
