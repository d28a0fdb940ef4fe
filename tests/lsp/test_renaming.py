"""A new name leaves every sheet of the folder as right as it was, or is refused."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

pytest.importorskip("pygls", reason="the language server of saoflow[lsp] is not installed")

from saoflow import load
from saoflow.lsp.places import Place
from saoflow.lsp.renaming import rename
from saoflow.lsp.workspace import Sheets

FILES = {
    "top": """\
sheet: top
parameters: {T: 0.1, n: 3}
inputs: [x, c]
blocks:
  smooth: {outer: x}
  sums: {fold: horner, count: n, carry: {p: 0}, each: {c: "[c, c, c]"}, in: {x: smooth}}
outputs: {y: "sums[0]"}
""",
    "outer": "sheet: outer\nparameters: {T: inherited}\ninputs: [u]\nblocks: {y: {inner: u}}\noutputs: [y]\n",
    "inner": "sheet: inner\nparameters: {T: inherited, tau: 2}\ninputs: [u]\nblocks: {y: {mul: [u, T/tau]}}\noutputs: [y]\n",
    "horner": "sheet: horner\ninputs: [p, c, x]\nblocks: {px: {mul: [p, x]}, more: {add: [px, c]}}\noutputs: {p: more}\n",
    "variant": "sheet: variant\nparameters_of: base\ninputs: [u]\nblocks: {y: {mul: [u, gain]}}\noutputs: [y]\n",
    "base": "sheet: base\nparameters: {gain: 2}\ninputs: [u]\nblocks: {y: {mul: [u, gain]}}\noutputs: [y]\n",
    "user": """\
sheet: user
parameters: {angle_range: 1, angle_error: 1e-2}
inputs: {x: {unit: 1}}
blocks:
  path: {path_angle: [x, x]}
  y: {lookup: x, function: angle_range*exp(x), range: "[0, 1]", error: 0.1}
outputs: [path.sin, y]
""",
}
ROOTS = ("top", "variant", "base", "user")


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    for name, text in FILES.items():
        (tmp_path / f"{name}.yaml").write_text(text)
    return tmp_path


def costs(folder: Path) -> list[int]:
    return [load(str(folder / f"{name}.yaml")).budget().total for name in ROOTS]


def place(folder: Path, file: str, name: str, kind: str) -> tuple[Sheets, Path, Place]:
    sheets, path = Sheets(), (folder / f"{file}.yaml").resolve()
    readable = sheets.sheet(path)
    assert readable is not None
    return sheets, path, next(p for p in readable.places if (p.name, p.kind, p.defines) == (name, kind, True))


@pytest.mark.parametrize(
    ("file", "name", "kind", "files"),
    [
        ("horner", "p", "wire", {"horner", "top"}),  # a carried input, with the output that it is carried from
        ("horner", "p", "output", {"horner", "top"}),
        ("horner", "c", "wire", {"horner", "top"}),
        ("top", "T", "parameter", {"top", "outer", "inner"}),  # inherited twice
        ("inner", "T", "parameter", {"top", "outer", "inner"}),
        ("inner", "tau", "parameter", {"inner"}),
        ("top", "smooth", "wire", {"top"}),
        ("user", "x", "wire", {"user"}),  # and not the x of the formula
    ],
)
def test_what_is_one_name_by_rule_changes_together(file: str, name: str, kind: str, files: set[str], folder: Path) -> None:
    before = costs(folder)
    found = rename(*place(folder, file, name, kind), "anew")
    assert not isinstance(found, str) and {place.file.stem for place in found} == files
    for one in sorted(found, key=lambda one: (one.position.line, one.position.column), reverse=True):
        lines = one.file.read_text().splitlines(keepends=True)
        text, start = lines[one.position.line - 1], one.position.column - 1
        assert text[start : start + len(name)] == name
        lines[one.position.line - 1] = text[:start] + "anew" + text[start + len(name) :]
        one.file.write_text("".join(lines))
    assert costs(folder) == before


@pytest.mark.parametrize(
    ("file", "name", "kind", "new", "why"),
    [
        ("base", "gain", "parameter", "anew", "by `parameters_of`"),
        ("user", "angle_range", "parameter", "anew", "is a name of sheet `path_angle` too, in another folder"),
        ("inner", "T", "parameter", "smooth", "`smooth` is taken in sheet `top`"),
        ("horner", "p", "wire", "more", "`more` is taken in sheet `horner`"),
        ("top", "x", "wire", "pi", "is no name"),
    ],
)
def test_what_would_break_is_refused(file: str, name: str, kind: str, new: str, why: str, folder: Path) -> None:
    found = rename(*place(folder, file, name, kind), new)
    assert isinstance(found, str) and why in found
    shutil.rmtree(folder)
