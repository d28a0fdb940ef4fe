"""How plots look: colours by role, one set of sizes, and SVG whose colours follow the page (light, dark, print).

The colours are Okabe and Ito's, which are told apart with any colour vision; nothing is told by colour alone.
"""

from __future__ import annotations

import io
import re
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from matplotlib.figure import Figure

LIGHT = {
    "ink": "#1b1e23",
    "soft": "#5d646e",
    "faint": "#a9afb8",
    "rule": "#dfe2e6",
    "paper": "#fffffe",
    "estimate": "#0072b2",
    "limit": "#bf4f08",
    "truth": "#1b1e24",
}
"""Colour by role. Every one differs, so that a role can be found again in the SVG."""

DARK = {
    "ink": "#e4e7eb",
    "soft": "#a3abb6",
    "faint": "#7d8693",
    "rule": "#30363e",
    "paper": "#14171b",
    "estimate": "#56b4e9",
    "limit": "#f0a030",
    "truth": "#f4f6f8",
}
"""The same roles on a dark page."""

SETTINGS: dict[str, Any] = {
    "font.family": "sans-serif",
    "font.sans-serif": ["DejaVu Sans"],
    "font.size": 8.0,
    "axes.labelsize": 8.0,
    "axes.titlesize": 8.5,
    "axes.linewidth": 0.6,
    "axes.edgecolor": LIGHT["faint"],
    "axes.labelcolor": LIGHT["soft"],
    "axes.spines.top": False,
    "axes.spines.right": False,
    "xtick.color": LIGHT["faint"],
    "ytick.color": LIGHT["faint"],
    "xtick.labelcolor": LIGHT["soft"],
    "ytick.labelcolor": LIGHT["soft"],
    "xtick.labelsize": 7.5,
    "ytick.labelsize": 7.5,
    "xtick.major.width": 0.6,
    "ytick.major.width": 0.6,
    "xtick.major.size": 2.5,
    "ytick.major.size": 2.5,
    "text.color": LIGHT["ink"],
    "lines.linewidth": 1.1,
    "lines.solid_joinstyle": "round",
    "path.simplify": True,
    "path.simplify_threshold": 0.25,
    "svg.fonttype": "none",
}


@contextmanager
def style(salt: str = "saoflow") -> Iterator[None]:
    """Draw inside this. ``salt`` keeps the identifiers of several SVGs of one page apart, the same every time."""
    import matplotlib

    settings: dict[Any, Any] = {**SETTINGS, "svg.hashsalt": salt}
    with matplotlib.rc_context(settings):
        yield


def svg(figure: Figure, name: str, label: str) -> str:
    """The figure as an ``<svg>`` element: text stays text, colours are ``var(--role)``.

    ``name`` begins its identifiers; ``label`` is what a screen reader says.
    """
    from html import escape

    from matplotlib.backends.backend_svg import FigureCanvasSVG

    FigureCanvasSVG(figure)
    buffer = io.StringIO()
    figure.savefig(buffer, format="svg", transparent=True, metadata={"Date": None, "Creator": None})
    text = buffer.getvalue()
    text = text[text.index("<svg") :]
    text = re.sub(r"<metadata>.*?</metadata>", "", text, flags=re.DOTALL)
    text = re.sub(r'\b(id="|href="#|url\(#)', rf"\g<1>{name}-", text)
    # The page's font, and no size but that of the page's width.
    text = re.sub(r"font: ([\d.]+px) [^;\"]*", r"font-size: \1", text)
    text = re.sub(r'<svg ([^>]*?)height="[^"]*"', r"<svg \1", text, count=1)
    frame = f'width="100%" role="img" aria-label="{escape(label)}"'
    text = re.sub(r'(<svg [^>]*?)width="[^"]*"', lambda match: match[1] + frame, text, count=1)
    for role, colour in LIGHT.items():
        text = text.replace(colour, f"var(--{role})")
    return text


def css_colours() -> str:
    """The colour variables of the page: light, dark where the reader prefers it, light again on paper."""

    def block(colours: dict[str, str]) -> str:
        return "".join(f"--{role}:{colour};" for role, colour in colours.items())

    light, dark = block(LIGHT), block(DARK)
    return (
        f":root{{color-scheme:light dark;{light}}}"
        f"@media (prefers-color-scheme:dark){{:root{{{dark}}}}}"
        f"@media print{{:root{{{light}}}}}"
    )
