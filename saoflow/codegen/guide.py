"""Where the search of a table begins: a guide from buckets of the input to breakpoints.

bucket(u) is a few bits of the number ``u * scale + shift``. A product with a positive number, a sum and the bits of a
positive number never decrease with u, rounding included, so every breakpoint of an earlier bucket is below u and every one of
a later bucket above. The interval is therefore found by comparisons with breakpoints, as in the plain search, and so are
its bits; the guide only says where to begin.

Two kinds: even buckets (``shift`` is so large that the sum is rounded to a whole number, which its last bits then hold), and
buckets that halve towards the lower end (exponent and first bits of the mantissa), for breakpoints that crowd there.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

MOST_BUCKETS = 4096
MANTISSA = {np.dtype(np.float64): 52, np.dtype(np.float32): 23}
WHOLE = {np.dtype(np.float64): np.dtype(np.int64), np.dtype(np.float32): np.dtype(np.int32)}


@dataclass(frozen=True, slots=True, eq=False)
class Guide:
    """``bucket(u) = (low 32 bits of (bits(u * scale + shift) >> drop)) - base``."""

    scale: float
    """1.0: there is no product."""
    shift: float
    drop: int
    base: int
    first: np.ndarray
    """By bucket: the last breakpoint of an earlier bucket (0 if there is none)."""
    within: int
    """Most breakpoints in one bucket."""

    @property
    def steps(self) -> int:
        """Comparisons that the search takes from there."""
        return int(self.within).bit_length()

    def bucket(self, u: np.ndarray) -> np.ndarray:
        """The buckets of inputs between the ends, in the arithmetic of their own type."""
        return _keys(u, self.scale, self.shift, self.drop) - self.base


def guide_of(x: np.ndarray) -> Guide | None:
    """A guide to increasing breakpoints (n,), made in their own type; None where it would not help."""
    best: Guide | None = None
    for guide in (*_even(x), *_halving(x)):
        if best is None or (guide.steps, guide.first.size) < (best.steps, best.first.size):
            best = guide
    return best if best is not None and best.steps + 2 < int(x.size).bit_length() else None


def _keys(u: np.ndarray, scale: float, shift: float, drop: int) -> np.ndarray:
    real = u.dtype.type
    scaled = (u if scale == 1.0 else u * real(scale)) + real(shift)
    bits: np.ndarray = scaled.view(WHOLE[u.dtype]).astype(np.int64)
    return np.asarray((bits >> drop) & 0xFFFFFFFF)


def _guide(x: np.ndarray, scale: float, shift: float, drop: int) -> Guide | None:
    keys = _keys(x, scale, shift, drop)
    bucket = keys - keys[0]
    if bucket[-1] > MOST_BUCKETS or bucket[-1] < 1 or np.any(np.diff(bucket) < 0):
        return None
    before = np.searchsorted(bucket, np.arange(bucket[-1] + 1), side="left")
    first, within = np.maximum(before - 1, 0), int(np.bincount(bucket).max())
    return Guide(scale, shift, drop, int(keys[0]), first, within)


def _even(x: np.ndarray) -> Iterator[Guide]:
    whole = 1.5 * 2.0 ** MANTISSA[x.dtype]  # the distance of its neighbours is 1
    buckets = 1 << max(2, int(x.size - 1).bit_length())
    while buckets <= MOST_BUCKETS:
        with np.errstate(all="ignore"):
            scale = x.dtype.type(buckets) / (x[-1] - x[0])
            low = float(x[0] * scale)
        if not np.isfinite(scale) or abs(low) + buckets > whole / 8:
            return
        # Rounded to a whole number, so that the keys begin near 0 and fit into an offset.
        guide = _guide(x, float(scale), whole - round(low), 0)
        if guide is not None:
            yield guide
            if guide.within == 1:
                return
        buckets *= 2


def _halving(x: np.ndarray) -> Iterator[Guide]:
    least: Any = np.diff(x).min()
    with np.errstate(all="ignore"):
        shift = float(least - x[0])
        low = x[:1] + x.dtype.type(shift)
    if not low[0] > 0 or not np.isfinite(low[0]):
        return
    for kept in range(8):
        guide = _guide(x, 1.0, shift, MANTISSA[x.dtype] - kept)
        if guide is not None:
            yield guide
            if guide.within == 1:
                return
