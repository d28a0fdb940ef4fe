"""First files: a commented sheet, an estimator or a campaign, with a recording to run it on."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path

from saoflow.blocks.library import SYMBOLS
from saoflow.diagnosis import Diagnosis, DiagnosisError, did_you_mean, refusal
from saoflow.diagrams.expression_parser import LONGEST_NAME
from saoflow.whole_file import write_whole

TEMPLATES = Path(__file__).parent / "templates"
NEXT = {
    "sheet": (
        "saoflow check {sheet}",
        "saoflow run {sheet} {recording} -o {output} --report {report}",
        "saoflow budget {sheet}",
        "saoflow view {sheet} --run {recording} -o {drawing}",
    ),
    "estimator": (
        "saoflow check {sheet}",
        "saoflow run {sheet} {recording} -o {output} --probe K --report {report}",
        "saoflow budget {sheet} --target mpc755",
        "saoflow view {sheet} --run {recording} -o {drawing}",
        "saoflow build {sheet} -o {code}",
    ),
    "campaign": ("saoflow campaign {sheet} -o {folder}", "saoflow explain E801"),
}
"""What to type next, by kind; the kinds are the templates."""


@dataclass(frozen=True, slots=True)
class FirstFiles:
    """What was written, and the next commands."""

    files: tuple[str, ...]
    commands: tuple[str, ...]


def write_first(name: str, folder: str | os.PathLike[str], kind: str) -> FirstFiles:
    """Write NAME.yaml of a kind, and NAME.csv beside it, into a folder, which is made if it is not there.

    Raises DiagnosisError: E112 (no name), E603 (no such kind), E601 (cannot be written, or is there already); then nothing
    is written.
    """
    _check(name, kind)
    place = Path(folder)
    sheet, recording = place / f"{name}.yaml", place / f"{name}.csv"
    contents = {sheet: (TEMPLATES / f"{kind}.yaml").read_text(encoding="utf-8").replace("NAME", name, 1).encode()}
    template = TEMPLATES / f"{kind}.csv"
    if template.exists():
        contents[recording] = template.read_bytes()
    there = [path for path in contents if path.exists() or path.is_symlink()]
    if there:
        raise DiagnosisError([_unwritable(path, "it is there already", "choose another name, or another folder with -o") for path in there])
    written: list[Path] = []
    try:
        place.mkdir(parents=True, exist_ok=True)
        for path, content in contents.items():
            write_whole(path, content)
            written.append(path)
    except OSError as error:
        for path in written:
            path.unlink()
        why = (error.strerror or str(error)).lower()
        raise DiagnosisError([_unwritable(sheet, why, "name a folder that you may write to with -o")]) from None
    words = {
        "sheet": sheet, "recording": recording, "output": place / f"{name}_out.csv", "report": place / f"{name}_report.html",
        "drawing": place / f"{name}.html", "code": place / f"{name}_c", "folder": place / f"{name}_results",
    }  # fmt: skip
    shown = {key: _shown(path) for key, path in words.items()}
    return FirstFiles(tuple(map(str, contents)), tuple(command.format(**shown) for command in NEXT[kind]))


def _check(name: str, kind: str) -> None:
    if not (name.isidentifier() and name.isascii()):
        cause = "names consist of letters, digits and underscores, and do not start with a digit"
        better = "".join(c if c.isascii() and (c.isalnum() or c == "_") else "_" for c in name.removesuffix(".yaml"))
        good = better.isidentifier() and better.strip("_")
        raise refusal("E112", f"`{name}` is not a name for a sheet", cause=cause, remedy=f"write `{better}`" if good else "choose another name")
    if len(name) > LONGEST_NAME:
        raise refusal("E112", f"a name of {len(name)} characters", cause=f"names have at most {LONGEST_NAME}", remedy="shorten it")
    if name in SYMBOLS and kind != "campaign":
        cause = f"a block `{{{name}: ...}}` is the symbol, so no other sheet could use this one"
        raise refusal("E222", f"`{name}` is a symbol", cause=cause, remedy=f"choose another name, such as my_{name}")
    if kind not in NEXT:
        near = did_you_mean(kind, NEXT) or "write --kind sheet"
        raise refusal("E603", f"`--kind` cannot be `{kind}`", cause=f"it is one of: {', '.join(NEXT)}", remedy=near)


def _shown(path: Path) -> str:
    """A path as a shell takes it."""
    import shlex

    return shlex.quote(str(path))


def _unwritable(path: Path, cause: str, remedy: str) -> Diagnosis:
    return Diagnosis("E601", f"{path} cannot be written", cause=cause, remedy=remedy)
