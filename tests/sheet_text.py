"""Helpers of the tests: a sheet from text, run on arrays."""

from __future__ import annotations

import textwrap
from pathlib import Path
from typing import Any

import numpy as np

import saoflow
from saoflow.pipeline import LoadedSheet


def sheet_of(folder: Path, text: str, name: str = "sheet", **parameters: Any) -> LoadedSheet:
    """Write ``text`` to a file and load it."""
    path = folder / f"{name}.yaml"
    path.write_text(textwrap.dedent(text), encoding="utf-8")
    return saoflow.load(str(path), parameters=parameters)


def run(sheet: LoadedSheet, **inputs: Any) -> dict[str, np.ndarray]:
    """All frames, from the start."""
    return sheet.simulator().run(inputs)


def same_bits(a: np.ndarray, b: np.ndarray) -> bool:
    """Equal in every bit; any NaN equals any NaN."""
    a, b = np.asarray(a), np.asarray(b)
    if a.shape != b.shape or a.dtype != b.dtype:
        return False
    nan = np.isnan(a) & np.isnan(b)
    return bool(np.all(nan | ((a == b) & (np.signbit(a) == np.signbit(b)))))
