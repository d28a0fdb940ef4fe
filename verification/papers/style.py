"""How the papers' pictures look: the fonts and colours of the report, a light grid, PNG.

with figure(7.0, 3.0) as drawn:
    axes = drawn.subplots(1, 2)
    axes[0].plot(t, x, color=COLOURS[0], label="EKF")
    save(drawn, pictures / "003_fig_3.png")
"""

from __future__ import annotations

import io
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from saoflow.report.style import LIGHT, SETTINGS
from saoflow.whole_file import write_whole

if TYPE_CHECKING:
    from matplotlib.figure import Figure

COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9")
"""One for each curve, in this order: Okabe and Ito's, told apart with any colour vision. They are the cycle, too."""

TRUTH = LIGHT["truth"]
"""The colour of what is true; thin, beneath the estimates."""

LIMIT = LIGHT["limit"]
"""The colour of thresholds and bounds; dashed."""

SOFT = LIGHT["soft"]
"""The colour of remarks and of what stands in the background."""

DPI = 110

LARGEST = 150_000
"""Bytes of a picture."""


def _settings() -> dict[Any, Any]:
    from cycler import cycler

    return {
        **SETTINGS,
        "axes.prop_cycle": cycler(color=COLOURS),
        "axes.grid": True,
        "axes.axisbelow": True,
        "grid.color": LIGHT["rule"],
        "grid.linewidth": 0.5,
        "legend.frameon": False,
        "legend.fontsize": 7.5,
        "figure.facecolor": LIGHT["paper"],
        "axes.facecolor": "none",
        "figure.constrained_layout.use": True,
    }


@contextmanager
def figure(width: float, height: float) -> Iterator[Figure]:
    """An empty figure of this size [inches], drawn and saved inside the context. No display is needed."""
    import matplotlib
    from matplotlib.figure import Figure

    with matplotlib.rc_context(_settings()):
        yield Figure(figsize=(width, height))


def save(figure: Figure, path: Path) -> None:
    """Write the figure as PNG, all of it or nothing, the same bytes every time.

    Raises OSError, and ValueError if the picture is larger than :data:`LARGEST`.
    """
    drawn = io.BytesIO()
    figure.savefig(drawn, format="png", dpi=DPI, metadata={"Software": None})
    if len(drawn.getvalue()) > LARGEST:
        raise ValueError(f"{path.name} has {len(drawn.getvalue())} bytes of {LARGEST}: draw fewer points")
    write_whole(path, drawn.getvalue())
