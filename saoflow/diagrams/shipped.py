"""Where sheets lie: the shipped ones by name, and the file that a user's name stands for. Reads no sheet, imports nothing heavy."""

from __future__ import annotations

from pathlib import Path

SHIPPED = Path(__file__).parent
LIBRARY = SHIPPED / "library"


def shipped_sheets() -> dict[str, Path]:
    """The shipped sheets by name; the library first."""
    found: dict[str, Path] = {}
    folders = [LIBRARY, *sorted(p for p in SHIPPED.iterdir() if p.is_dir() and p != LIBRARY)]
    for folder in folders:
        for path in sorted(folder.glob("*.yaml")):
            found.setdefault(path.stem, path)
    return found


def estimators() -> list[str]:
    """The names of the shipped sheets that are made to run by themselves: those that state a budget."""
    paths = shipped_sheets().items()
    return sorted(name for name, path in paths if "\nbudget:" in path.read_text(encoding="utf-8"))


def place_of(name: str, shipped: dict[str, Path]) -> Path | None:
    """The file of the sheet that a user names: a path, or the name of a shipped sheet. None if it is neither."""
    if name in shipped and not Path(name).exists():
        return shipped[name]
    path = Path(name)
    return path if path.suffix in (".yaml", ".yml") or path.exists() else None


def shown_path(path: Path) -> Path:
    """A path as messages show it: relative to the working folder where that is shorter."""
    try:
        short = path.resolve().relative_to(Path.cwd())
    except ValueError:
        return path
    return short if not path.is_absolute() or len(str(short)) < len(str(path)) else path
