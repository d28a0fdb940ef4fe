"""``saoflow fly``: the file it writes, and what it says to bad input."""

import json
import os
import sys

import numpy as np
import pytest
import typer
from typer.testing import CliRunner

from saoflow import DiagnosisError
from verification.commands.fly import fly
from verification.flights import (
    Fault,
    Missing,
    find_flight,
    load_recording,
    parse_fault,
    parse_missing,
    sensors,
)
from verification.recordings import read_recording

APP = typer.Typer()
APP.command()(fly)


def run(*arguments):
    return CliRunner().invoke(APP, [str(argument) for argument in arguments])


@pytest.mark.parametrize(
    ("text", "fault"),
    [
        ("vc:runaway:-15:onset=20:sensors=1,2,3", Fault("runaway", "vc", rate=-15.0, onset=20.0)),
        ("vc:runaway:rate=-15", Fault("runaway", "vc", rate=-15.0)),
        ("alpha:oscillation:2:frequency=0.7:sensors=2", Fault("oscillation", "alpha", (2,), 2.0, None, 0.7)),
        ("vc:non-return-to-zero", Fault("non_return_to_zero", "vc", amplitude=0.1)),
        (" alpha : bias : 3 : onset = 5 ", Fault("bias", "alpha", amplitude=3.0, onset=5.0)),
    ],
)
def test_fault_text(text, fault):
    assert parse_fault(text) == fault


def test_missing_text():
    assert parse_missing("vg,theta:frames=10:onset=30") == Missing(("vg", "theta"), 30.0, 10)
    assert parse_missing("alpha_2:frames=5:value=-inf") == Missing(("alpha_2",), 20.0, 5, "-inf")


@pytest.mark.parametrize(
    ("parse", "text", "code", "cause"),
    [
        (parse_fault, "", "E712", "it names no sensor and kind"),
        (parse_fault, "vc", "E712", "it names no sensor and kind"),
        (parse_fault, "vv:bias:3", "E712", "`vv` is none of alpha, vc"),
        (parse_fault, "vc:runawy:3", "E712", "`runawy` is none of"),
        (parse_fault, "vc:bias:x", "E712", "`x` is not a number"),
        (parse_fault, "vc:bias:3:4", "E712", "`4` is not NAME=VALUE"),
        (parse_fault, "vc:bias:3:onst=4", "E712", "`onst` is none of"),
        (parse_fault, "vc:bias:3:onset=4:onset=5", "E712", "onset is given twice"),
        (parse_fault, "vc:bias:3:amplitude=4", "E712", "the amplitude is given twice"),
        (parse_fault, "vc:bias:3:sensors=1,4", "E712", "sensor `4` is none of 1, 2, 3"),
        (parse_fault, "vc:bias", "E711", "bias takes amplitude"),
        (parse_fault, "vc:bias:nan", "E711", "it must be finite"),
        (parse_missing, "vg", "E712", "it does not say how many frames"),
        (parse_missing, "vg:frames=2.5", "E712", "`2.5` is not a whole number"),
        (parse_missing, "vg:frames=nan", "E712", "`nan` is not a whole number"),
        (parse_missing, "vh:frames=2", "E714", "inputs are vg"),
    ],
)
def test_text_that_is_not_understood(parse, text, code, cause):
    with pytest.raises(DiagnosisError) as caught:
        parse(text)
    assert caught.value.diagnoses[0].code == code
    assert cause in caught.value.diagnoses[0].cause


def test_it_writes_inputs_and_truth(tmp_path):
    pytest.importorskip("jsbsim")
    path = tmp_path / "x.csv"
    done = run("-o", path, "--noise", "--fault", "vc:runaway:-15:onset=20", "--missing", "vg:frames=3")
    assert done.exit_code == 0, done.output
    assert done.stdout == f"{path}: 1501 frames, 72.0 s, 26 columns\n"
    got = read_recording(path)
    truth = load_recording("a320_calm_350kt_5000ft")
    seed = find_flight("a320_calm_350kt_5000ft").seed
    want = sensors(
        truth, seed, faults=[Fault("runaway", "vc", rate=-15.0)], missing=[Missing(("vg",), 20.0, 3)]
    )
    assert got.names == want.names
    for name in want.names:
        np.testing.assert_allclose(got[name], want[name], rtol=1e-6, atol=1e-6)
    assert os.listdir(tmp_path) == ["x.csv"]


def test_json(tmp_path):
    pytest.importorskip("jsbsim")
    done = run("-o", tmp_path / "x.csv.gz", "--flight", "787_calm_350kt_5000ft", "--json")
    facts = json.loads(done.stdout)
    assert facts["frames"] == 1251
    assert facts["columns"][0] == "t"
    readings = read_recording(tmp_path / "x.csv.gz")
    assert (readings["alpha_1"] == readings["alpha_true"]).all()


def test_list_names_every_flight():
    lines = run("--list").stdout.splitlines()
    assert lines[0].startswith("a320_calm_350kt_5000ft")
    assert {line.split()[0] for line in lines} == {p["name"] for p in json.loads(run("--list", "--json").stdout)}


def test_everything_wrong_is_said_at_once_and_nothing_is_written(tmp_path):
    done = run(
        "-o", tmp_path / "no" / "x.csv", "--flight", "a320_clam_350kt_5000ft",
        "--fault", "vc:runawy:3", "--missing", "vh:frames=3",
    )  # fmt: skip
    assert done.exit_code == 2
    assert done.stdout == ""
    codes = [line[6:10] for line in done.stderr.splitlines() if line.startswith("error[")]
    assert codes == ["E701", "E712", "E714", "E601"]
    assert "did you mean `a320_calm_350kt_5000ft`?" in done.stderr
    assert "did you mean `runaway`?" in done.stderr
    assert "Traceback" not in done.output
    assert os.listdir(tmp_path) == []


@pytest.mark.parametrize(
    ("arguments", "code", "words"),
    [
        ([], "E609", "the option -o is missing"),
        (["-o", "x.csv", "--aircraft", "A230"], "E702", "did you mean `A320`?"),
        (["-o", "x.xlsx"], "E601", ".csv, .csv.gz or .parquet"),
        (["-o", "x.csv", "--fault", "vc:bias:3:onset=100"], "E711", "ends at 72 s"),
        (["-o", "x.csv", "--missing", "vg:frames=3:onset=100"], "E714", "ends at 72 s"),
        (["-o", "x.csv", "--seed", "-4"], "E705", "seed = -4"),
    ],
)
def test_each_mistake(tmp_path, monkeypatch, arguments, code, words):
    monkeypatch.chdir(tmp_path)
    done = run(*arguments)
    assert done.exit_code == 2
    assert done.stderr.startswith(f"error[{code}]: ")
    assert words in done.stderr
    as_json = json.loads(run(*arguments, "--json").stdout)
    assert [d["code"] for d in as_json["diagnoses"]] == [code]
    assert os.listdir(tmp_path) == []


def test_without_jsbsim(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "jsbsim", None)
    done = run("-o", tmp_path / "x.csv")
    assert done.exit_code == 2
    assert "error[E703]" in done.stderr
    assert "pip install 'saoflow[flights]'" in done.stderr
    assert os.listdir(tmp_path) == []
