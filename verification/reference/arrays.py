"""Small things every step shares: the array types, units, and the saturation of the symbol library."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]
Mask = npt.NDArray[np.bool_]

KNOT = 1852.0 / 3600.0
"""One knot in m/s, exactly (the international nautical mile is 1852 m)."""

DEGREE = np.pi / 180.0
"""One degree in rad."""


def saturate(u: Array, low: Array | float, high: Array | float) -> Array:
    """Limit `u` to [low, high], element-wise; NaN comes out as `low`, as from the symbol `saturation`."""
    limited: Array = np.fmin(np.fmax(u, low), high)
    return limited
