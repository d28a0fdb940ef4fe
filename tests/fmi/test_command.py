"""``saoflow fmu``: what it writes, what it says, and what it refuses before or after the work."""

from __future__ import annotations

import json
import stat
import zipfile
from pathlib import Path

import pytest

from saoflow.cli import run
from tests.fmi.importer import MIXED, fmpy

NO_PERIOD = "sheet: bare\ninputs: {u: {}}\nblocks: {y: {add: [u, 1]}}\noutputs: [y]\n"


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty working folder with two sheets."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "mixed.yaml").write_text(MIXED, encoding="utf-8")
    (tmp_path / "bare.yaml").write_text(NO_PERIOD, encoding="utf-8")
    return tmp_path


def fmu(*arguments: str) -> int:
    """The exit code of the command line."""
    return run(["fmu", *arguments])


def test_writes_a_unit_that_runs(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert fmu("mixed.yaml", "--set", "gain=7") == 0
    told = capsys.readouterr().out
    assert told.startswith(
        "mixed: FMI 3.0 co-simulation, a frame every 0.02 s; variables: 5 inputs, 6 outputs, 4 states"
    )
    assert fmpy.validation.validate_fmu("mixed.fmu") == []
    result = fmpy.simulate_fmu("mixed.fmu", stop_time=0.1, output=["sum", "parameters.gain"])
    assert result["parameters.gain"].tolist() == [7.0] * 6
    assert [path.name for path in here.iterdir() if path.name.startswith(".")] == []


def test_facts_for_machines(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert fmu("bare.yaml", "--period", "0.5", "--version", "2", "-o", "x.fmu", "--source-only", "--json") == 0
    facts = json.loads(capsys.readouterr().out)
    assert (facts["fmi"], facts["period"], facts["inputs"], facts["binary"]) == ("2.0", 0.5, 1, None)
    assert facts["bytes"] == (here / "x.fmu").stat().st_size
    assert facts["diagnoses"] == []


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["bare.yaml"], ["error[E107]: `bare` states no frame period", "bare.yaml:1:8", "--period"]),
        (["bare.yaml", "--period", "-1"], ["error[E603]: a frame period cannot be -1 s"]),
        (["bare.yaml", "--period", "nan"], ["error[E603]: a frame period cannot be nan s"]),
        (["mixed.yaml", "--period", "0.1"], ["error[E603]: the frame period of `mixed` is 0.02 s, not 0.1 s"]),
        (["mixed.yaml", "--version", "1"], ["error[E603]: `--version` cannot be `1`"]),
        (["mixed.yaml", "--real", "16"], ["error[E603]: `--real` cannot be `16`"]),
        (["mixed.yaml", "--set", "gian=1"], ["error[E206]", "did you mean `gain`?"]),
        (["mixed.yaml", "-o", "unit.zip"], ["error[E601]: unit.zip", "unit.zip.fmu"]),
        (["mixed.yaml", "-o", "no/such/unit.fmu"], ["error[E601]", "there is no folder `no/such`"]),
        (["mixed.yaml", "-o", "folder.fmu"], ["error[E601]: folder.fmu", "it is a folder"]),
        (["mixed.yaml", "-o", "text.fmu"], ["error[E601]: text.fmu", "is no unit"]),
        (["mixd"], ["error[E602]: there is no sheet `mixd`"]),
    ],
)
def test_refused(here: Path, arguments: list[str], said: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    (here / "folder.fmu").mkdir()
    (here / "text.fmu").write_text("precious", encoding="utf-8")
    before = {path.name for path in here.iterdir()}
    assert fmu(*arguments) == 2
    told = capsys.readouterr().err
    for text in said:
        assert text in told
    assert {path.name for path in here.iterdir()} == before
    assert (here / "text.fmu").read_text(encoding="utf-8") == "precious"


def test_a_unit_is_replaced_as_a_whole(here: Path) -> None:
    assert fmu("mixed.yaml", "--source-only") == 0
    assert fmu("mixed.yaml", "--source-only", "--version", "2") == 0
    with zipfile.ZipFile("mixed.fmu") as file:
        assert b'fmiVersion="2.0"' in file.read("modelDescription.xml")


def test_without_a_compiler_sources_and_a_warning(
    here: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("saoflow.codegen.compiler.find_compiler", lambda: None)
    assert fmu("mixed.yaml") == 0
    captured = capsys.readouterr()
    assert "warning[W607]: the unit holds C sources and no binary" in captured.err
    assert "4 states, 2 constants; sources; mixed.fmu" in captured.out
    assert fmpy.validation.validate_fmu("mixed.fmu") == []
    with zipfile.ZipFile("mixed.fmu") as file:
        assert not [name for name in file.namelist() if name.startswith("binaries/")]


def test_a_compiler_that_fails(here: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    broken = here / "broken-cc"
    broken.write_text(
        '#!/bin/sh\ncase "$1" in --version) echo broken 1.0;; *) echo "error: out of luck" >&2; exit 3;; esac\n',
        encoding="ascii",
    )
    broken.chmod(broken.stat().st_mode | stat.S_IXUSR)
    monkeypatch.setenv("SAOFLOW_CC", "./broken-cc")  # it must be found from wherever it is called
    assert fmu("mixed.yaml") == 2
    captured = capsys.readouterr()
    assert "error[E607]: the C code of the unit cannot be compiled" in captured.err
    assert "error: out of luck" in captured.err
    assert not (here / "mixed.fmu").exists()


def test_a_full_disk_leaves_nothing(
    here: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def full(*_: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("saoflow.fmi.unit.os.replace", full)
    assert fmu("mixed.yaml", "--source-only") == 2
    assert "mixed.fmu: cannot be written" in capsys.readouterr().err
    assert sorted(path.name for path in here.iterdir()) == ["bare.yaml", "mixed.yaml"]


def test_over_budget_is_refused(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (here / "over.yaml").write_text(NO_PERIOD + "budget: {add: 0, period: 1}\n", encoding="utf-8")
    assert fmu("over.yaml") == 1
    assert "E401" in capsys.readouterr().err
