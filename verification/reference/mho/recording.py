"""A recording cut into frames."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np
import numpy.typing as npt

from verification.reference.arrays import Array
from verification.reference.mho.inputs import PORTS


def frames(recording: Mapping[str, npt.ArrayLike]) -> Iterator[Array]:
    """Yield the frames of a recording, (6,) each; other entries are ignored.

    Raises:
        KeyError: an input is missing.
        ValueError: an input is not a column of numbers, or they differ in length.
    """
    yield from np.stack([np.asarray(recording[port], dtype=np.float64) for port in PORTS], axis=1)
