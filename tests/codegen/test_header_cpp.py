"""The generated header in C++: clean under compilers, and the C code behind it gives the interpreter's bits."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

import saoflow
from saoflow.codegen.build import build
from tests.codegen.test_native import SMALL
from tests.sheet_text import sheet_of

PAIRS = [(c, cpp) for c, cpp in (("gcc", "g++"), ("clang", "clang++")) if shutil.which(c) and shutil.which(cpp)]
pytestmark = pytest.mark.skipif(not PAIRS, reason="there is no C++ compiler on this machine")
STRICT = ["-pedantic", "-Wall", "-Wextra", "-Wconversion", "-Wold-style-cast", "-Werror"]

MAIN = """\
#include "small.h"
#include <cstdio>
int main() {
    small_state state;
    small_input input = {};
    small_output output;
    small_init(&state);
    for (int k = 0; k < 4; ++k) {
        input.u = static_cast<REAL>(k) - static_cast<REAL>(1.7);
        input.v[0] = static_cast<REAL>(0.5);
        input.v[1] = input.u;
        input.on = k != 2;
        small_step(&state, &input, &output);
        double total = static_cast<double>(output.total), look = static_cast<double>(output.look[1]);
        std::printf("%a %a %d\\n", total, look, int(output.both));
    }
}
"""


@pytest.mark.parametrize(("c", "cpp"), PAIRS)
@pytest.mark.parametrize("standard", ["c++11", "c++20"])
@pytest.mark.parametrize("real", [64, 32])
def test_a_cpp_program_runs_frames(c: str, cpp: str, standard: str, real: int, tmp_path: Path) -> None:
    sheet = sheet_of(tmp_path, SMALL)
    folder = tmp_path / "out"
    build(sheet, folder, real)
    kind = "double" if real == 64 else "float"
    (tmp_path / "main.cpp").write_text(MAIN.replace("REAL", kind))
    compiled = [c, "-std=c99", "-ffp-contract=off", "-c", str(folder / "small.c"), "-o", "small.o"]
    subprocess.run(compiled, cwd=tmp_path, check=True)
    command = [cpp, f"-std={standard}", *STRICT, f"-I{folder}", "main.cpp", "small.o", "-o", "main"]
    subprocess.run(command, cwd=tmp_path, check=True)
    said = subprocess.run([str(tmp_path / "main")], capture_output=True, text=True, check=True).stdout
    real_type = np.float64 if real == 64 else np.float32
    u = np.arange(4).astype(real_type) - real_type(1.7)
    inputs = {"u": u, "v": np.stack([np.full(4, 0.5), u], axis=1), "on": np.array([1, 1, 0, 1])}
    out = sheet.simulator(real=real).run(inputs)
    want = [(float(out["total"][k]), float(out["look"][k, 1]), int(out["both"][k])) for k in range(4)]
    rows = [line.split() for line in said.splitlines()]
    assert [(float.fromhex(a), float.fromhex(b), int(flag)) for a, b, flag in rows] == want
    assert {row[2] for row in rows} == {"0", "1"}


@pytest.mark.parametrize("cpp", [cpp for _, cpp in PAIRS])
def test_the_flagships_header_is_clean(cpp: str, tmp_path: Path) -> None:
    build(saoflow.load("umhe_fte"), tmp_path / "out", inputs=None)
    (tmp_path / "main.cpp").write_text('#include "umhe_fte.h"\nint main() { return 0; }\n')
    command = [cpp, "-std=c++11", *STRICT, f"-I{tmp_path / 'out'}", "-fsyntax-only", "main.cpp"]
    subprocess.run(command, cwd=tmp_path, check=True)
