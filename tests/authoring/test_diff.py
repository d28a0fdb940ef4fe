"""`saoflow diff`: what differs in meaning is told, where it is; what does not is not."""

from __future__ import annotations

import json
import random
import re
import time
from pathlib import Path

import pytest

from saoflow import cli, load
from saoflow.authoring.difference import Change, difference
from saoflow.diagrams.store import SHIPPED

LAG = """\
sheet: lag
parameters: {k: 0.25}
inputs: {vc: {shape: [3], unit: kt, doc: three sensors}}
blocks:
  sum: {add: ["vc[0]", "vc[1]", "vc[2]"]}
  new: {mul: [sum, k/3]}
  old: {mul: [before, 1 - k]}
  smooth: {add: [new, old]}
  before: {delay: smooth, initial: 240, unit: kt}
outputs: [smooth]
budget: {operations: 10, period: 0.1}
"""


def changes(folder: Path, before: str, after: str) -> list[Change]:
    """The differences of two texts."""
    nets = []
    for name, text in (("a", before), ("b", after)):
        (folder / f"{name}.yaml").write_text(text)
        nets.append(load(str(folder / f"{name}.yaml")).netlist)
    return difference(*nets).changes


def brief(found: list[Change]) -> list[tuple[str, str, str, str, str]]:
    return [(c.part, c.what, c.path, c.before, c.after) for c in found]


def test_comments_texts_and_the_order_of_lines_are_no_difference(tmp_path: Path) -> None:
    lines = LAG.splitlines()
    blocks = lines[4:9]
    random.Random(3).shuffle(blocks)
    other = [*lines[:1], "# another word", "doc: a text", lines[10], *lines[1:4], *(f"{b}  # why" for b in blocks), lines[9]]
    assert changes(tmp_path, LAG, "\n".join(other).replace("three sensors", "all")) == []


def test_renamed_blocks_are_recognised_even_around_a_loop(tmp_path: Path) -> None:
    other = LAG.replace("sum", "total").replace("before", "last").replace("old", "kept").replace("new", "fresh")
    found = changes(tmp_path, LAG, other)
    names = {("sum", "total"), ("before", "last"), ("old", "kept"), ("new", "fresh")}
    assert {(c.before, c.after) for c in found} == names and {c.what for c in found} == {"renamed"}


@pytest.mark.parametrize(
    ("old", "new", "expected"),
    [
        ("k: 0.25", "k: 0.5", {("parameter", "k"), ("wire", "new: operand 2"), ("wire", "old: operand 2")}),
        ('"vc[2]"', '"vc[1]"', {("wire", "sum: operand 3")}),
        ('"vc[1]", "vc[2]"', '"vc[2]", "vc[1]"', {("wire", "sum: operand 2"), ("wire", "sum: operand 3")}),
        ("initial: 240", "initial: 250", {("setting", "before: initial")}),
        ("initial: 240", "frames: 2, initial: 240", {("setting", "before: frames")}),
        ("operations: 10", "operations: 12", {("budget", "operations")}),
        ("period: 0.1", "period: 0.2", {("budget", "period")}),
        ("[new, old]", "[new, -old]", {("setting", "smooth: signs")}),
        ("shape: [3]", "shape: [4]", {("input", "vc")}),
        ("{mul: [sum, k/3]}", "{add: [sum, sum]}", {("block", "new")}),
        ("  old:", "  spare: {mul: [sum, sum]}\n  old:", {("block", "spare")}),
        ("[smooth]", "{smooth: smooth, raw: sum}", {("output", "raw")}),
        ("[smooth]", "{smooth: new}", {("output", "smooth")}),
    ],
)
def test_a_change_is_told_at_its_place_and_nothing_else(
    tmp_path: Path, old: str, new: str, expected: set[tuple[str, str]]
) -> None:
    found = changes(tmp_path, LAG, LAG.replace(old, new))
    assert {(c.part, c.path) for c in found if c.part != "type"} == expected, brief(found)
    back = changes(tmp_path, LAG.replace(old, new), LAG)
    assert {(c.part, c.path) for c in back if c.part != "type"} == expected, brief(back)


def test_units_and_shapes_show_on_the_blocks_that_they_reach(tmp_path: Path) -> None:
    found = changes(tmp_path, LAG, LAG.replace("unit: kt", "unit: m/s"))
    assert ("input", "changed", "vc", "real [3] kt", "real [3] m/s") in brief(found)
    assert {c.path for c in found if c.part == "type"} == {"sum", "before"}  # k has no unit: what it scales has none that is known


def test_a_change_inside_a_sub_sheet_has_its_path(tmp_path: Path) -> None:
    for name, gain in (("a", 2), ("b", 3)):
        (tmp_path / name).mkdir()
        (tmp_path / name / "part.yaml").write_text(
            f"sheet: part\ninputs: [u]\nblocks: {{y: {{mul: [u, {gain}]}}}}\noutputs: [y]\n"
        )
        (tmp_path / name / "main.yaml").write_text(
            "sheet: main\ninputs: {v: {shape: [4]}}\n"
            "blocks: {many: {map: part, count: 4, each: {u: v}}}\noutputs: [many]\n"
        )
    found = difference(*(load(str(tmp_path / n / "main.yaml")).netlist for n in ("a", "b"))).changes
    assert brief(found) == [("wire", "changed", "many[0].y: operand 2", "2", "3")]
    assert found[0].place is not None and found[0].place.line == 3 and found[0].place.file.endswith("part.yaml")


