"""The table of Table II's faults, shortened: the high level, one seed, and what a cell of the table says."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from verification.flights import Fault
from verification.results.batch import Outcome
from verification.results.fault_table import FLIGHTS, introduction, main, table
from verification.results.faults import LEVELS, Result, Trial, _result, run_trials, trials

FOUND_AT_HIGH = {"oscillation", "jamming", "bias", "runaway"}


def test_all_trials_of_the_table():
    made = trials()
    # 2 sensors x (5 kinds x 3 levels + non-return-to-zero) x 3 numbers of sensors x 3 seeds
    assert len(made) == 2 * (5 * 3 + 1) * 3 * 3
    assert len({(t.fault, t.seed) for t in made}) == len(made)
    negative = [t for t in made if (t.fault.rate or t.fault.amplitude or 0.0) < 0.0]
    assert {t.seed for t in negative} == {2}
    assert {t.fault.kind for t in negative} == {"bias", "jamming", "runaway"}


def test_large_faults_are_found_on_one_two_and_three_sensors():
    chosen = [t for t in trials(seeds=(1,), onset=5.0) if t.level == "high" and t.fault.kind in FOUND_AT_HIGH]
    results = run_trials(FLIGHTS[0], chosen, duration=10.0)
    assert len(results) == 2 * 4 * 3
    for result in results:
        assert result.found and result.wrong == 0, result
        assert result.delay_s < 1.0, result
    # Isolated, the sensors that are left carry the estimate on.
    one = [r for r in results if len(r.trial.fault.which) == 1]
    assert all(r.alpha_error < 0.5 and r.vc_error < 2.0 for r in one)


def test_small_faults_are_missed_and_the_table_says_so():
    chosen = [t for t in trials(seeds=(1,), onset=5.0) if t.level == "low" and t.fault.kind == "bias"]
    results = run_trials(FLIGHTS[0], chosen, duration=10.0)
    assert not any(r.found for r in results)
    row = next(line for line in table(results).splitlines() if line.startswith("| alpha | bias"))
    assert row.count("**0/1**") == 3 and "low: 0.5 deg" in row


@pytest.mark.parametrize(
    ("confirmed_at", "delay"), [({0: 12, 1: 15}, 5 * 0.048), ({0: 12}, None), ({0: 3, 1: 15}, None)]
)
def test_delay_is_counted_to_the_last_faulty_sensor_and_early_alarms_are_wrong(confirmed_at, delay):
    faulty = np.zeros((20, 3), dtype=bool)
    for sensor, frame in confirmed_at.items():
        faulty[frame:, sensor] = True
    none, zeros = np.zeros((20, 3), dtype=bool), np.zeros(20)
    outcome = Outcome(faulty, none, np.zeros((20, 3)), np.zeros((20, 3)), zeros, zeros, zeros, zeros)
    trial = Trial(Fault("bias", "alpha", (1, 2), amplitude=5.0, onset=0.48), "middle", 1)
    result = _result(trial, outcome, 0.048)
    assert result.delay_s == (pytest.approx(delay) if delay else None)
    assert result.wrong == (1 if 3 in confirmed_at.values() else 0)


def test_the_cell_of_the_table():
    trial = Trial(Fault("runaway", "vc", (1,), rate=5.0, onset=5.0), LEVELS[1], 1)
    results = [
        Result(trial, 1, 2.0, 0, 0.1, 3.21),
        Result(trial, 1, 3.0, 2, 0.1, 1.0),
        Result(trial, 0, None, 0, 0.1, 9.0),
    ]
    assert "| vc | runaway | middle: 5 kt/s | **2/3** in 2.50 s; 9.0 kt + 2 wrong |" in table(results)


def test_the_document_is_the_commands():
    """Written by the command as it is now; what each row says is held by running it again."""
    text = (Path(__file__).parents[3] / "docs" / "fault_table.md").read_text(encoding="utf-8")
    assert text.startswith(introduction())
    rows = [line for line in text.splitlines() if line.startswith(("| alpha |", "| vc |"))]
    assert len(rows) == len(FLIGHTS) * 2 * (5 * 3 + 1)
    one = [t for t in trials(which=((1,),)) if (t.fault.sensor, t.fault.kind, t.level) == ("vc", "bias", "middle")]
    cell = table(run_trials(FLIGHTS[0], one)).splitlines()[2].split(" | ")[3]
    assert f"| vc | bias | middle: 44.7 kt | {cell} |" in text


def test_an_output_that_cannot_be_written_is_refused_before_the_work(tmp_path: Path, capsys):
    with pytest.raises(SystemExit) as stop:
        main(["-o", str(tmp_path / "no_folder" / "table.md")])
    assert stop.value.code == 2
    assert "cannot be written" in capsys.readouterr().err
