"""Reading good sheets: every part arrives, with its place, and YAML's traps are closed."""

from __future__ import annotations

import dataclasses
import gc
import re
import time
from pathlib import Path

import pytest

from saoflow.diagnosis import DiagnosisError, Position
from saoflow.diagrams.expression import Array, Binary, Index, Member, Name, Number, Text, Unary
from saoflow.diagrams.reader import read_sheet, read_text
from saoflow.diagrams.sheet import BlockDeclaration, IterationDeclaration, Named, Sheet

SHEET = (Path(__file__).parent / "grammar.yaml").read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def sheet() -> Sheet:
    return read_text(SHEET, "s.yaml")


def at(place: Position) -> str:
    """The text that a place points to."""
    line = SHEET.splitlines()[place.line - 1]
    assert place.file == "s.yaml"
    return line[place.column - 1 : place.column - 1 + place.length]


def test_head(sheet: Sheet) -> None:
    assert sheet.name.text == "measurement_update"
    assert sheet.name.position == Position("s.yaml", 2, 8, 18)
    assert sheet.doc == "Covariance update of one stage. Paper 004, Algorithm 2, lines 4 and 5."
    assert sheet.equations == "(8), (9)"
    assert sheet.profile is not None
    assert sheet.profile.text == "six"
    assert sheet.lines == tuple(SHEET.split("\n"))


def test_parameters(sheet: Sheet) -> None:
    n, m, k, q, g, w = sheet.parameters
    assert isinstance(n.value, Number)
    assert n.value.value == 4
    assert isinstance(m.value, Binary)
    assert isinstance(k.value, Number)
    assert k.value.value == 0.001
    assert k.unit is not None
    assert (k.unit.items, at(k.unit.position), k.doc, k.source) == ("kt/s", "kt/s", "rate", "Table I")
    assert (q.inherited, q.value, g.inherited, g.value) == (True, None, False, None)
    assert isinstance(w.value, Array)
    assert at(w.value.position) == "[1, n]"


def test_inputs(sheet: Sheet) -> None:
    p, c, r, s, z = sheet.inputs
    assert p.shape is not None
    assert [at(e.position) for e in p.shape] == ["n", "n"]
    assert p.doc == "predicted covariance"
    assert c.unit is not None
    assert isinstance(c.unit.items, tuple)
    assert [(u.items, at(u.position)) for u in c.unit.items] == [("rad", "rad"), ("kt", "kt")]
    assert r.shape is not None
    assert len(r.shape) == 1
    assert (r.boolean, p.boolean) == (True, False)
    assert (s.shape, z.shape) == ((), None)


def test_blocks(sheet: Sheet) -> None:
    blocks = {block.name.text: block for block in sheet.blocks}
    assert list(blocks) == ["Pi", "S", "c0", "c1", "t", "stages", "many", "sw", "none"]
    pi, s, c0, c1, t, sw, none = (blocks[k] for k in ("Pi", "S", "c0", "c1", "t", "sw", "none"))
    assert isinstance(pi, BlockDeclaration)
    assert (pi.symbol.text, pi.doc, [a.name.text for a in pi.arguments]) == ("mul", "line 4", ["product"])
    assert [at(o.wire.position) for o in pi.operands] == ["C", "P_hat"]
    assert isinstance(s, BlockDeclaration)
    assert isinstance(s.operands[1].wire, Unary)
    assert at(s.operands[1].wire.operand.position) == "Pi"
    assert isinstance(c0, BlockDeclaration)
    assert len(c0.operands) == 1
    assert isinstance(c0.operands[0].wire, Array)
    assert at(c0.operands[0].wire.position) == "[[1, 2], [3, -4]]"
    assert isinstance(c1, BlockDeclaration)
    assert len(c1.operands) == 1
    assert isinstance(t, BlockDeclaration)
    assert isinstance(t.operands[0].wire, Name)
    arguments = {a.name.text: a for a in t.arguments}
    assert (arguments["relation"].value, arguments["relation"].text) == (None, "<")
    assert at(arguments["relation"].position) == '"<"'
    assert (arguments["hold"].value, arguments["hold"].text) == (None, "no way")
    assert isinstance(arguments["signs"].value, Array)
    assert [i.text for i in arguments["signs"].value.items if isinstance(i, Text)] == ["+", "-"]
    assert isinstance(sw, BlockDeclaration)
    assert [c.port.text for c in sw.operands if c.port] == ["condition", "then", "else"]
    assert isinstance(sw.operands[1].wire, Member)
    assert isinstance(none, BlockDeclaration)
    assert none.operands == ()


