"""Tables that were proved before, kept in the user's cache folder: finding a table and its proof costs, reading it does not.

A table is found again by all that it depends on: formula, range, error, and the text of the code that finds and proves.
"""

from __future__ import annotations

import contextlib
import hashlib
import json
from collections.abc import Sequence
from functools import lru_cache
from importlib.util import find_spec
from pathlib import Path

import numpy as np

from saoflow import formula as formula_module
from saoflow.cache import cache_folder
from saoflow.formula import Formula

Numbers = tuple[tuple[np.ndarray, ...], np.ndarray, float]
"""Breakpoints of each axis, values, and the proved error."""


def key_of(formula: Formula, ends: Sequence[tuple[float, float]], error: float, relative: bool, linear: bool) -> str:
    """The name of a table's file."""
    what = [repr(formula), [[low.hex(), high.hex()] for low, high in ends], error.hex(), relative, linear]
    return f"table-{hashlib.sha256(f'{_code()}{json.dumps(what)}'.encode()).hexdigest()[:40]}"


def read(key: str) -> Numbers | None:
    """The numbers of a table; None if it is not kept, or not as a table should be."""
    content = cache_folder().read(key)
    if content is None:
        return None
    try:
        head, _, body = content.partition(b"\n")
        sizes, proved = json.loads(head)
        numbers = np.frombuffer(body, dtype="<f8").astype(np.float64)
        axes = tuple(np.split(numbers[: sum(sizes)], np.cumsum(sizes)[:-1]))
        return axes, numbers[sum(sizes) :].reshape(sizes), float.fromhex(proved)
    except (ValueError, TypeError):
        return None


def write(key: str, numbers: Numbers) -> None:
    """Keep a table; where that cannot be, it is found anew next time."""
    axes, values, proved = numbers
    head = json.dumps([[len(axis) for axis in axes], float(proved).hex()]).encode()
    body = np.concatenate([*axes, values.ravel()]).astype("<f8").tobytes()
    with contextlib.suppress(OSError):
        cache_folder().write(key, head + b"\n" + body)


@lru_cache(maxsize=1)
def _code() -> str:
    """What the numbers depend on beside their arguments."""
    here = Path(__file__).parent
    files = [*sorted(here.glob("*.py")), here.parent / "enclosure.py", Path(formula_module.__file__)]
    flint = find_spec("flint")  # its first file names its version; importing it, or reading metadata, would take longer than a table
    files += [Path(flint.origin)] if flint is not None and flint.origin is not None else []
    digest = hashlib.sha256(b"".join(path.read_bytes() for path in files))
    return f"{digest.hexdigest()} {np.__version__}"
