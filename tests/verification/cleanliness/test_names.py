"""Whatever a sheet calls things: its C compiles with every warning an error, or the sheet is refused with a diagnosis."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
import tempfile
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import saoflow
from saoflow.codegen.generate import About, generate
from saoflow.codegen.macros import HEADERS
from saoflow.codegen.names import LONGEST, Names
from saoflow.codegen.printer import print_file
from verification.cleanliness.checks import WARNINGS

pytestmark = pytest.mark.skipif(shutil.which("gcc") is None, reason="gcc is not installed")

C_WORDS = (
    "int",
    "while",
    "restrict",
    "_Bool",
    "__LINE__",
    "main",
    "v0",
    "r0",
    "q0",
    "state",
    "input",
    "output",
    "empty",
)
MACROS = (
    "NULL",
    "errno",
    "stdin",
    "EOF",
    "I",
    "NAN",
    "EDOM",
    "SIGINT",
    "INT_MAX",
    "DBL_MAX",
    "PRIu8",
    "M_PI",
    "true",
    "and",
)
CPP_WORDS = (
    "class",
    "this",
    "new",
    "namespace",
    "template",
    "operator",
    "static_cast",
    "decltype",
    "char16_t",
    "co_await",
)
FOREIGN = ("größe", "速度", "α", "скорость", "سرعة", "x\u0301")
HOSTILE = (
    'x"; system("',
    "*/ int evil; /*",
    "x\\",
    "??/",
    "a b",
    "a\n#include <x>",
    "",
    "a" * 300,
    "1x",
    "x//",
    "\x00",
    "%s",
)
STANDARD = "assert complex ctype errno fenv float inttypes iso646 limits locale math setjmp signal stdarg stddef stdint"
STANDARD += " stdio stdlib string time wchar wctype"


def sheet_of(name: str, port: str, block: str) -> str:
    """A sheet with a name, a port and a block (a delay, so that the state has a field of it too)."""
    one, two = json.dumps(port), json.dumps(block)
    return (
        f"sheet: {json.dumps(name)}\ninputs: {{{one}: {{}}, other: {{}}}}\n"
        f"blocks: {{{two}: {{delay: {one}}}, sum_of_all: {{add: [{two}, other]}}}}\n"
        f"outputs: [{two}, sum_of_all]\n"
    )


def compiled(text: str, folder: Path, before: str = "") -> bool:
    """Whether the sheet is accepted; then its C must compile. Anything but a diagnosis or clean C fails."""
    (folder / "s.yaml").write_text(text, encoding="utf-8", errors="surrogatepass")
    try:
        program = saoflow.load(str(folder / "s.yaml")).program()
    except saoflow.DiagnosisError as refused:
        assert refused.diagnoses and all(re.fullmatch(r"E\d{3}", d.code) for d in refused.diagnoses)
        return False
    code = generate(program, About(f"all about {text}", "", (text,)))
    for file in (code.header, code.source):
        printed = print_file(file).text
        assert all(" " <= c <= "~" or c == "\n" for c in printed)
        (folder / file.name).write_text(before * (file is code.source) + printed, encoding="ascii")
    words = {
        code.interface.prefix,
        *code.interface.inputs,
        *code.interface.outputs,
        *(f.name for f in code.interface.states),
    }
    assert all(re.fullmatch(rf"[A-Za-z][A-Za-z0-9_]{{0,{LONGEST - 1}}}", word) for word in words)
    command = ["gcc", *WARNINGS, "-c", code.source.name, "-o", "s.o"]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == 0, f"{text}\n{done.stderr[:2000]}"
    return True


@pytest.mark.parametrize("name", [*C_WORDS, *MACROS, *CPP_WORDS, *FOREIGN[:5]], ids=ascii)
def test_words_of_c_and_other_alphabets_compile(name: str, tmp_path: Path) -> None:
    """Also when the headers of the standard library stand before the code, with their macros."""
    before = "".join(f"#include <{header}.h>\n" for header in STANDARD.split())
    if not compiled(sheet_of(name, name, "block_of_it"), tmp_path, before):
        pytest.fail(f"{name} as a sheet and a port is refused")
    assert compiled(sheet_of("s", "port_of_it", name), tmp_path, before)


@pytest.mark.parametrize("name", HOSTILE, ids=ascii)
@pytest.mark.parametrize("what", ["sheet", "port", "block"])
def test_names_that_try_to_escape_are_refused(name: str, what: str, tmp_path: Path) -> None:
    names = {"sheet": "s", "port": "p", "block": "b"} | {what: name}
    assert not compiled(sheet_of(names["sheet"], names["port"], names["block"]), tmp_path)


def test_names_that_differ_only_by_case_or_in_their_end(tmp_path: Path) -> None:
    near = ["speed", "Speed", "SPEED", *(f"{'long_name_' * 5}{i}" for i in range(3)), "speed_2", "größe", "grüße"]
    blocks = ", ".join(f"{name}: {{delay: u}}" for name in near)
    assert compiled(f"sheet: s\ninputs: [u]\nblocks: {{{blocks}}}\noutputs: [{', '.join(near)}]\n", tmp_path)
    header = (tmp_path / "s.h").read_text(encoding="ascii")
    fields = re.findall(r"^    double (\w+)[;\[]", header, re.MULTILINE)
    assert len(fields) == 1 + 2 * len(near)
    assert len({field.lower() for field in fields[1 : 1 + len(near)]}) == len(near)


def test_every_macro_of_the_standard_headers_is_known(tmp_path: Path) -> None:
    """The compiler's own list: a new name in a header is noticed here."""
    (tmp_path / "all.c").write_text("".join(f"#include <{h}.h>\n" for h in STANDARD.split()), encoding="ascii")
    done = subprocess.run(
        ["gcc", "-std=c99", "-dM", "-E", "all.c"], cwd=tmp_path, capture_output=True, text=True, check=True
    )
    macros = re.findall(r"^#define ([A-Za-z]\w*)(?= |$)", done.stdout, re.MULTILINE)
    assert len(macros) > 200
    assert [name for name in macros if Names().make(name, "x") == name] == []


