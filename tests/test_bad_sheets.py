"""The reject corpus: every sheet in sheets/bad gets exactly the message in the text file of the same name.

A case is NAME.yaml, or a folder NAME with main.yaml and the sheets that it uses; the expected message is NAME.txt.
Paths of shipped sheets are written as {shipped}, since they depend on where saoflow is installed.
"""

from __future__ import annotations

from pathlib import Path

import pytest

from saoflow import DiagnosisError, load
from saoflow.diagrams.store import SHIPPED

BAD = Path(__file__).parent / "sheets" / "bad"
EXPECTED = sorted(BAD.glob("*.txt"))


def sheet_of(case: str) -> str:
    """The sheet of a case, as it is given on the command line."""
    return f"{case}/main.yaml" if (BAD / case).is_dir() else f"{case}.yaml"


def diagnose(path: str) -> str:
    """Everything that is said about a sheet by the complete check; an empty text for a good one."""
    try:
        load(path).check()
    except DiagnosisError as error:
        return str(error).replace(str(SHIPPED), "{shipped}")
    return ""


@pytest.mark.parametrize("expected", EXPECTED, ids=lambda path: path.stem)
def test_exact_message(expected: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(BAD)  # file names in messages stand as they were given
    assert diagnose(sheet_of(expected.stem)) + "\n" == expected.read_text(encoding="utf-8")


def test_every_case_has_its_message() -> None:
    cases = {path.stem for path in BAD.glob("*.yaml")} | {path.name for path in BAD.iterdir() if path.is_dir()}
    assert cases == {path.stem for path in EXPECTED}


def test_every_message_says_where_why_and_what_to_do(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(BAD)
    for expected in EXPECTED:
        with pytest.raises(DiagnosisError) as caught:
            load(sheet_of(expected.stem)).check()
        for diagnosis in caught.value.diagnoses:
            assert diagnosis.position is not None, expected.stem
            assert diagnosis.cause, (expected.stem, diagnosis)
            assert diagnosis.remedy, (expected.stem, diagnosis)
            if diagnosis.position.line > 1 and diagnosis.code != "E104":  # E104: no text that could be shown
                assert diagnosis.source_line is not None, (expected.stem, diagnosis)
