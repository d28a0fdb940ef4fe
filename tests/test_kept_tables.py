"""Tables kept in the cache folder: the same numbers, found again only where they belong, and never from a damaged file."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from saoflow.formula import NAMED, Formula, X, Y, apply
from saoflow.tables import kept
from saoflow.tables import tabulate as tabulate_module
from saoflow.tables.tabulate import tabulate


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    tabulate_module._tabulate.cache_clear()
    return tmp_path / "saoflow"


SIN = NAMED["sin"]


def fresh(formula: Formula, *ranges: tuple[float, float], error: float = 1e-3) -> tuple[np.ndarray, ...]:
    tabulate_module._tabulate.cache_clear()
    table = tabulate("t", formula, ranges, error)
    return (*table.breakpoints, table.values, np.array(table.error))


@pytest.mark.parametrize(
    ("formula", "ranges"), [(SIN, [(0.0, 1.0)]), (X * apply("exp", Y), [(0.0, 1.0), (-1.0, 0.5)])]
)
def test_the_same_numbers_again_without_a_proof(
    formula: Formula, ranges: list[tuple[float, float]], folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    first = fresh(formula, *ranges)
    assert len(list(folder.glob("table-*"))) == 1
    monkeypatch.setattr(tabulate_module, "_found", None)
    for a, b in zip(first, fresh(formula, *ranges), strict=True):
        assert a.tobytes() == b.tobytes() and a.shape == b.shape


def test_another_formula_range_or_error_is_another_table(folder: Path) -> None:
    for number, (formula, end, error) in enumerate(
        [(X**2, 1.0, 1e-3), (X**2.0000000000000004, 1.0, 1e-3), (X**2, 1.0000000000000002, 1e-3), (X**2, 1.0, 1.1e-3)]
    ):
        fresh(formula, (0.5, end), error=error)
        assert len(list(folder.glob("table-*"))) == number + 1


def test_a_damaged_file_is_no_table(folder: Path) -> None:
    first = fresh(SIN, (0.0, 1.0))
    (path,) = folder.glob("table-*")
    for damage in (path.read_bytes()[:-3], b"", b"[[3], 1]\nxyz"):
        path.write_bytes(damage)
        assert kept.read(path.name) is None
        assert fresh(SIN, (0.0, 1.0))[1].tobytes() == first[1].tobytes()


def test_a_folder_that_cannot_be_written_costs_only_time(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", "/proc")
    assert len(fresh(SIN, (0.0, 1.0))[0]) > 5