def test_no_file_is_called_like_a_header_of_the_library(tmp_path: Path) -> None:
    assert set(STANDARD.split()) <= HEADERS
    assert compiled(sheet_of("math", "p", "b"), tmp_path)
    assert not (tmp_path / "math.h").exists()


@pytest.mark.skipif(shutil.which("g++") is None, reason="g++ is not installed")
def test_headers_can_be_included_in_cpp(tmp_path: Path) -> None:
    ports = "\n".join(f"  {name}: {{}}" for name in CPP_WORDS)
    blocks = "\n".join(f"  {name}_y: {{delay: {name}}}" for name in CPP_WORDS)
    outputs = ", ".join(f"{name}_y" for name in CPP_WORDS)
    assert compiled(f"sheet: s\ninputs:\n{ports}\nblocks:\n{blocks}\noutputs: [{outputs}]\n", tmp_path)
    (tmp_path / "user.cpp").write_text('#include <stdbool.h>\nextern "C" {\n#include "s.h"\n}\n', encoding="ascii")
    command = ["g++", "-Wall", "-Wextra", "-pedantic", "-Werror", "-fsyntax-only", "user.cpp"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


NAMES = st.one_of(
    st.sampled_from([*C_WORDS, *MACROS, *CPP_WORDS, *FOREIGN, *HOSTILE]),
    st.text(min_size=0, max_size=12),
    st.from_regex(r"[A-Za-z_][A-Za-z0-9_]{0,40}", fullmatch=True),
)


@settings(max_examples=30, deadline=None, database=None, derandomize=True, suppress_health_check=list(HealthCheck))
@given(NAMES, NAMES, NAMES)
def test_any_names_compile_or_are_refused(sheet: str, port: str, block: str) -> None:
    with tempfile.TemporaryDirectory() as folder:
        compiled(sheet_of(sheet, port, block), Path(folder))
