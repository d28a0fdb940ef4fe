"""Drawn flights are recorded once and kept; what keeps them is their content."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from saoflow import DiagnosisError
from verification.campaigns import flights as kept
from verification.campaigns.plan import DrawnFlights, Range
from verification.flights import drawn
from verification.flights.drawn import measure_wind

DRAWN = DrawnFlights("short", 2, 3, ("A320",), Range(20.0, 24.0), Range(190.0, 350.0), Range(3000.0, 20000.0), "inside")


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    kept._remembered_drawn.cache_clear()
    return tmp_path / "saoflow_flights"


def test_recorded_once_and_again_when_damaged(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("jsbsim")
    assert not kept.is_kept(DRAWN, 1)
    first = kept.flown(DRAWN, 1)
    assert kept.is_kept(DRAWN, 1) and not kept.is_kept(DRAWN, 0)
    assert first.aircraft == "A320" and measure_wind(first.truth).inside
    assert 22.0 <= (len(first.truth) - 1) * first.truth.period <= 24.0  # the longer half of two
    flown: list[object] = []
    draw = drawn.draw_flight

    def counted(*arguments: object) -> object:
        flown.append(arguments)
        return draw(*arguments)  # type: ignore[arg-type]

    monkeypatch.setattr(drawn, "draw_flight", counted)
    kept._remembered_drawn.cache_clear()
    again = kept.flown(DRAWN, 1)
    assert not flown and again.name == first.name
    (file,) = folder.iterdir()
    file.write_bytes(file.read_bytes()[:2000])
    kept._remembered_drawn.cache_clear()
    third = kept.flown(DRAWN, 1)
    assert len(flown) == 1
    for name in kept.NEEDED:
        np.testing.assert_array_equal(first.truth[name], again.truth[name])
        np.testing.assert_array_equal(first.truth[name], third.truth[name])


def test_a_folder_that_cannot_be_written_only_costs_time(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("jsbsim")
    (tmp_path / "saoflow_flights").write_text("a file, not a folder")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    kept._remembered_drawn.cache_clear()
    assert len(kept.flown(DRAWN, 0).truth) > 400


def test_the_recorders_statements_count_and_its_words_do_not(tmp_path: Path) -> None:
    def statements(text: str) -> str:
        (tmp_path / "code.py").write_text(text)
        return kept._statements(tmp_path / "code.py")

    plain = statements('"""Doc."""\ndef f(x):\n    """Says."""\n    return x + 1\n')
    assert statements('"""Other."""\n\n# remark\ndef f(x):\n    return (x +\n            1)\n') == plain
    assert statements("def f(x):\n    return x + 2\n") != plain


def test_a_recording_without_truth_is_refused(tmp_path: Path) -> None:
    (tmp_path / "bare.csv").write_text("vg,vz\n1,2\n")
    with pytest.raises(DiagnosisError, match=r"E502.*no column `theta`"):
        kept.recorded(str(tmp_path / "bare.csv"))