def test_iterations(sheet: Sheet) -> None:
    fold, many = (b for b in sheet.blocks if isinstance(b, IterationDeclaration))
    assert (fold.kind, fold.sheet.text, fold.reverse, fold.doc) == ("fold", "stage", True, "three stages")
    assert at(fold.count.position) == "N - 1"
    assert [(c.port.text, at(c.wire.position)) for c in fold.carry if c.port] == [("P_hat", "P_0")]
    each = [(c.port.text, at(c.wire.position)) for c in fold.each if c.port]
    assert each == [("C", "C"), ("R", "R[:-1]")]
    assert isinstance(fold.each[1].wire, Index)
    assert [at(c.wire.position) for c in fold.common] == ["Q"]
    assert [(a.name.text, a.text) for a in fold.arguments] == [("gamma", "0.5")]
    assert (many.kind, many.reverse, many.carry) == ("map", False, ())


def test_outputs_and_budget(sheet: Sheet) -> None:
    assert [(o.name.text, at(o.name.position)) for o in sheet.outputs] == [("Pi", "Pi"), ("P", "P")]
    assert sheet.budget is not None
    assert [(k.text, at(v.position)) for k, v in sheet.budget.limits] == [
        ("operations", "19500"),
        ("multiply", "800*2"),
    ]
    assert isinstance(sheet.budget.period, Number)


def test_every_name_stands_where_its_place_says(sheet: Sheet) -> None:
    seen = 0

    def walk(thing: object) -> None:
        nonlocal seen
        if isinstance(thing, Named | Name):
            assert at(thing.position) == thing.text
            seen += 1
        if dataclasses.is_dataclass(thing) and not isinstance(thing, type):
            for part in dataclasses.fields(thing):
                walk(getattr(thing, part.name))
        elif isinstance(thing, tuple):
            for item in thing:
                walk(item)

    walk(sheet)
    assert seen > 70


def test_output_entries() -> None:
    text = "sheet: a\noutputs: {x: y, z: {from: 'w[0]', unit: kt, doc: d}, v: , u: {unit: s}}\n"
    x, z, v, u = read_text(text, "a.yaml").outputs
    assert isinstance(x.wire, Name)
    assert x.wire.text == "y"
    assert isinstance(z.wire, Index)
    assert z.wire.position == Position("a.yaml", 2, 28, 4)
    assert (z.unit.items if z.unit else None, z.doc) == ("kt", "d")
    assert [o.wire.text for o in (v, u) if isinstance(o.wire, Name)] == ["v", "u"]


def test_list_forms() -> None:
    sheet = read_text("sheet: a\nparameters: [n, m]\ninputs: [u, v]\nblocks:\noutputs: [u]\n", "a.yaml")
    assert [(p.name.text, p.value, p.inherited) for p in sheet.parameters] == [("n", None, False), ("m", None, False)]
    assert [(i.name.text, i.shape) for i in sheet.inputs] == [("u", None), ("v", None)]
    assert sheet.blocks == ()


@pytest.mark.parametrize("word", ["no", "on", "yes", "off", "true", "True", "y", "n"])
def test_words_that_yaml_takes_for_booleans_are_names(word: str) -> None:
    sheet = read_text(f"sheet: {word}\ninputs: {{{word}: {{}}}}\noutputs: [{word}]\n", "a.yaml")
    assert (sheet.name.text, sheet.inputs[0].name.text, sheet.outputs[0].name.text) == (word, word, word)


@pytest.mark.parametrize(
    ("text", "value"),
    [("1e-3", 1e-3), ("012", 12.0), ("1E6", 1e6), (".5", 0.5), ("-7", -7.0), ("'2'", 2.0), ("0.1", 0.1), ("5.", 5.0)],
)
def test_numbers(text: str, value: float) -> None:
    parameter = read_text(f"sheet: a\nparameters: {{p: {text}}}\noutputs: [u]\n", "a.yaml").parameters[0]
    assert isinstance(parameter.value, Number)
    assert parameter.value.value == value


@pytest.mark.parametrize("text", ["12:30:00", "0x1F", "1_000", "2026-11-22 10:00", ".inf", "0o17"])
def test_what_yaml_takes_for_other_numbers_is_refused(text: str) -> None:
    with pytest.raises(DiagnosisError) as caught:
        read_text(f"sheet: a\nparameters: {{p: '{text}'}}\noutputs: [u]\n", "a.yaml")
    assert [d.code for d in caught.value.diagnoses] == ["E111"]


