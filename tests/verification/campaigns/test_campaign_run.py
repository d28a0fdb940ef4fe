"""Whole campaigns: however they are interrupted, spread and resumed, the results have the same bytes."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from small_campaign import SMALL, yaml_of

from saoflow import DiagnosisError
from verification.campaigns import pool
from verification.campaigns.fingerprint import code_digest
from verification.campaigns.plan import Campaign
from verification.campaigns.pool import spread
from verification.campaigns.reader import load_campaign
from verification.campaigns.run import run_campaign
from verification.campaigns.store import rows_of

COMMAND = [sys.executable, "-m", "saoflow.cli", "campaign"]


@pytest.fixture(scope="module")
def campaign(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Campaign, bytes]:
    """A campaign of 16 chunks: its file, itself, and the bytes of its results in one process, uninterrupted."""
    folder = tmp_path_factory.mktemp("campaign")
    file = folder / "small.yaml"
    file.write_text(yaml_of(16, 24), encoding="utf-8")
    plan = load_campaign(str(file))
    return file, plan, run_campaign(plan, folder / "whole", workers=1).results.read_bytes()


def test_two_workers_give_the_same_bytes(campaign: tuple[Path, Campaign, bytes], tmp_path: Path) -> None:
    _, plan, expected = campaign
    seen = []
    outcome = run_campaign(plan, tmp_path / "two", workers=2, progress=lambda *now: seen.append(now))
    assert outcome.results.read_bytes() == expected
    assert seen[0] == ("flying", 0, 384) and seen[-1] == ("flying", 384, 384)
    assert sorted(seen, key=lambda now: now[1]) == seen


@pytest.mark.parametrize("parts", [0, 3, 11])
def test_killed_and_resumed(campaign: tuple[Path, Campaign, bytes], tmp_path: Path, parts: int) -> None:
    file, plan, expected = campaign
    folder = tmp_path / "out"
    process = subprocess.Popen([*COMMAND, str(file), "-o", str(folder), "--workers", "1" if parts else "2"])
    while process.poll() is None and not (
        (folder / "campaign.json").exists() and len(list((folder / "parts").glob("*.parquet"))) >= parts
    ):
        time.sleep(0.002)
    process.send_signal(signal.SIGKILL)
    process.wait()
    assert not (folder / "results.parquet").exists(), "it was over before it was killed"
    # what a killed write leaves
    (folder / "parts" / f".00015.parquet.{process.pid}.part").write_bytes(b"PAR1 half of it")
    there = len(list((folder / "parts").glob("*.parquet")))
    code_digest.cache_clear()
    outcome = run_campaign(plan, folder, workers=1)
    assert outcome.flown == 24 * (16 - there)
    assert outcome.results.read_bytes() == expected
    assert sorted(p.name for p in folder.rglob("*") if p.name.endswith(".part")) == []


def test_a_damaged_part_is_flown_again(campaign: tuple[Path, Campaign, bytes], tmp_path: Path) -> None:
    _, plan, expected = campaign
    run_campaign(plan, tmp_path, workers=1)
    part = tmp_path / "parts" / "00004.parquet"
    part.write_bytes(part.read_bytes()[:500])
    (tmp_path / "parts" / "00009.parquet").unlink()
    outcome = run_campaign(plan, tmp_path, workers=1)
    assert outcome.flown == 48 and outcome.results.read_bytes() == expected


def test_ctrl_c_stops_and_keeps(campaign: tuple[Path, Campaign, bytes], tmp_path: Path) -> None:
    file, plan, expected = campaign
    folder = tmp_path / "out"
    process = subprocess.Popen(
        [*COMMAND, str(file), "-o", str(folder), "--workers", "2"],
        stderr=subprocess.PIPE,
        start_new_session=True,
        text=True,
        # Where the tests run in the background, they and what they start ignore it.
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
    )
    while process.poll() is None and not list(folder.glob("parts/*.parquet")):
        time.sleep(0.002)
    os.killpg(process.pid, signal.SIGINT)  # as a terminal does: the workers get it, too
    _, told = process.communicate(timeout=60)
    assert process.returncode == 130
    assert told.splitlines() == [
        f"stopped; what has been flown is kept in {folder}, and the same command goes on from there"
    ]
    code_digest.cache_clear()
    assert run_campaign(plan, folder, workers=1).results.read_bytes() == expected


def test_a_folder_is_for_one_campaign(tmp_path: Path) -> None:
    run_campaign(SMALL, tmp_path / "out", workers=1)
    other = Campaign(SMALL.name, "", SMALL.seed + 1, SMALL.sheets, SMALL.flights, SMALL.runs)
    before = sorted(p.name for p in (tmp_path / "out").rglob("*"))
    with pytest.raises(DiagnosisError, match=r"E802.*holds the campaign `small`") as caught:
        run_campaign(other, tmp_path / "out", workers=1)
    assert caught.value.diagnoses[0].cause == "the campaign's file says something else"
    assert sorted(p.name for p in (tmp_path / "out").rglob("*")) == before
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "thesis.txt").write_text("years of work")
    with pytest.raises(DiagnosisError, match="E802"):
        run_campaign(SMALL, tmp_path / "mine", workers=1)
    assert [p.name for p in (tmp_path / "mine").iterdir()] == ["thesis.txt"]


def test_a_folder_is_for_one_process(tmp_path: Path) -> None:
    told = []

    def again(*_: object) -> None:
        if not told:
            with pytest.raises(DiagnosisError, match="E804") as caught:
                run_campaign(SMALL, tmp_path, workers=1)
            told.append(caught)

    run_campaign(SMALL, tmp_path, workers=1, progress=again)
    assert told


def test_a_run_that_fails_is_told_and_the_rest_goes_on(tmp_path: Path) -> None:
    for name, text in (("no_wind", "vg,vz\n1,2\n"), ("broken", "vg,vz\n1\n")):
        (tmp_path / f"{name}.csv").write_text(text)
    (tmp_path / "mixed.yaml").write_text(
        """\