def test_a_rate_is_a_difference(tmp_path: Path) -> None:
    text = "sheet: s\ninputs: [u]\nblocks: {y: {reciprocal: u, every: 2, transition: hold}}\noutputs: [y]\n"
    assert brief(changes(tmp_path, text, text.replace("every: 2", "every: 3"))) == [
        ("rate", "changed", "y", "every 2, offset 0, held 0", "every 3, offset 0, held 0")
    ]
    (added,) = changes(tmp_path, text.replace(", every: 2, transition: hold", ""), text)
    assert (added.part, added.what) == ("rate", "added")


@pytest.mark.parametrize("name", ["cmhe_fte", "cstr_mhe", "mho_wd_condensed", "double_mhe"])
def test_a_shipped_sheet_is_like_itself(name: str) -> None:
    assert difference(load(name).netlist, load(name).netlist).changes == []


def test_the_unconstrained_estimator_differs_in_step_3() -> None:
    found = difference(load("umhe_fte").netlist, load("cmhe_fte").netlist).changes
    blocks = [(c.path, c.before, c.after) for c in found if c.part == "block"]
    assert blocks == [("step3", "step3_unconstrained", "step3")]
    assert not [c for c in found if c.part == "wire" and not c.path.startswith(("wx_out", "wz_out"))]


def test_edits_deep_in_the_flagship_are_found(tmp_path: Path) -> None:
    text = (SHIPPED / "cmhe_fte" / "output_equation.yaml").read_text()
    for old, new in [("{add: [", "{add: [-"), ("{mul: [", "{mul: [2, ")]:
        starts = [i for i in range(len(text)) if text.startswith(old, i) and not text.startswith(f'{old}"', i)]
        for start in starts[:4]:
            edited = text[:start] + new + text[start + len(old) :]
            if "[--" not in edited:
                assert _differs(tmp_path, text, edited), (old, start)


def _differs(folder: Path, before: str, after: str) -> bool:
    from saoflow import DiagnosisError

    shipped = SHIPPED / "cmhe_fte"
    for path in shipped.glob("*.yaml"):
        if not (folder / path.name).exists():
            (folder / path.name).write_text(path.read_text())
    nets = []
    for text in (before, after):
        (folder / "output_equation.yaml").write_text(text)
        try:
            nets.append(load(str(folder / "cmhe_fte.yaml"), {}).netlist)
        except DiagnosisError:  # units do not fit any more
            return True
    return not difference(*nets).same


def test_work_grows_with_the_sheet_and_not_faster(tmp_path: Path) -> None:
    def seconds(blocks: int) -> float:
        text = ["sheet: chain", "inputs: [u]", "blocks:", "  b0: {add: [u, 1]}"]
        text += [f"  b{i}: {{mul: [b{i - 1}, u]}}" for i in range(1, blocks)]
        before = "\n".join([*text, f"outputs: {{y: b{blocks - 1}}}", ""])
        nets = []
        for name, this in (("a", before), ("b", re.sub(r"\bb(\d)", r"c\1", before))):
            (tmp_path / f"{name}.yaml").write_text(this)
            nets.append(load(str(tmp_path / f"{name}.yaml")).netlist)
        start = time.process_time()
        found = difference(*nets)
        spent = time.process_time() - start
        assert found.same and len([c for c in found.changes if c.part == "block"]) == blocks
        return spent

    small = min(seconds(500) for _ in range(2))
    assert seconds(4000) < 8 * small * 4 + 0.1


# -- the command


def test_exit_codes_are_those_of_diff(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.chdir(tmp_path)
    Path("a.yaml").write_text(LAG)
    Path("b.yaml").write_text(LAG.replace("sum", "total"))
    Path("c.yaml").write_text(LAG.replace("[new, old]", "[new, old, old]"))
    Path("broken.yaml").write_text(LAG.replace("add", "ad"))
    assert cli.run(["diff", "a.yaml", "b.yaml"]) == 0
    assert capsys.readouterr().out == "a.yaml and b.yaml mean the same\n  = block total: `sum` is `total`  (b.yaml:5:3)\n"
    assert cli.run(["diff", "a.yaml", "c.yaml"]) == 1
    out = capsys.readouterr().out
    assert "  + wire smooth: operand 3: old  (c.yaml:8:28)\n" in out and "+1 operations as against a.yaml" in out
    assert cli.run(["diff", "a.yaml", "broken.yaml"]) == 2
    assert "broken.yaml:5:9: error[E201]" in capsys.readouterr().err
    assert cli.run(["diff", "a.yaml", "nowhere.yaml"]) == 2
    capsys.readouterr()
    assert cli.run(["diff", "a.yaml", "c.yaml", "--json", "--set", "k=0.5"]) == 1
    answer = json.loads(capsys.readouterr().out)
    assert answer["same"] is False and answer["cost"]["operations"] == answer["cost"]["operations_before"] + 1
    assert [c["path"] for c in answer["changes"]] == ["smooth: operand 3"]
