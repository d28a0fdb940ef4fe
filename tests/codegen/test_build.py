"""``saoflow build``: clean under compilers, checked by itself, traceable, whole or not at all, whatever things are called."""

from __future__ import annotations

import json
import shutil
import subprocess
from pathlib import Path

import pytest

import saoflow
from saoflow import cli
from saoflow.codegen import build as building
from saoflow.codegen.build import build
from saoflow.codegen.readme import WARNINGS
from saoflow.diagnosis import DiagnosisError
from saoflow.diagrams.store import LIBRARY
from tests.codegen.test_native import SMALL
from tests.sheet_text import sheet_of

COMPILERS = [name for name in ("gcc", "clang") if shutil.which(name)]
pytestmark = pytest.mark.skipif(not COMPILERS, reason="there is neither gcc nor clang on this machine")
FILES = ["README.md", "cmhe_fte.c", "cmhe_fte.h", "selfcheck.c", "trace.json"]


def assert_clean(*sources: Path) -> None:
    """No compiler has a word to say."""
    for compiler in COMPILERS:
        command = [compiler, *WARNINGS.split(), "-ffp-contract=off", "-fsyntax-only", *map(str, sources)]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        assert done.returncode == 0 and not done.stderr, (compiler, done.stderr[:2000])


def self_check(folder: Path, compiler: str, *flags: str) -> subprocess.CompletedProcess[str]:
    """Compile and run what was built."""
    sources = [str(path) for path in sorted(folder.glob("*.c"))]
    program = folder / f"selfcheck_{compiler}"
    command = [compiler, *flags, *WARNINGS.split(), "-ffp-contract=off", *sources, "-o", str(program)]
    subprocess.run(command, check=True)
    return subprocess.run([str(program)], capture_output=True, text=True, check=False)


@pytest.mark.parametrize("real", [64, 32])
@pytest.mark.parametrize("name", ["cmhe_fte", "umhe_fte"])
def test_estimators_are_clean(name: str, real: int, tmp_path: Path) -> None:
    # The self-check's outputs need the interpreter, which is slow in binary32: a few frames are enough here.
    sheet = saoflow.load(name)
    inputs = {port: values[:3] for port, values in building.exercise(sheet.program(real)).items()}
    built = build(sheet, tmp_path / "out", real, inputs)
    assert built.frames_checked == 3 and built.real == real
    assert built.cost.kinds == {kind: n for kind, n in sheet.budget().tree.kinds.items() if n}
    assert_clean(*(tmp_path / "out").glob("*.c"))


@pytest.mark.parametrize("compiler", COMPILERS)
def test_the_flagship_checks_itself_and_a_changed_bit_is_found(compiler: str, tmp_path: Path) -> None:
    folder = tmp_path / "out"
    build(saoflow.load("cmhe_fte"), folder)
    assert sorted(path.name for path in folder.iterdir()) == FILES
    done = self_check(folder, compiler)
    assert (done.returncode, done.stdout) == (0, "300 frames of cmhe_fte: 0 of 5700 outputs differ\n")
    check = folder / "selfcheck.c"
    head, expected = check.read_text().split("expected[5700] = {\n    ", 1)
    first, rest = expected.split(",", 1)
    check.write_text(f"{head}expected[5700] = {{\n    ({first}) * (1.0 + 0x1p-52),{rest}")
    done = self_check(folder, compiler)
    assert done.returncode == 1 and "frame 0, element 0" in done.stdout and "1 of 5700" in done.stdout


@pytest.mark.parametrize("real", [64, 32])
def test_every_library_sheet_that_stands_alone_is_clean(real: int, tmp_path: Path) -> None:
    built = []
    for path in sorted(LIBRARY.glob("*.yaml")):
        sheet = saoflow.load(path.stem)
        try:
            sheet.check()
        except DiagnosisError:
            continue  # it takes shapes or parameters from the sheet that uses it
        inputs = {port: values[:3] for port, values in building.exercise(sheet.program(real)).items()}
        build(sheet, tmp_path / path.stem, real, inputs)
        built.append(path.stem)
    assert len(built) >= 10
    assert_clean(*tmp_path.glob("*/*.c"))


@pytest.mark.parametrize("real", [64, 32])
@pytest.mark.parametrize("compiler", COMPILERS)
@pytest.mark.parametrize("level", ["-O0", "-O3"])
def test_state_tables_and_booleans_check_themselves(compiler: str, level: str, real: int, tmp_path: Path) -> None:
    build(sheet_of(tmp_path, SMALL), tmp_path / "out", real)
    done = self_check(tmp_path / "out", compiler, level)
    assert done.returncode == 0 and "300 frames of small: 0 of 1800 outputs differ" in done.stdout


LONG = "a" * 60
NAMES = ["int", "main", "printf", "state", "input", "v1", "reals", "NULL", "_Bool", "r0", "k", "given", LONG]


