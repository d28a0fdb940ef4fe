"""The reject corpus: every sheet in sheets/bad gets exactly the message in the text file of the same name."""

from __future__ import annotations

from pathlib import Path

import pytest

from saoflow.diagnosis import DiagnosisError
from saoflow.diagrams.reader import read_sheet

BAD = Path(__file__).parent / "sheets" / "bad"
EXPECTED = sorted(BAD.glob("*.txt"))


def diagnose(path: str) -> str:
    """Everything that is said about a sheet; an empty text for a good one."""
    try:
        read_sheet(path)
    except DiagnosisError as error:
        return str(error)
    return ""


@pytest.mark.parametrize("expected", EXPECTED, ids=lambda path: path.stem)
def test_exact_message(expected: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(BAD)  # file names in messages stand as they were given
    assert diagnose(f"{expected.stem}.yaml") + "\n" == expected.read_text(encoding="utf-8")


def test_every_message_says_where_why_and_what_to_do(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(BAD)
    for expected in EXPECTED:
        with pytest.raises(DiagnosisError) as caught:
            read_sheet(f"{expected.stem}.yaml")
        for diagnosis in caught.value.diagnoses:
            assert diagnosis.position is not None, expected.stem
            assert diagnosis.cause, (expected.stem, diagnosis)
            assert diagnosis.remedy, (expected.stem, diagnosis)