campaign: mixed
sheets: [umhe_fte]
flights:
  mixed: {recorded: [no_wind.csv, a320_calm_350kt_5000ft, broken.csv], part: 10}
runs:
  hit: {flights: mixed, count: 6, sensors: vc_1, kinds: bias, onset: 4}
"""
    )
    done = subprocess.run(
        [*COMMAND, str(tmp_path / "mixed.yaml"), "-o", str(tmp_path / "out"), "--workers", "1"],
        capture_output=True,
        text=True,
    )
    assert done.returncode == 1, done.stderr
    assert "E502: " in done.stdout and "E505: " in done.stdout
    rows = list(rows_of(tmp_path / "out" / "results.parquet"))
    assert [bool(row.failure) for row in rows] == [True, True, False, False, True, True]
    assert "no column `theta`" in rows[0].failure
    assert rows[2].flight == "a320_calm_350kt_5000ft" and rows[2].vc_kind == "bias"


def _die_of_three(number: int) -> int:
    if number == 3:
        os.kill(os.getpid(), signal.SIGKILL)
    return number * number


def _lost(number: int) -> int:
    return -number


def test_a_process_that_dies_takes_only_its_item_with_it() -> None:
    found = dict(spread(_die_of_three, range(9), 2, _lost))
    assert found == {n: -3 if n == 3 else n * n for n in range(9)}


def test_few_items_wait_at_a_time() -> None:
    taken = []

    def source():
        for number in range(40):
            taken.append(number)
            yield number

    results = spread(abs, source(), 2, _lost)
    first = next(results)
    assert len(taken) <= pool.AHEAD * 2 + 1
    assert sorted([first, *results]) == [(n, n) for n in range(40)]


def test_bad_arguments_are_told_together(tmp_path: Path) -> None:
    done = subprocess.run(
        [*COMMAND, "table_v", "--workers", "0", "--set", "n_QP"], capture_output=True, text=True, cwd=tmp_path
    )
    assert done.returncode == 2 and done.stdout == ""
    for code in ("E803", "E609", "E603"):
        assert f"error[{code}]" in done.stderr
    assert list(tmp_path.iterdir()) == []


def test_the_command_answers_in_json(tmp_path: Path) -> None:
    (tmp_path / "small.yaml").write_text(yaml_of(1, 6))
    command = [*COMMAND, "small.yaml", "-o", "out", "--workers", "1", "--set", "n_detect=4", "--json"]
    done = subprocess.run(command, capture_output=True, text=True, cwd=tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    facts = json.loads(done.stdout)
    assert (facts["campaign"], facts["runs"]) == ("small", 6)
    assert facts["sheets"][0]["sheet"] == "umhe_fte[n_detect=4]" and facts["sheets"][0]["faulty"]["runs"] == 6
    # with another parameter it is another campaign
    command[command.index("n_detect=4")] = "n_detect=3"
    refused = subprocess.run(command, capture_output=True, text=True, cwd=tmp_path)
    assert refused.returncode == 2
    assert [d["code"] for d in json.loads(refused.stdout)["diagnoses"]] == ["E802"]


def test_a_sheet_of_other_ports_is_refused(tmp_path: Path) -> None:
    (tmp_path / "lag.yaml").write_text("sheet: lag\ninputs: {u: {}}\nblocks: {y: {delay: u}}\noutputs: [y]\n")
    text = yaml_of(1, 2).replace("[umhe_fte]", "[lag.yaml]")
    (tmp_path / "odd.yaml").write_text(text)
    with pytest.raises(DiagnosisError, match="E805") as caught:
        run_campaign(load_campaign(str(tmp_path / "odd.yaml")), tmp_path / "out", workers=1)
    assert {d.code for d in caught.value.diagnoses} == {"E805"}
    assert any("input `alpha`" in d.message for d in caught.value.diagnoses)
    assert any("input `u`" in d.message for d in caught.value.diagnoses)
    assert not (tmp_path / "out").exists()