def test_names_neither_collide_nor_escape(tmp_path: Path) -> None:
    blocks = "\n".join(f"  {name}_: {{mul: [{name}, 3]}}" for name in NAMES)
    memory = "\n".join(f"  {name}_m: {{delay: {name}_, initial: 1}}" for name in NAMES)
    text = f"sheet: double\ninputs: {{{', '.join(f'{n}: {{}}' for n in NAMES)}}}\nblocks:\n{blocks}\n{memory}\n"
    text += "outputs: {" + ", ".join(f"{n}: {n}_m" for n in ["while", "DOUBLE", "Double", "struct", LONG + "b"]) + "}\n"
    text = text.replace("while_m", "int_m").replace("DOUBLE_m", "main_m").replace("Double_m", "v1_m")
    text = text.replace("struct_m", "NULL_m").replace(f"{LONG}b_m", f"{LONG}_m")
    build(sheet_of(tmp_path, text, "double"), tmp_path / "out")
    assert_clean(*(tmp_path / "out").glob("*.c"))
    done = self_check(tmp_path / "out", COMPILERS[0])
    assert done.returncode == 0, done.stdout
    source = next(path for path in (tmp_path / "out").glob("*.c") if path.name != "selfcheck.c").read_text()
    assert max(len(word) for line in source.splitlines() for word in line.split("/*")[0].split()) < 80


@pytest.mark.parametrize("name", ['x"; system("', "höhe", "高度", "a" * 300, "a*/b", "a\\\nb", "??/"])
def test_odd_names_compile_or_are_refused(name: str, tmp_path: Path) -> None:
    quoted = json.dumps(name)
    text = f"sheet: odd\ndoc: {quoted}\ninputs: {{{quoted}: {{doc: {quoted}}}}}\nblocks:\n  y: {{mul: [{quoted}, 2]}}\n"
    path = tmp_path / "odd.yaml"
    path.write_text(text + "outputs: [y]\n", encoding="utf-8")
    try:
        build(saoflow.load(str(path)), tmp_path / "out")
    except DiagnosisError as refused:
        assert all(d.code and d.remedy for d in refused.diagnoses)
        assert not (tmp_path / "out").exists()
        return
    assert_clean(*(tmp_path / "out").glob("*.c"))


@pytest.mark.parametrize("doc", ["*/ int x; /*", "a\\", "??/", "// \n #error", "é\u2028"])
def test_texts_of_a_sheet_stay_in_comments(doc: str, tmp_path: Path) -> None:
    quoted = json.dumps(doc)
    text = f"sheet: s\ndoc: {quoted}\ninputs: {{u: {{doc: {quoted}}}}}\nblocks:\n  y: {{mul: [u, 2]}}\noutputs: [y]\n"
    (tmp_path / "s.yaml").write_text(text, encoding="utf-8")
    build(saoflow.load(str(tmp_path / "s.yaml")), tmp_path / "out")
    assert_clean(*(tmp_path / "out").glob("*.c"))


def test_trace_leads_from_c_to_the_sheet_and_back(tmp_path: Path) -> None:
    sheet = sheet_of(tmp_path, SMALL)
    build(sheet, tmp_path / "out")
    trace = json.loads((tmp_path / "out/trace.json").read_text())
    source = (tmp_path / "out" / trace["source"]).read_text().splitlines()
    yaml = (tmp_path / "sheet.yaml").read_text().splitlines()
    total = [entry for entry in trace["c_to_sheet"] if entry["wire"] == "total"]
    assert len(total) == 1
    (entry,) = total
    assert "total:  {add: [scaled, before]}" in yaml[entry["sheet_line"] - 1]
    assert " + " in source[entry["line"] - 1] and f"sheet.yaml:{entry['sheet_line']}" in source[entry["line"] - 1]
    assert entry["line"] in trace["sheet_to_c"][entry["file"]][str(entry["sheet_line"])]
    back = sorted(n for lines in trace["sheet_to_c"].values() for found in lines.values() for n in found)
    assert back == sorted(entry["line"] for entry in trace["c_to_sheet"])
    statements = [i for i, line in enumerate(source, 1) if line.startswith("    const double v")]
    assert set(statements) <= set(back)


def test_header_and_readme_tell_units_sizes_hash_operations_and_stack(tmp_path: Path) -> None:
    sheet = saoflow.load("cmhe_fte")
    built = build(sheet, tmp_path / "out", inputs={k: v[:2] for k, v in building.exercise(sheet.program()).items()})
    header, text = ((tmp_path / "out" / name).read_text() for name in ("cmhe_fte.h", "README.md"))
    assert built.sheet_hash in header and f"Operations a frame: {sheet.budget().total}" in header
    assert "double vc[3];  /* vc: [3], kt;" in header and "Frame period: 0.048 s." in header
    assert "operations 19500" in header and "-ffp-contract=off" in text
    assert max(map(len, header.splitlines())) < 140
    if shutil.which("gcc"):
        measured = built.stack["-O0"]
        assert measured is not None and 10_000 < measured < built.stack_bound < building.MOST_STACK
        assert f"{measured} bytes at -O0" in text


