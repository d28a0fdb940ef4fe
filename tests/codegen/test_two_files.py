"""A frame with many procedures is compiled as two files at the same time, and is one object to everybody else."""

from __future__ import annotations

import ctypes
import os
import subprocess
import time
from pathlib import Path

import pytest

import saoflow
from saoflow.cache import Folder
from saoflow.codegen.compiler import Compiler, compiled, find_compiler
from saoflow.codegen.generate import HIDDEN, native_files
from saoflow.codegen.printer import print_file
from saoflow.diagnosis import DiagnosisError

pytestmark = pytest.mark.skipif(find_compiler() is None or os.name != "posix", reason="there is no C compiler here")

TWICE = f"{HIDDEN} double twice(double u) {{ return u + u; }}\n"
RUN = f"{HIDDEN} double twice(double);\ndouble run(double u) {{ return twice(u) + 1.0; }}\n"


def scripted(folder: Path, lines: str) -> Compiler:
    """A compiler that does what a script says."""
    script = folder / "cc"
    script.write_text(f"#!/bin/sh\n{lines}\n")
    script.chmod(0o755)
    return Compiler((str(script),), "scripted")


def test_two_files_make_one_object_that_shows_its_runner_only(tmp_path: Path) -> None:
    compiler = find_compiler()
    assert compiler is not None
    library = ctypes.CDLL(str(compiled([TWICE, RUN], compiler, Folder(tmp_path, ""))))
    library.run.restype, library.run.argtypes = ctypes.c_double, [ctypes.c_double]
    assert library.run(3.0) == 7.0
    assert not hasattr(library, "twice")
    assert [path.suffix for path in tmp_path.iterdir()] == [".so"]


@pytest.mark.parametrize("wrong", [0, 1])
def test_either_file_may_fail(tmp_path: Path, wrong: int) -> None:
    compiler = find_compiler()
    assert compiler is not None
    texts = [TWICE, RUN]
    texts[wrong] += "no C at all\n"
    with pytest.raises(DiagnosisError) as raised:
        compiled(texts, compiler, Folder(tmp_path, ""))
    (diagnosis,) = raised.value.diagnoses
    assert diagnosis.code == "E607"
    assert f"frame{wrong}.c" in diagnosis.cause
    assert list(tmp_path.iterdir()) == []


def test_an_interrupt_ends_every_compile(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    began = tmp_path / "began"
    began.mkdir()
    (tmp_path / "cache").mkdir()
    compiler = scripted(tmp_path, f"touch {began}/$$\nexec sleep 300")

    def interrupted(_: object) -> None:
        while len(list(began.iterdir())) < 2:
            time.sleep(0.01)
        raise KeyboardInterrupt

    monkeypatch.setattr(subprocess.Popen, "communicate", interrupted)
    with pytest.raises(KeyboardInterrupt):
        compiled([TWICE, RUN], compiler, Folder(tmp_path / "cache", ""))
    for process in began.iterdir():
        with pytest.raises(ProcessLookupError):
            os.kill(int(process.name), 0)


def test_many_procedures_are_a_file_of_their_own() -> None:
    """Each function and each table where it is read; a small sheet stays one file."""
    flagship = saoflow.load("cmhe_fte").frame_program
    procedures, frame = (print_file(file, traced=False).text for file in native_files(flagship))
    assert procedures.count(f"{HIDDEN} ") == len(flagship.procedures)
    assert "saoflow_run" not in procedures and "saoflow_run" in frame
    assert len(native_files(flagship, placed=True)) == 1
    assert len(native_files(saoflow.load("umhe_fte").frame_program)) == 1


