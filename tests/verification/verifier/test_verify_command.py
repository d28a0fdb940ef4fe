"""``saoflow verify`` as a command: exit codes, JSON, and what a wrong request gets."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
import typer
from typer.testing import CliRunner

from verification.commands.verify import verify
from verification.verifier.find import SHIPPED

HERE = Path(__file__).parent
LAG = str(HERE / "lag.yaml")


@pytest.fixture(scope="module")
def app():
    app = typer.Typer()
    app.command()(verify)
    return app


@pytest.fixture
def run(app, monkeypatch):
    monkeypatch.chdir(HERE)  # where the reference's module lies
    return lambda *arguments: CliRunner().invoke(app, list(arguments))


def test_a_sheet_that_equals_its_reference_exits_0(run):
    result = run("lag.yaml", "--reference", "lag_reference:case", "--frames", "60")
    assert result.exit_code == 0, result.output
    assert "lag equals its reference" in result.stdout


def test_a_plain_function_and_json(run):
    result = run("lag.yaml", "--reference", "lag_reference:run", "--frames", "60", "--seed", "3", "--json")
    report = json.loads(result.stdout)
    assert result.exit_code == 0
    assert (report["passed"], report["frames"], report["seed"]) == (True, 60, 3)


def test_a_failed_check_exits_1(run, tmp_path):
    text = Path(LAG).read_text(encoding="utf-8")
    path = tmp_path / "lag.yaml"
    path.write_text(text.replace("value: 0.25", "value: 0.26"), encoding="utf-8")
    result = run(str(path), "--reference", "lag_reference:case", "--frames", "60")
    assert result.exit_code == 1
    assert "FAILS" in result.stdout and "first in the order of the frame: y, wire y" in " ".join(result.stdout.split())


MESSAGES = {
    (): f"""\
error[E604]: there is no reference for the sheet `lag`
    = cause: the sheets with a reference are: {", ".join(sorted(SHIPPED))}
    = remedy: name yours with --reference module:name, or in the entry-point group saoflow.references
""",
    ("--reference", "lag_reference"): """\
error[E603]: --reference cannot be `lag_reference`
    = cause: a reference is named by its module and its name in it
    = remedy: write --reference module:name, such as my_references:lag
""",
    ("--reference", "no_such_module:f"): """\
error[E604]: the reference module `no_such_module` cannot be imported
    = cause: there is no module `no_such_module`
    = remedy: run saoflow from the folder that holds the module, or install it
""",
    ("--reference", "lag_reference:cas"): """\
error[E604]: the module `lag_reference` has no `cas`
    = cause: its names are: annotations, replace, np, Choice, ClosedLoop, Closeness, Compared, Decision, Expected, \
ReferenceCase, Scenario, SHARE
    = remedy: did you mean `case`?
""",
    ("--reference", "lag_reference:not_a_reference"): """\
error[E604]: `lag_reference:not_a_reference` is no reference
    = cause: its type is int
    = remedy: name a function from a dictionary of input arrays to one of output arrays, or a ReferenceCase
""",
    ("--reference", "lag_reference:fails"): """\
error[E604]: the reference of `lag` cannot be used
    = cause: it raised ZeroDivisionError: by hand
    = remedy: a reference takes a dictionary of input arrays, one row a frame, and gives one of output arrays
""",
    ("--reference", "lag_reference:forgets"): """\
error[E604]: the reference of `lag` cannot be used
    = cause: it gave no latched; it gave y
    = remedy: a reference takes a dictionary of input arrays, one row a frame, and gives one of output arrays
""",
    ("--reference", "lag_reference:wrong_shape", "--frames", "9"): """\
error[E604]: the reference of `lag` cannot be used
    = cause: its y has shape [3], expected is [3, 2]
    = remedy: a reference takes a dictionary of input arrays, one row a frame, and gives one of output arrays
""",
    ("--reference", "lag_reference:words"): """\
error[E604]: the reference of `lag` cannot be used
    = cause: its y is not an array of numbers: could not convert string to float: 'high'
    = remedy: a reference takes a dictionary of input arrays, one row a frame, and gives one of output arrays
""",
    ("--reference", "lag_reference:failing_case"): """\
error[E604]: the reference of `lag` cannot be used
    = cause: in frame 0 of noise it raised ZeroDivisionError: by hand
    = remedy: mend the reference
""",
    ("--reference", "lag_reference:misfit_case"): """\
error[E604]: the reference of `lag` cannot be used
    = cause: for way the wire length2 has shape [], the reference gives [2]
    = remedy: compare a wire of the same shape
""",
    ("--frames", "0", "--seed", "-1"): """\
error[E603]: --frames cannot be 0
    = cause: a verification compares 1 to 1000000 frames
    = remedy: for example --frames 10000
error[E603]: --seed cannot be -1
    = cause: seeds are whole numbers from 0
    = remedy: for example --seed 1
""",
}


@pytest.mark.parametrize("options", MESSAGES, ids=lambda options: " ".join(options) or "no reference")
def test_wrong_requests_get_a_diagnosis_and_exit_2(run, options):
    result = run("lag.yaml", *options)
    assert result.exit_code == 2
    assert result.stderr == MESSAGES[options]
    as_json = run("lag.yaml", *options, "--json")
    assert as_json.exit_code == 2
    assert json.loads(as_json.stdout)["diagnoses"][0]["code"] == MESSAGES[options][6:10]


def test_a_sheet_that_does_not_exist(run):
    result = run("no_such_sheet.yaml")
    assert result.exit_code == 2
    assert result.stderr.startswith("error[E602]") or "E101" in result.stderr


def test_a_case_that_names_a_wire_the_sheet_lacks(run, tmp_path):
    text = Path(LAG).read_text(encoding="utf-8").replace("way", "path")
    (tmp_path / "lag.yaml").write_text(text, encoding="utf-8")
    result = run(str(tmp_path / "lag.yaml"), "--reference", "lag_reference:case")
    assert result.exit_code == 2
    assert "error[E303]: there is no wire `way`" in result.stderr
