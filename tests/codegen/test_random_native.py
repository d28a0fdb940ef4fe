"""Random sheets in compiled C, one flight and lanes, against the interpreter; and clean under every compiler."""

from __future__ import annotations

import os
import shutil
import tempfile
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import saoflow
from saoflow.codegen.build import build
from saoflow.codegen.compiler import find_compiler
from tests.codegen.test_build import assert_clean
from tests.codegen.test_native import assert_same
from tests.sheet_text import same_bits
from verification.bits.random_sheets import ROWS, SIDE_SHEETS, sheets

EXAMPLES = int(os.environ.get("SAOFLOW_EXAMPLES", "6"))
pytestmark = pytest.mark.skipif(find_compiler() is None, reason="there is no C compiler on this machine")


@pytest.fixture(scope="module", autouse=True)
def _own_cache(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("XDG_CACHE_HOME", str(tmp_path_factory.mktemp("cache")))
        yield


@settings(max_examples=EXAMPLES, deadline=None, database=None, suppress_health_check=list(HealthCheck))
@given(sheets(), ROWS, st.sampled_from([64, 32]))
def test_random_sheets_run_alike_and_are_clean(text: str, rows: list[list[float]], real: int) -> None:
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for side, content in SIDE_SHEETS.items():
            (folder / f"{side}.yaml").write_text(content, encoding="utf-8")
        (folder / "s.yaml").write_text(text, encoding="utf-8")
        sheet = saoflow.load(str(folder / "s.yaml"))
        slow, fast = sheet.simulator(real=real), sheet.simulator(backend="c", real=real)
        # Nineteen flights: the same rows in turned order, so that lanes differ, and their number is no multiple of a register.
        flat = np.stack([np.roll(np.array(rows), f, axis=0) for f in range(19)])
        ports = {port.name: port.type for port in slow.program.inputs}
        starts = np.cumsum([0, *(t.size for t in ports.values())])
        batch = {
            port: flat[..., start : start + t.size].reshape(*flat.shape[:2], *t.shape)
            for (port, t), start in zip(ports.items(), starts[:-1], strict=True)
        }
        one = {port: array[0] for port, array in batch.items()}
        assert_same(fast.run(one), slow.run(one))
        assert same_bits(fast.state().slots, slow.state().slots)
        slow.reset()
        fast.reset()
        assert_same(fast.run(batch), slow.run(batch))
        assert same_bits(fast.state().slots, slow.state().slots)
        build(sheet, folder / "out", real)
        if shutil.which("gcc") or shutil.which("clang"):
            assert_clean(*(folder / "out").glob("*.c"))
