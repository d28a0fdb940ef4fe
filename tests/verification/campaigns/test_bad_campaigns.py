"""The reject corpus: every campaign in bad/ gets exactly the message in the text file of the same name."""

from __future__ import annotations

from pathlib import Path

import pytest

from saoflow import DiagnosisError
from verification.campaigns.reader import load_campaign, shipped_campaigns

BAD = Path(__file__).parent / "bad"
EXPECTED = sorted(BAD.glob("*.txt"))


def diagnose(path: str) -> str:
    """Everything that is said about a campaign; an empty text for a good one."""
    try:
        load_campaign(path)
    except DiagnosisError as error:
        return str(error)
    return ""


@pytest.mark.parametrize("expected", EXPECTED, ids=lambda path: path.stem)
def test_exact_message(expected: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(BAD)
    assert diagnose(f"{expected.stem}.yaml") + "\n" == expected.read_text(encoding="utf-8")


def test_every_case_has_its_message() -> None:
    assert {path.stem for path in BAD.glob("*.yaml")} == {path.stem for path in EXPECTED}


def test_every_diagnosis_says_where_why_and_what_to_do(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(BAD)
    for expected in EXPECTED:
        with pytest.raises(DiagnosisError) as caught:
            load_campaign(f"{expected.stem}.yaml")
        for diagnosis in caught.value.diagnoses:
            assert diagnosis.position is not None and diagnosis.cause and diagnosis.remedy, (expected.stem, diagnosis)


def test_the_shipped_campaigns_can_be_read() -> None:
    names = [load_campaign(name).name for name in shipped_campaigns()]
    assert names == list(shipped_campaigns()) and {"table_iv", "monte_carlo", "comparison"} <= set(names)


def test_a_campaign_that_is_not_there() -> None:
    assert "did you mean `table_iv`?" in diagnose("table_v")
