"""Units that several tests use, compiled once; instances are made anew."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from saoflow.fmi import Unit, build_unit
from saoflow.pipeline import LoadedSheet
from tests.fmi.importer import MIXED, Importer
from tests.sheet_text import sheet_of


@pytest.fixture(scope="session")
def mixed(tmp_path_factory: pytest.TempPathFactory) -> LoadedSheet:
    """The small sheet with all kinds of ports."""
    return sheet_of(tmp_path_factory.mktemp("sheets"), MIXED, "mixed")


@pytest.fixture(scope="session", params=[3, 2], ids=["FMI 3", "FMI 2"])
def unit(request: pytest.FixtureRequest, mixed: LoadedSheet) -> Unit:
    """Its unit, in both versions."""
    return build_unit(mixed, request.param, optimisation="-O0")


@pytest.fixture
def instance(unit: Unit, tmp_path: Path) -> Iterator[Importer]:
    """An instance that is not initialised yet."""
    importer = Importer(unit, tmp_path)
    yield importer
    importer.close()
