"""`saoflow explain` and docs/diagnoses.md: complete, and every example gives its code, with the message that is shown."""

from __future__ import annotations

import json
import re

import pytest

from saoflow import cli
from saoflow.authoring import catalogue
from saoflow.authoring.explanation import EXAMPLES, explanation, explanations
from saoflow.authoring.run_example import run_example
from saoflow.codes import CODES

RENEW = "python -m saoflow.authoring.catalogue"
UNMADE = {"E302", "E610", "E611", "E699", "E806", "E808"}
"""Codes that no quick command gives: their entry says how they come about."""


def test_every_code_is_explained_and_nothing_else() -> None:
    assert {path.stem for path in EXAMPLES.glob("*.yaml")} == set(CODES)
    assert {path.stem for path in EXAMPLES.glob("*.txt")} == set(CODES) - UNMADE, RENEW
    for entry in explanations():
        assert len(entry.cause) > 20 and len(entry.remedy) > 10, entry.code
        assert bool(entry.commands) != bool(entry.how), entry.code
        assert bool(entry.how) == (entry.code in UNMADE), entry.code


@pytest.mark.parametrize("code", [code for code in CODES if code not in UNMADE])
def test_the_example_gives_the_code_and_the_message(code: str) -> None:
    if code in ("E703", "E704"):
        pytest.importorskip("jsbsim")
    said = run_example(explanation(code))
    assert set(re.findall(r"^\S*:? ?(?:error|warning)\[(\w+)\]", said, re.M)) == {code}, said
    assert said == explanation(code).message, RENEW


def test_the_page_is_fresh() -> None:
    assert catalogue.PAGE.read_text(encoding="utf-8") == catalogue.page(), RENEW


def test_the_page_has_every_code_once() -> None:
    assert re.findall(r"^### (\w+)$", catalogue.page(), re.M) == list(CODES)


def test_the_command_shows_an_entry(capsys: pytest.CaptureFixture[str]) -> None:
    for word in ("E211", "e211", "error[E211]"):
        assert cli.run(["explain", word]) == 0
        out = capsys.readouterr().out
        assert out.startswith("error[E211]: units do not fit\n")
        assert "vt: {add: [vg, -wx]}" in out and "$ saoflow check wind.yaml" in out and "\nRemedy: " in out
        assert "kt meets m/s: 1 kt = 0.514444 m/s" in out
    assert cli.run(["explain", "E302"]) == 0
    assert "Example" not in capsys.readouterr().out
    assert cli.run(["explain"]) == 0
    out = capsys.readouterr().out
    assert all(re.search(rf"^{code}  \S", out, re.M) for code in CODES)


def test_the_command_answers_in_json(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.run(["explain", "--json"]) == 0
    listed = json.loads(capsys.readouterr().out)["explanations"]
    assert [entry["code"] for entry in listed] == list(CODES)
    assert cli.run(["explain", "W501", "--json"]) == 0
    entry = json.loads(capsys.readouterr().out)
    assert entry["severity"] == "warning" and entry["example"]["commands"] == ["saoflow run lag.yaml in.csv -o out.csv"]
    assert entry == {**listed[list(CODES).index("W501")], "diagnoses": []}


def test_an_unknown_code_is_refused(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.run(["explain", "E2111"]) == 2
    assert "did you mean `E211`?" in capsys.readouterr().err