def test_the_hash_changes_with_any_sheet_that_was_read(tmp_path: Path) -> None:
    below = "sheet: below\ninputs: [u]\nblocks:\n  y: {mul: [u, 2]}\noutputs: [y]\n"
    above = "sheet: above\ninputs: {u: {}}\nblocks:\n  y: {below: [u]}\noutputs: {y: y.y}\n"
    found = set()
    for doc in ("", "doc: other\n", ""):
        (tmp_path / "below.yaml").write_text(below + doc, encoding="utf-8")
        found.add(build(sheet_of(tmp_path, above), tmp_path / "out").sheet_hash)
    assert len(found) == 2


def test_a_folder_of_others_is_not_touched(tmp_path: Path) -> None:
    sheet = sheet_of(tmp_path, SMALL)
    folder = tmp_path / "out"
    folder.mkdir()
    (folder / "thesis.tex").write_text("years of work")
    with pytest.raises(DiagnosisError, match=r"E601.*\n.*it holds other files: thesis.tex"):
        build(sheet, folder)
    assert [path.name for path in folder.iterdir()] == ["thesis.tex"]
    (tmp_path / "file").write_text("")
    with pytest.raises(DiagnosisError, match="it is a file"):
        build(sheet, tmp_path / "file")
    with pytest.raises(DiagnosisError, match="E601"):
        build(sheet, tmp_path / "file" / "below")


def test_building_again_keeps_what_stands_beside(tmp_path: Path) -> None:
    folder = tmp_path / "out"
    folder.mkdir()
    build(sheet_of(tmp_path, SMALL), folder, 64)
    (folder / "notes.txt").write_text("mine")
    build(sheet_of(tmp_path, SMALL), folder, 32)
    assert "float u;" in (folder / "small.h").read_text() and (folder / "notes.txt").read_text() == "mine"
    assert sorted(p.name for p in tmp_path.iterdir()) == ["out", "sheet.yaml"]


def test_the_folder_one_stands_in_is_filled_and_stays(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    sheet, folder = sheet_of(tmp_path, SMALL), tmp_path / "out"
    folder.mkdir()
    before = folder.stat().st_ino
    monkeypatch.chdir(folder)
    build(sheet, ".")
    assert Path("small.c").exists() and folder.stat().st_ino == before
    monkeypatch.setattr(building, "MOST_STACK", 100)
    with pytest.raises(DiagnosisError, match="E610"):
        build(sheet, ".")
    assert len(list(folder.iterdir())) == 5  # what an earlier build wrote is there, and no more


def test_stale_files_of_another_sheet_go(tmp_path: Path) -> None:
    build(sheet_of(tmp_path, SMALL), tmp_path / "out")
    build(sheet_of(tmp_path, SMALL.replace("sheet: small", "sheet: other")), tmp_path / "out")
    assert sorted(path.name for path in (tmp_path / "out").glob("*.[ch]")) == ["other.c", "other.h", "selfcheck.c"]


RATES = """\
sheet: rates
inputs: [x]
blocks:
  even: {lag: x, every: 2, transition: hold}
  third: {lag: x, every: 3, offset: 1, transition: delay}
outputs: [even, third]
"""
LAG = "sheet: lag\ninputs: [x]\nblocks: {y: {add: [x, old]}, old: {delay: y}}\noutputs: [y]\n"


def test_operations_of_several_rates_are_those_of_the_budget(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("rates.yaml").write_text(RATES)
    Path("lag.yaml").write_text(LAG)
    assert cli.run(["build", "rates.yaml", "-o", "out"]) == 0
    # Frames of 6: 0, 2 and 4 run `even`, 1 and 4 run `third`; one addition each.
    told = "2 operations in the dearest of 6 frames, 0.8 in the mean"
    assert told in capsys.readouterr().out and told in Path("out/README.md").read_text()
    assert "Operations a frame: 2 (add 2) in the dearest of 6 frames, 0.8 in the mean." in Path("out/rates.h").read_text()
    assert "Every frame executes the same" not in Path("out/README.md").read_text()
    assert saoflow.load("rates.yaml").budget().total == 2


def test_nothing_is_left_of_a_build_that_fails(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(building, "MOST_STACK", 100)
    with pytest.raises(DiagnosisError, match=r"E610.*100 allowed"):
        build(sheet_of(tmp_path, SMALL), tmp_path / "out")
    assert [p.name for p in tmp_path.iterdir()] == ["sheet.yaml"]


def test_the_command(tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    sheet_of(tmp_path, SMALL)
    monkeypatch.chdir(tmp_path)
    assert cli.run(["build", "sheet.yaml", "-o", "out", "--real", "32", "--json"]) == 0
    facts = json.loads(capsys.readouterr().out)
    assert facts["files"][0] == "small.c" and facts["real"] == 32 and facts["diagnoses"] == []
    assert cli.run(["build", "sheet.yaml", "-o", "sheet.yaml", "--real", "16"]) == 2
    told = capsys.readouterr().err
    assert "error[E601]" in told and "error[E603]" in told
    Path("in.csv").write_text("u,v_1,v_2,on\n1,2,3,1\n4,5,6,0\n")
    assert cli.run(["build", "sheet.yaml", "-o", "out", "--frames-from", "in.csv"]) == 0
    assert "2 frames of small: " in Path("out/selfcheck.c").read_text()