def test_aliases_repeat_a_value() -> None:
    text = "sheet: a\ninputs: {u: &vector {shape: [3], unit: kt}, v: *vector}\noutputs: [u, v]\n"
    u, v = read_text(text, "a.yaml").inputs
    assert (v.name.text, v.unit, v.shape) == ("v", u.unit, u.shape)


@pytest.mark.parametrize("newline", ["\n", "\r\n", "\r", "\u2028", "\x85"])
def test_every_line_end_of_yaml_counts(newline: str) -> None:
    sheet = read_text(newline.join(["sheet: a", "inputs: [u]", "outputs: [u]", ""]), "a.yaml")
    assert sheet.outputs[0].name.position == Position("a.yaml", 3, 11, 1)
    assert sheet.lines[2] == "outputs: [u]"


@pytest.mark.parametrize(
    ("scalar", "line", "column"),
    [
        ("far + x", 3, 14),
        ("'far + x'", 3, 15),
        ('"far + x"', 3, 15),
        ('"far \\x2b x"', 3, 18),
        ("&anchor far + x", 3, 22),
        ("&far far + x", 3, 19),
        ("far +\n     x", 4, 6),
        ("|\n   far\n   + x", 5, 6),
        (">-\n   far\n   + x", 5, 6),
        ('"far\n    + x"', 4, 7),
    ],
)
def test_places_inside_all_kinds_of_scalars(scalar: str, line: int, column: int) -> None:
    text = f"sheet: a\nparameters:\n  p:   {scalar}\noutputs: [u]\n"
    value = read_text(text, "a.yaml").parameters[0].value
    assert isinstance(value, Binary)
    assert isinstance(value.right, Name)
    position = value.right.position
    assert (position.line, position.column) == (line, column)
    assert text.splitlines()[position.line - 1][position.column - 1] == "x"


def test_unfinished_pieces_do_not_hide_each_other() -> None:
    text = "sheet: 1a\nparameters: {p: 2 +}\ninputs: {u: {unit: zzz}}\nblocks: {x: 3}\noutputs: [y, 'y[']\nbudget: {a: 1}\n"
    with pytest.raises(DiagnosisError) as caught:
        read_text(text, "a.yaml")
    codes = [(d.position.line, d.code) for d in caught.value.diagnoses if d.position]
    assert codes == [(1, "E112"), (2, "E111"), (3, "E113"), (4, "E108"), (5, "E111"), (6, "E106")]


def big_sheet(blocks: int) -> str:
    lines = ["sheet: big", "inputs: {u: {shape: [3]}}", "blocks:", "  b0: {add: [u, u]}"]
    lines += [f"  b{i}: {{mul: [b{i - 1}, -u], product: elementwise}}" for i in range(1, blocks)]
    return "\n".join([*lines, f"outputs: [b{blocks - 1}]", ""])


def test_time_is_proportional_to_size(tmp_path: Path) -> None:
    """32 times the blocks take at most about 32 times the time; generous, since machines are shared."""

    def seconds(blocks: int) -> float:
        path = tmp_path / f"{blocks}.yaml"
        path.write_text(big_sheet(blocks))
        best = float("inf")
        for _ in range(3 if blocks < 5000 else 1):
            start = time.process_time()
            sheet = read_sheet(path)
            best = min(best, time.process_time() - start)
            assert len(sheet.blocks) == blocks
        return best

    small, large = seconds(500), seconds(16_000)
    assert large / small < 32 * 2.5


def test_the_garbage_collector_is_left_as_it_was() -> None:
    assert gc.isenabled()
    read_text(SHEET, "s.yaml")
    assert gc.isenabled()
    gc.disable()
    try:
        read_text(SHEET, "s.yaml")
        assert not gc.isenabled()
    finally:
        gc.enable()


def test_without_the_c_parser(monkeypatch: pytest.MonkeyPatch) -> None:
    import yaml

    from saoflow.diagrams import yaml_text

    fast = read_text(SHEET, "s.yaml")
    monkeypatch.setattr(yaml_text, "_LOADER", yaml.SafeLoader)
    slow = read_text(SHEET, "s.yaml")
    for part in dataclasses.fields(Sheet):
        assert getattr(slow, part.name) == getattr(fast, part.name)


def test_the_sketch_of_the_grammar_names_every_key() -> None:
    from saoflow.diagrams import reader

    assert reader.__doc__ is not None
    assert set(re.findall(r"^    (\w+):", reader.__doc__, re.MULTILINE)) == set(reader._KEYS)
