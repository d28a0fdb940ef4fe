"""The colours of drawings: the roles of the reports', and those that only a drawing has. Light, dark, and light on paper."""

from __future__ import annotations

from pathlib import Path

from saoflow.report.style import DARK, LIGHT

FOLDER = Path(__file__).parent / "browser"
"""The files of the page."""

OWN_LIGHT = {
    "tint": "#f3f5f8",
    "wire": "#4a515b",
    "memory": "#e3eef8",
    "memory-line": "#3b7cb0",
    "decision": "#fbf3e2",
    "flag": "#a06a00",
    "lit": "#ffd9a8",
    "is-dark": "0",
}

OWN_DARK = {
    "tint": "#1c2127",
    "wire": "#9aa4b0",
    "memory": "#16293a",
    "memory-line": "#5aa5dd",
    "decision": "#2b2415",
    "flag": "#d9a440",
    "lit": "#6b430f",
    "is-dark": "1",
}


def css_colours() -> str:
    """The colour variables: by the reader's preference, or as the page was switched; light on paper."""

    def block(*colours: dict[str, str]) -> str:
        return "".join(f"--{role}:{colour};" for group in colours for role, colour in group.items())

    light, dark = block(LIGHT, OWN_LIGHT), block(DARK, OWN_DARK)
    return (
        f":root{{color-scheme:light;{light}}}"
        f"@media (prefers-color-scheme:dark){{:root{{color-scheme:dark;{dark}}}}}"
        f":root[data-theme=dark]{{color-scheme:dark;{dark}}}"
        f":root[data-theme=light]{{color-scheme:light;{light}}}"
        f"@media print{{:root,:root[data-theme=dark]{{color-scheme:light;{light}}}}}"
    )


def picture_css() -> str:
    """The page's rules for what is drawn, its light colours put in: the style of a picture that stands by itself."""
    css = (FOLDER / "view.css").read_text(encoding="utf-8")
    css = css[css.index("\n.box{") + 1 : css.index("@media")]
    for role, colour in {**LIGHT, **OWN_LIGHT}.items():
        css = css.replace(f"var(--{role})", colour)
    return css
