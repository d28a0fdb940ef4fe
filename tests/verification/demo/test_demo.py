"""The demonstration: what it finds, that its checks can fail, and that its files can be used again."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import saoflow
from saoflow import cli
from saoflow.recordings import output_columns, read_frames, read_table, write_table
from verification.demo import DemoResult, Scenario, run_demo, write_files
from verification.demo.facts import facts, to_dict
from verification.demo.picture import write_picture
from verification.demo.result import Method

pytestmark = pytest.mark.xdist_group("demo")


def test_the_scenario_is_fig_4(result: DemoResult) -> None:
    readings, truth = result.recording["vc_2"], result.recording["vc_true"]
    time = result.time
    assert abs(truth[0] - 350) < 1 and abs(result.recording["z"][0] - 1524) < 15
    assert np.abs(result.recording["wx_true"]).max() < 0.5
    before, after = time < 20.0, time >= 20.0
    slope = np.polyfit(time[after], readings[after] - truth[after], 1)[0]
    assert abs(slope + 15.0) < 0.05
    assert np.abs((readings - truth)[before]).max() < 5.0
    assert readings.min() > 20.0, "the readings stay in the range of an air data computer"


def test_everything_claimed_holds(result: DemoResult) -> None:
    assert [fact.label for fact in facts(result) if fact.holds is False] == []
    assert result.holds


def test_detection_is_what_the_outputs_say(result: DemoResult) -> None:
    """Counted again from the raw outputs, frame by frame."""
    onset = 417  # the first frame at or after 20 s: 20 / 0.048 = 416.7
    first = [next(k for k in range(873) if result.cmhe.outputs["vc_faulty"][k, i] == 1.0) for i in range(3)]
    assert result.delays(result.cmhe) == {i + 1: k - onset for i, k in enumerate(first)}
    assert result.isolated_frame(result.cmhe) == max(first)
    assert max(first) - onset <= 6.0 / 0.048
    assert not result.cmhe.outputs["alpha_faulty"].any()
    assert not result.umhe.outputs["vc_faulty"][: onset + 370].any()


def test_errors_are_those_of_the_estimates(result: DemoResult) -> None:
    error = np.degrees(result.cmhe.outputs["alpha_hat"][50:417] - result.recording["alpha_true"][50:417])
    told = result.errors(result.cmhe, "alpha", 50, 417)
    assert told.largest == pytest.approx(max(abs(error)))
    assert told.rms == pytest.approx(np.sqrt(sum(error**2) / len(error)))
    assert told.largest < 0.5


def broken(method: Method, name: str, frame: int, value: float) -> Method:
    changed = method.outputs[name].copy()
    changed[frame] = value
    return replace(method, outputs={**method.outputs, name: changed})


def test_a_missed_sensor_is_told(result: DemoResult) -> None:
    outputs = {**result.cmhe.outputs, "vc_faulty": result.cmhe.outputs["vc_faulty"] * np.array([1.0, 0.0, 1.0])}
    wrong = replace(result, cmhe=replace(result.cmhe, outputs=outputs))
    assert not wrong.detected and not wrong.holds
    assert "misses airspeed sensors 2" in facts(wrong)[0].text


def test_a_late_detection_is_told(result: DemoResult) -> None:
    late = result.cmhe.outputs["vc_faulty"] * (np.arange(873) >= 417 + 126)[:, None]
    wrong = replace(result, cmhe=replace(result.cmhe, outputs={**result.cmhe.outputs, "vc_faulty": late}))
    assert not wrong.detected


@pytest.mark.parametrize("name", ["alpha_faulty", "vc_faulty"])
def test_a_false_alarm_is_told(result: DemoResult, name: str) -> None:
    wrong = replace(result, cmhe=broken(result.cmhe, name, 300, 1.0))
    assert not wrong.detected
    assert "false alarms: 3" in facts(wrong)[0].text


def test_an_early_detection_without_bounds_is_told(result: DemoResult) -> None:
    assert not replace(result, umhe=broken(result.umhe, "vc_faulty", 600, 1.0)).not_by_umhe


def test_a_difference_from_the_reference_is_told(result: DemoResult) -> None:
    estimate = float(result.cmhe.outputs["vc_hat"][200])
    assert not replace(result, cmhe=broken(result.cmhe, "vc_hat", 200, estimate + 0.03)).equal
    exact = result.cmhe.exact["alpha_hat"] + 1e-10
    assert not replace(result, cmhe=replace(result.cmhe, exact={**result.cmhe.exact, "alpha_hat": exact})).equal


def test_another_decision_is_excused_only_near_the_threshold(result: DemoResult) -> None:
    shifted = np.roll(result.umhe.outputs["vc_faulty"], 1, axis=0)
    umhe = replace(result.umhe, outputs={**result.umhe.outputs, "vc_faulty": shifted})
    assert len(umhe.other_decisions) == 3
    near = {**umhe.reference, "vc_rms": np.full((873, 3), 12.019)}
    far = {**umhe.reference, "vc_rms": np.full((873, 3), 12.021)}
    assert replace(umhe, reference=near).same_decisions
    assert not replace(umhe, reference=far).same_decisions


def test_the_files_repeat_the_run(result: DemoResult, tmp_path: Path) -> None:
    """The sheet gives the written estimates again from the written readings, to the last byte."""
    page, estimates, recording = write_files(result, tmp_path)
    sheet = saoflow.load("cmhe_fte")
    frames = read_frames(recording, sheet.input_types)
    again = sheet.simulator().run(frames.inputs)
    write_table(tmp_path / "again.csv", output_columns(again, sheet.output_types, frames.t))
    assert (tmp_path / "again.csv").read_bytes() == Path(estimates).read_bytes()
    table = read_table(recording)
    assert np.array_equal(table["vc_3"], result.recording["vc_3"])
    assert np.array_equal(table["alpha_true"], result.recording["alpha_true"])
    assert sorted(p.name for p in tmp_path.iterdir()) == ["again.csv", "estimates.csv", "recording.csv", "report.html"]
    assert Path(page).stat().st_size < 1_500_000


def test_the_command(
    result: DemoResult, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    seeds: list[int] = []

    def ran(scenario: Scenario, progress: object = None) -> DemoResult:
        seeds.append(scenario.seed)
        return result

    monkeypatch.setattr("verification.demo.run_demo", ran)
    assert cli.run(["demo", "-o", str(tmp_path / "a" / "b")]) == 0
    screen = capsys.readouterr().out
    assert len(screen.splitlines()) <= 30
    assert "isolates airspeed sensors 1, 2 and 3" in " ".join(screen.split())
    assert (tmp_path / "a" / "b" / "report.html").exists()
    monkeypatch.setattr("verification.demo.write_files", lambda result, folder, progress: ())
    assert cli.run(["demo", "-o", str(tmp_path), "--json", "--seed", "7"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["holds"] is True
    assert told["methods"]["cmhe_fte"]["operations"] == saoflow.load("cmhe_fte").budget().total
    assert seeds == [1, 7]


def test_the_command_fails_if_a_claim_does(
    result: DemoResult, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    wrong = replace(result, cmhe=broken(result.cmhe, "alpha_faulty", 300, 1.0))
    monkeypatch.setattr("verification.demo.run_demo", lambda scenario, progress: wrong)
    assert cli.run(["demo", "-o", str(tmp_path)]) == 1
    assert "Something claimed does not hold" in capsys.readouterr().out


def test_bad_input(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "file").write_text("")
    assert cli.run(["demo", "-o", str(tmp_path / "file")]) == 2
    assert "error[E601]" in capsys.readouterr().err
    assert cli.run(["demo", "-o", str(tmp_path / "out"), "--seed", "-1"]) == 2
    assert "error[E713]" in capsys.readouterr().err
    (tmp_path / "taken" / "report.html").mkdir(parents=True)
    assert cli.run(["demo", "-o", str(tmp_path / "taken"), "--json"]) == 2
    assert json.loads(capsys.readouterr().out)["diagnoses"][0]["code"] == "E601"
    (tmp_path / "taken2" / "estimates.csv").mkdir(parents=True)
    assert cli.run(["demo", "-o", str(tmp_path / "taken2")]) == 2
    assert "E601" in capsys.readouterr().err


def test_progress_covers_every_stage(result: DemoResult) -> None:
    told: list[tuple[str, int, int]] = []
    short = run_demo(Scenario(duration=22.0), lambda *stage: told.append(stage))
    assert len(short.time) == 458
    stages = {stage for stage, _, _ in told}
    assert len(stages) == 8
    for stage in stages:
        done = [(d, total) for s, d, total in told if s == stage]
        assert done[-1][0] == done[-1][1]
        assert [d for d, _ in done] == sorted(d for d, _ in done)
    assert np.array_equal(short.cmhe.outputs["vc_hat"], result.cmhe.outputs["vc_hat"][:458])


def test_json_holds_no_nan(result: DemoResult) -> None:
    json.dumps(to_dict(result, ()), allow_nan=False)


def test_picture(result: DemoResult, tmp_path: Path) -> None:
    write_picture(result, tmp_path / "demo.png")
    assert (tmp_path / "demo.png").read_bytes().startswith(b"\x89PNG")
    assert (tmp_path / "demo.png").stat().st_size < 300_000
