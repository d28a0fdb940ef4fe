"""The C of a unit: clean, true to the standard's own headers, without state of its own, built by others."""

from __future__ import annotations

import ctypes
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from saoflow.fmi import Unit, build_unit
from saoflow.pipeline import LoadedSheet, load
from tests.fmi.importer import Importer, fmpy, random_inputs
from tests.sheet_text import same_bits

HEADERS = Path(fmpy.__file__).parent / "c-code"
STRICT = [
    "-std=c99",
    "-pedantic",
    "-Wall",
    "-Wextra",
    "-Wconversion",
    "-Wdouble-promotion",
    "-Wfloat-equal",
    "-Wshadow",
    "-Werror",
]
DELAYS = Path(__file__).parents[1] / "sheets/good/delays.yaml"
COMPILERS = [name for name in ("gcc", "clang") if shutil.which(name)]


def unpack(unit: Unit, folder: Path) -> Path:
    """The sources in a folder."""
    for name, content in unit.files:
        if name.startswith("sources/"):
            (folder / name.removeprefix("sources/")).write_bytes(content)
    return folder


@pytest.fixture(scope="module", params=[(3, 64), (3, 32), (2, 64), (2, 32)], ids=lambda p: f"FMI {p[0]}, binary{p[1]}")
def sources(request: pytest.FixtureRequest, mixed: LoadedSheet, tmp_path_factory: pytest.TempPathFactory) -> Path:
    version, real = request.param
    return unpack(build_unit(mixed, version, real=real, binary=False), tmp_path_factory.mktemp("sources"))


