"""`saoflow budget --target`: what it prints, that it says what the number is not, and what it refuses."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest

from saoflow import cli
from saoflow.diagnosis import DiagnosisError
from saoflow.targets import CAVEAT, find_target, frame_cost
from tests.sheet_text import sheet_of

SHEET = """
sheet: lag
inputs: [u]
blocks:
  before: {delay: y, initial: 0}
  step: {add: [u, -before]}
  part: {mul: [step, 0.125]}
  y: {add: [before, part]}
outputs: [y]
budget: {operations: 10, period: 0.01}
"""


@pytest.fixture
def lag(tmp_path: Path) -> str:
    sheet_of(tmp_path, SHEET, "lag")
    return str(tmp_path / "lag.yaml")


def ends(capsys: pytest.CaptureFixture[str], code: int, *arguments: str) -> tuple[str, str]:
    found = cli.run(arguments)
    out, err = capsys.readouterr()
    assert found == code, (out, err)
    assert "Traceback" not in out + err
    return out, err


def test_the_report_shows_both_ways_and_what_it_is_not(capsys: pytest.CaptureFixture[str], lag: str) -> None:
    out, _ = ends(capsys, 0, "budget", lag, "--target", "mpc755", "--share", "0.5")
    assert "every operand from memory and back" in out and "registers kept" in out
    assert CAVEAT in out and "not a worst-case execution time" in CAVEAT
    assert "400 MHz (assumed" in out and "of 10 ms" in out
    assert "within the share given: 50 %" in out
    faster, _ = ends(capsys, 0, "budget", lag, "--target", "mpc755", "--clock", "800")
    assert "800 MHz" in faster and "assumed" not in faster


def test_json_has_the_same_numbers(capsys: pytest.CaptureFixture[str], lag: str) -> None:
    slow, fast = (
        json.loads(ends(capsys, 0, "budget", lag, "--target", "e300c3", "--clock", mhz, "--json")[0])["target"]
        for mhz in ("200", "400")
    )
    for form in ("memory", "registers"):
        one = slow["forms"][form]
        assert one["time_us"] == pytest.approx(one["cycles"] / 200)
        assert one["time_us"] == pytest.approx(2 * fast["forms"][form]["time_us"])
        assert one["part_of_period"] == pytest.approx(one["time_us"] * 1e-6 / 0.01)
        assert one["instructions"] == sum(one["kinds"].values())
    assert slow["worst_case_execution_time"] is False and slow["caveat"] == CAVEAT


def test_over_the_share_ends_with_1(capsys: pytest.CaptureFixture[str], lag: str) -> None:
    out, err = ends(capsys, 1, "budget", lag, "--target", "cortex-m7", "--share", "0.000001")
    assert "OVER" in out
    assert re.search(r"error\[E401\]: a frame of `lag` takes .* us on cortex-m7", err)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--target", "mpc750"], "error[E608]: there is no target `mpc750`"),
        (["--target", "mpc755", "--clock", "0"], "error[E603]: `--clock` cannot be 0"),
        (["--target", "mpc755", "--clock", "nan"], "error[E603]: `--clock` cannot be nan"),
        (["--target", "mpc755", "--share", "1.5"], "error[E603]: `--share` cannot be 1.5"),
        (["--clock", "400"], "error[E603]: `--clock` and `--share` need a target"),
    ],
)
def test_what_is_refused(capsys: pytest.CaptureFixture[str], lag: str, arguments: list[str], words: str) -> None:
    assert words in ends(capsys, 2, "budget", lag, *arguments)[1]


def test_a_share_needs_a_period(tmp_path: Path) -> None:
    program = sheet_of(tmp_path, SHEET.replace("budget: {operations: 10, period: 0.01}\n", "")).frame_program
    with pytest.raises(DiagnosisError, match="E603"):
        frame_cost(program, find_target("mpc755"), share=0.1)
