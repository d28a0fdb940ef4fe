"""The shortened check of the generated C, and that each check can fail. The whole: ``python -m verification.cleanliness``."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

import saoflow
from verification.cleanliness.__main__ import main
from verification.cleanliness.callgraph import deepest, read_call_graph, recursive
from verification.cleanliness.checks import CHECKS, Check
from verification.cleanliness.misra import ACCEPTED, Misra, read_accepted
from verification.cleanliness.subjects import ESTIMATORS, Subject, estimators, library, random_sheets, sizes, subject
from verification.cleanliness.tools import where

MISRA = Check("MISRA, cppcheck", ("cppcheck",), lambda s: Misra(read_accepted()).look(s))
BY_NAME = {check.name: check for check in [*CHECKS, MISRA]}
TEXT = """
sheet: s
inputs: {u: {shape: [3]}, c: {type: boolean}}
blocks:
  before: {delay: u}
  sum: {add: [u, before]}
  y: {lookup: sum, breakpoints: [0, 1], values: [0, 2], interpolation: linear}
  z: {switch: [c, y, 0]}
outputs: [z]
"""


@pytest.fixture(scope="module")
def subjects(tmp_path_factory: pytest.TempPathFactory) -> list[Subject]:
    """An estimator, some library sheets and random ones."""
    folder = tmp_path_factory.mktemp("clean")
    found = list(estimators(folder, ("umhe_fte",), (32,), 120))
    found += library(folder / "library", (64,), 40, every=12)[0]
    return found + random_sheets(folder / "random", 2, 3, 40)


@pytest.mark.parametrize("check", BY_NAME.values(), ids=BY_NAME)
def test_generated_c_is_clean(check: Check, subjects: list[Subject]) -> None:
    _needs(check)
    assert len(subjects) >= 6
    for s in subjects:
        assert (str(s), check.look(s).findings) == (str(s), [])


def _needs(check: Check) -> None:
    if missing := [tool for tool in check.tools if where(tool) is None]:
        pytest.skip(f"not installed: {', '.join(missing)}")


@pytest.fixture
def small(tmp_path: Path) -> Subject:
    """A small clean sheet, to be spoilt."""
    (tmp_path / "s.yaml").write_text(TEXT, encoding="utf-8")
    return subject("small", saoflow.load(str(tmp_path / "s.yaml")), 64, tmp_path / "c", None, 20)


STEP = "void s_step("
BODY = "    output->z"
PLANTED = {
    "a conversion": ("warnings, gcc -O2", BODY, "    { const float lost = (float)1 * input->u[0]; (void)lost; }\n" + BODY),
    "comparing reals": ("warnings, clang -O2", BODY, "    if (input->u[0] == input->u[1]) { output->z[0] = 0.0; }\n" + BODY),
    "past the end": ("sanitizers, gcc", BODY, "    { volatile int k = 3; state->before[0] = input->u[k]; }\n" + BODY),
    "too large for int": ("sanitizers, clang", BODY, "    { volatile int k = 2147483647; ++k; k = k + 1; k = -2147483647 - k; }\n" + BODY),
    "never set": ("valgrind", BODY, "    { double x[2]; if (x[input->c] > 0.0) { state->before[0] = 1.0; } }\n" + BODY),
    "a heap": ("freestanding, gcc", STEP, "void *malloc(unsigned long n);\nstatic void *more(void) { return malloc(9u); }\n" + STEP),
    "global state": ("freestanding, clang", BODY, "    { static volatile double kept = 1.0; kept = kept * 2.0; }\n" + BODY),
    "one more name": ("freestanding, gcc", STEP, "int seen(void) { return 1; }\n" + STEP),
    "mathematics": ("freestanding, gcc", BODY, "    { volatile double y = __builtin_sin(input->u[0]); (void)y; }\n" + BODY),
    "recursion": ("stack, gcc -O0", STEP, "static int down(int n) { return n < 1 ? 0 : down(n - 1) + down(n - 2); }\n" + STEP),
    "much stack": ("stack, gcc -O0", BODY, "    { volatile char big[70000]; big[0] = 1; }\n" + BODY),
    "stack by data": ("stack, gcc -O2", BODY, "    { volatile char big[1 + (int)input->u[0]]; big[0] = 1; }\n" + BODY),
    "goto": ("MISRA, cppcheck", BODY, "    goto end;\nend:\n" + BODY),
}  # fmt: skip


@pytest.mark.parametrize("what", PLANTED)
def test_planted_defects_are_found(what: str, small: Subject) -> None:
    name, place, spoilt = PLANTED[what]
    check = BY_NAME[name]
    _needs(check)
    text = small.source.read_text(encoding="ascii")
    place = place if place in text else place.replace("output->z", "output->z[0]")
    assert place in text
    if what in ("a conversion", "past the end", "goto"):
        assert check.look(small).findings == []
    small.source.write_text(text.replace(place, spoilt, 1), encoding="ascii")
    assert check.look(small).findings


def test_a_program_that_ends_early_is_a_finding(small: Subject) -> None:
    check = BY_NAME["sanitizers, gcc"]
    _needs(check)
    assert check.look(replace(small, frames=21)).findings


def test_call_graph() -> None:
    text = """graph: { title: "s.c"
node: { title: "s.c:inner" label: "inner\\ns.c:1:1\\n48 bytes (static)\\n0 dynamic objects" }
node: { title: "other" label: "other\\ns.c:1:1\\n16 bytes (dynamic,bounded)\\n0 dynamic objects" }
node: { title: "step" label: "step\\ns.c:9:6\\n100 bytes (static)\\n0 dynamic objects" }
node: { title: "memcpy" label: "memcpy\\n<built-in>" shape : ellipse }
edge: { sourcename: "step" targetname: "s.c:inner" label: "s.c:9:1" }
edge: { sourcename: "step" targetname: "other" }
edge: { sourcename: "other" targetname: "memcpy" }
}"""
    graph = read_call_graph(text)
    assert deepest(graph, "step") == 148 and graph["memcpy"].bytes is None
    assert recursive(graph) == []
    graph["other"].calls.append("step")
    assert recursive(graph) in (["step", "other", "step"], ["other", "step", "other"])


def test_accepted_findings(tmp_path: Path) -> None:
    """New findings fail, accepted ones pass, entries that are not needed are named; bad lines of the list too."""
    (tmp_path / "s.c").write_text("int a;\nint b;\n", encoding="ascii")
    (tmp_path / "list.txt").write_text("# head\nr-1 | ^int a | why\nr-2 | x | why not\n", encoding="utf-8")
    misra = Misra(read_accepted(tmp_path / "list.txt"))
    found = misra.judge("s.c:1:style:r-1:text\ns.c:2:style:r-1:text\n", tmp_path)
    assert found.findings == ["s.c:2: r-1: text: int b;"] and found.measure == 1
    assert [entry.rule for entry in misra.unneeded()] == ["r-2"]
    drawn = misra.judge("s.c:2:style:odd:text\ns.c:2:error:odd:text\ns.c:2:style:misra-1:text", tmp_path, drawn=True)
    assert len(drawn.findings) == 2
    for bad in ("r-1 | a", "r-1 | ( | why", "r-1 || why"):
        (tmp_path / "list.txt").write_text(f"\n{bad}\n", encoding="utf-8")
        with pytest.raises(ValueError, match=r"list.txt:2: "):
            read_accepted(tmp_path / "list.txt")
    assert all(len(entry.reason) > 20 for entry in read_accepted(ACCEPTED))


def test_missing_tools_are_named(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    """Without any tool the rest still runs, and says what it left out."""
    monkeypatch.setattr("verification.cleanliness.__main__.where", lambda tool: None)
    monkeypatch.setattr("verification.cleanliness.__main__.estimators", lambda *_: iter(()))
    assert main(["--quick", "--random", "1"]) == 0
    said = capsys.readouterr().out
    assert "not installed: valgrind" in said.replace("gcc, ", "") and "not installed: cppcheck; left out: MISRA" in said
    assert "limits of C99: clean" in said


@pytest.mark.parametrize("name", ESTIMATORS)
def test_the_page_has_the_sizes_of_this_code(name: str) -> None:
    """Its bytes are gcc's; what C99 limits is the code's alone (``python -m verification.cleanliness.stack_table``)."""
    page = (Path(saoflow.__file__).parents[1] / "docs" / "c_code.md").read_text(encoding="utf-8")
    (row,) = (line for line in page.split("\n") if line.startswith(f"| {name} |"))
    shown = tuple(int(cell.replace(" ", "")) for cell in row.strip("| ").split("|")[-2:])
    assert shown == sizes(saoflow.load(name).frame_program)