@pytest.mark.parametrize("compiler", COMPILERS)
def test_no_warning(compiler: str, sources: Path) -> None:
    files = sorted(path.name for path in sources.glob("*.c"))
    done = subprocess.run(
        [compiler, *STRICT, "-O1", "-fsyntax-only", *files], cwd=sources, capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr


@pytest.mark.skipif(not COMPILERS, reason="no C compiler")
@pytest.mark.parametrize("version", [3, 2])
def test_the_interface_is_the_standards(version: int, mixed: LoadedSheet, tmp_path: Path) -> None:
    """Our declarations give way to the standard's headers: every definition must agree with its prototype."""
    folder = unpack(build_unit(mixed, version, binary=False), tmp_path)
    shim = f'#include "fmi{version}Functions.h"\n#define FMI{version}(type, name, parameters) type name parameters\n'
    (folder / f"fmi{version}-api.h").write_text(shim, encoding="ascii")
    command = [COMPILERS[0], "-std=c99", "-Wall", "-Werror", f"-I{HEADERS}", "-fsyntax-only", f"fmi{version}-unit.c"]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    text = (HEADERS / f"fmi{version}Functions.h").read_text(encoding="utf-8")
    names = set(re.findall(rf"TYPE\s+(fmi{version}\w+);", text))
    if version == 2:  # a unit for co-simulation leaves out model exchange
        names &= {name for name in dir(fmpy.fmi2.FMU2Slave) if name.startswith("fmi2")}
    assert len(names) > 30
    code = "".join(path.read_text(encoding="ascii") for path in folder.glob(f"fmi{version}-*"))
    assert not {name for name in names if not re.search(rf"\b{name}\b", code)}


@pytest.mark.skipif(sys.platform != "linux", reason="looks into an ELF file")
def test_only_the_interface_is_seen(unit: Unit, tmp_path: Path) -> None:
    binary = next(content for name, content in unit.files if name.startswith("binaries/"))
    path = tmp_path / "unit.so"
    path.write_bytes(binary)
    library = ctypes.CDLL(str(path))
    assert hasattr(library, f"fmi{unit.version}DoStep")
    assert not hasattr(library, "mixed_step")
    assert not hasattr(library, "mixed_init")


@pytest.mark.skipif(shutil.which("nm") is None or not COMPILERS, reason="needs nm and a C compiler")
@pytest.mark.parametrize("version", [3, 2])
def test_no_variable_outside_an_instance(version: int, mixed: LoadedSheet, tmp_path: Path) -> None:
    """No object file has writable data."""
    folder = unpack(build_unit(mixed, version, binary=False), tmp_path)
    files = [path.name for path in folder.glob("*.c")]
    subprocess.run([COMPILERS[0], "-std=c99", "-O0", "-c", *files], cwd=folder, check=True)
    objects = [path.name for path in folder.glob("*.o")]
    symbols = subprocess.run(["nm", *objects], cwd=folder, check=True, capture_output=True, text=True).stdout
    assert " T " in symbols
    assert not [line for line in symbols.splitlines() if re.search(r" [BbDdCSsG] ", line)]


@pytest.mark.skipif(not COMPILERS, reason="no C compiler")
def test_two_units_link_into_one_program(mixed: LoadedSheet, tmp_path: Path) -> None:
    """With the standard's prefixes for static linking, two sheets and both versions live side by side."""
    objects: list[str] = []
    for version in (3, 2):
        for sheet in (mixed, load(str(DELAYS))):
            unit = build_unit(sheet, version, period=None if sheet is mixed else 0.1, binary=False)
            folder = tmp_path / f"{unit.identifier}{version}"
            folder.mkdir(exist_ok=True)
            unpack(unit, folder)
            prefix = f"-DFMI{version}_FUNCTION_PREFIX={unit.identifier}_"
            wrapper = [f"fmi{version}-unit.c"]
            core = [f"{unit.identifier}.c"] if version == 3 else []  # the sheet's own code is the same in both
            subprocess.run([COMPILERS[0], "-std=c99", prefix, "-c", *wrapper, *core], cwd=folder, check=True)
            objects += [str(path) for path in folder.glob("*.o")]
    (tmp_path / "main.c").write_text(
        "const char *mixed_fmi3GetVersion(void);\nconst char *delays_fmi2GetVersion(void);\n"
        "int main(void) { return mixed_fmi3GetVersion()[0] == '3' && delays_fmi2GetVersion()[0] == '2' ? 0 : 1; }\n",
        encoding="ascii",
    )
    subprocess.run([COMPILERS[0], "-std=c99", "main.c", *objects, "-o", "main"], cwd=tmp_path, check=True)
    assert subprocess.run([str(tmp_path / "main")]).returncode == 0


@pytest.mark.skipif(not COMPILERS, reason="no C compiler")
@pytest.mark.parametrize("version", [3, 2])
def test_an_importer_compiles_the_sources(
    version: int, mixed: LoadedSheet, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """fmpy builds the binary from what the description lists, with CMake."""
    from fmpy.build import build_platform_binary

    monkeypatch.setenv("PATH", f"{Path(sys.executable).parent}:{os.environ['PATH']}")
    if shutil.which("cmake") is None or shutil.which("make") is None:
        pytest.skip("needs cmake and make")
    unit = build_unit(mixed, version, binary=False)
    assert unit.platform is None
    folder = tmp_path / "unit"
    for name, content in unit.files:
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_bytes(content)
    (tmp_path / "build").mkdir()
    build_platform_binary(folder, tmp_path / "build", generator="Unix Makefiles")
    importer = Importer(unit, tmp_path, str(folder))
    importer.initialize()
    inputs = random_inputs(10)
    expected = mixed.simulator().run(inputs)
    found = importer.run(inputs, ["sum", "image"])
    assert same_bits(found["sum"], expected["sum"])
    assert same_bits(found["image"], expected["image"])
    assert np.isnan(found["sum"]).any()
    importer.close()


@pytest.mark.skipif(not COMPILERS, reason="no C compiler")
def test_under_sanitizers(mixed: LoadedSheet, tmp_path: Path) -> None:
    unit = build_unit(mixed, 3, binary=False)
    folder = unpack(unit, tmp_path)
    files = ["fmi3-unit.c", "mixed.c", str(Path(__file__).with_name("sanitized.c"))]
    flags = ["-std=c99", "-g", "-fsanitize=address,undefined", "-fno-sanitize-recover=all", f"-I{HEADERS}"]
    built = subprocess.run([COMPILERS[0], *flags, *files, "-o", "importer"], cwd=folder, capture_output=True, text=True)
    if "cannot find" in built.stderr:
        pytest.skip("the compiler has no sanitizers")
    assert built.returncode == 0, built.stderr
    done = subprocess.run([str(folder / "importer"), unit.token], capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
