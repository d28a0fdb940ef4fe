"""The cache under what real machines do: killed processes, no room, no rights, no compiler, changed sheets."""

from __future__ import annotations

import os
import platform
import resource
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

import pytest

from saoflow.cache import Folder, part_prefix
from saoflow.codegen.compiler import find_compiler

pytestmark = pytest.mark.skipif(
    find_compiler() is None or os.name != "posix", reason="there is no C compiler on this machine, or no signals"
)

SHEET = "sheet: sum\ninputs: {u: {}}\nblocks:\n  y: {add: [u, before]}\n  before: {delay: y}\noutputs: [y]\n"
RESULT = "y\n1.0\n3.0\n"
HELD = """\
#!/bin/sh
[ "$1" = --version ] && { echo "a compiler that waits"; exit 0; }
echo $$ > "$SAOFLOW_TEST/began.part"; mv "$SAOFLOW_TEST/began.part" "$SAOFLOW_TEST/began"
while [ -e "$SAOFLOW_TEST/hold" ]; do sleep 0.02; done
%s "$@"
code=$?
echo $code > "$SAOFLOW_TEST/ended"
exit $code
"""


@dataclass
class Bench:
    """A folder with a sheet, its readings, a cache, and a compiler that waits while there is a file ``hold``."""

    folder: Path
    settings: dict[str, str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        compiler = find_compiler()
        assert compiler is not None
        (self.folder / "sum.yaml").write_text(SHEET)
        (self.folder / "in.csv").write_text("u\n1\n2\n")
        (self.folder / "cc").write_text(HELD % " ".join(compiler.command))
        (self.folder / "cc").chmod(0o755)

    @property
    def cache(self) -> Path:
        return self.folder / "cache" / "saoflow"

    def start(self, *arguments: str, limit: Callable[[], None] | None = None) -> subprocess.Popen[str]:
        """``saoflow run`` in C, in a process of its own."""
        environment = {
            **{name: value for name, value in os.environ.items() if name not in ("CC", "SAOFLOW_CC")},
            "XDG_CACHE_HOME": str(self.folder / "cache"),
            "SAOFLOW_CC": str(self.folder / "cc"),
            "SAOFLOW_TEST": str(self.folder),
            "OPENBLAS_NUM_THREADS": "1",
            **self.settings,
        }
        command = [sys.executable, "-m", "saoflow.cli", "run", "sum.yaml", "in.csv", "-o", "out.csv", "--backend", "c"]
        return subprocess.Popen(
            [*command, *arguments],
            cwd=self.folder,
            env=environment,
            text=True,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            preexec_fn=limit,
        )

    def run(self, *arguments: str, limit: Callable[[], None] | None = None) -> tuple[int, str]:
        """Exit code and what is said on standard error."""
        process = self.start(*arguments, limit=limit)
        _, said = process.communicate(timeout=60)
        return process.returncode, said

    def wait_for(self, name: str) -> str:
        """The content of a file, once it is there."""
        deadline = time.monotonic() + 60
        while not (self.folder / name).exists():
            assert time.monotonic() < deadline, f"{name} does not come"
            time.sleep(0.01)
        return (self.folder / name).read_text()

    def held(self) -> tuple[subprocess.Popen[str], int]:
        """A run that waits for its compiler, and the compiler's process."""
        (self.folder / "hold").touch()
        process = self.start()
        return process, int(self.wait_for("began"))

    def left(self) -> list[str]:
        """What lies in the cache: the kinds of its files."""
        return sorted("part" if p.name.startswith("part-") else p.suffix for p in self.cache.iterdir())

    def result(self) -> str | None:
        path = self.folder / "out.csv"
        return path.read_text() if path.exists() else None


WHOLE = {".0", ".program", ".so"}
"""What one sheet keeps: which object its program has, the program, the object."""


@pytest.fixture
def bench(tmp_path: Path) -> Bench:
    return Bench(tmp_path)


@pytest.mark.parametrize("compiler_too", [True, False], ids=["both killed", "the compiler ends alone"])
def test_a_compile_killed_half_way_leaves_nothing_that_is_used(bench: Bench, compiler_too: bool) -> None:
    for _ in range(2):
        process, compiler = bench.held()
        process.kill()
        process.communicate()
        if compiler_too:
            os.kill(compiler, signal.SIGKILL)
            (bench.folder / "hold").unlink()
        else:
            (bench.folder / "hold").unlink()
            bench.wait_for("ended")
            (bench.folder / "ended").unlink()
        (bench.folder / "began").unlink()
        assert ".so" not in bench.left() and bench.left().count("part") == 1 and bench.result() is None
    assert bench.run() == (0, "")
    assert bench.wait_for("ended") == "0\n"
    assert bench.result() == RESULT and set(bench.left()) == WHOLE


def test_a_compiler_that_is_killed_is_told(bench: Bench) -> None:
    process, compiler = bench.held()
    os.kill(compiler, signal.SIGKILL)
    _, said = process.communicate(timeout=60)
    assert process.returncode == 2 and "error[E607]" in said and "it is killed by signal 9" in said
    assert bench.left() == [".program"] and bench.result() is None


def test_a_process_killed_while_it_moves_its_object_leaves_none(bench: Bench) -> None:
    script = (
        "import os, signal, sys\nfrom saoflow import cli\nmove = os.replace\n"
        "def killed(a, b):\n    if str(b).endswith('.so'): os.kill(os.getpid(), signal.SIGKILL)\n    move(a, b)\n"
        "os.replace = killed\ncli.run(sys.argv[1:])"
    )
    environment = {**os.environ, "XDG_CACHE_HOME": str(bench.folder / "cache")}
    command = ["run", "sum.yaml", "in.csv", "-o", "out.csv", "--backend", "c"]
    done = subprocess.run([sys.executable, "-c", script, *command], cwd=bench.folder, env=environment)
    assert done.returncode == -signal.SIGKILL
    assert bench.left().count("part") == 2 and ".so" not in bench.left()  # the compiler's folder, and the object
    assert bench.run() == (0, "")
    assert bench.result() == RESULT and set(bench.left()) == WHOLE


def test_only_parts_of_processes_that_are_gone_are_removed(bench: Bench) -> None:
    bench.cache.mkdir(parents=True)
    gone = subprocess.Popen([sys.executable, "-c", ""])
    gone.wait()
    alive = part_prefix() + "abc"
    orphan, elsewhere = f"part-{platform.node()}-{gone.pid}-abc", f"part-not-here-{gone.pid}-abc"
    for name in (alive, orphan, elsewhere):
        (bench.cache / name).mkdir()
    Folder(bench.cache).tidy()
    assert sorted(p.name for p in bench.cache.iterdir()) == sorted([alive, elsewhere])


def test_a_disk_without_room_is_told_and_the_next_run_compiles(bench: Bench) -> None:
    def small_files() -> None:
        resource.setrlimit(resource.RLIMIT_FSIZE, (4096, 4096))

    code, said = bench.run(limit=small_files)
    assert code == 2 and "error[E607]: the C code cannot be compiled" in said and "Traceback" not in said
    assert ".so" not in bench.left() and "part" not in bench.left() and bench.result() is None
    assert bench.run() == (0, "")
    assert bench.result() == RESULT and set(bench.left()) == WHOLE


def test_an_object_that_cannot_be_loaded_is_told(bench: Bench) -> None:
    (bench.folder / "cc").write_text(
        f"#!/bin/sh\n[ $1 = --version ] && exit 0\nfor name; do :; done\nhead -c 64 {sys.executable} > $name\n"
    )
    code, said = bench.run()
    assert code == 2 and bench.result() is None
    assert "error[E607]: the compiled frame cannot be loaded" in said and "use backend `interpreter`" in said


def test_a_cache_that_nobody_may_write_to_is_told_and_does_without(bench: Bench) -> None:
    bench.settings["XDG_CACHE_HOME"] = "/proc/none"
    code, said = bench.run()
    assert code == 0 and bench.result() == RESULT
    assert "warning[W607]: compiled code is not kept" in said and "/proc/none" in said


def test_without_a_compiler_the_interpreter_does_the_work(bench: Bench) -> None:
    bench.settings |= {"PATH": str(bench.folder / "nothing"), "SAOFLOW_CC": ""}
    script = bench.folder / "sitecustomize.py"  # and no ziglang
    script.write_text(
        "import importlib.util as u\nf = u.find_spec\nu.find_spec = lambda n, *a: None if n == 'ziglang' else f(n, *a)\n"
    )
    bench.settings["PYTHONPATH"] = str(bench.folder)
    code, said = bench.run()
    assert code == 0 and bench.result() == RESULT
    assert "warning[W607]: there is no C compiler: the interpreter runs the frames" in said


def test_processes_that_begin_together_compile_one_object(bench: Bench) -> None:
    (bench.folder / "hold").touch()
    processes = [bench.start("-o", f"out{i}.csv") for i in range(4)]
    bench.wait_for("began")
    (bench.folder / "hold").unlink()
    for i, process in enumerate(processes):
        _, said = process.communicate(timeout=60)
        assert (process.returncode, said) == (0, "")
        assert (bench.folder / f"out{i}.csv").read_text() == RESULT
    assert bench.left().count(".so") == 1 and set(bench.left()) == WHOLE


def test_what_is_kept_is_neither_elaborated_nor_used_after_a_change(bench: Bench) -> None:
    trap = bench.folder / "sitecustomize.py"
    trap.write_text("import sys\nsys.modules['saoflow.diagrams.elaborate'] = None\n")
    assert bench.run() == (0, "")
    bench.settings["PYTHONPATH"] = str(bench.folder)
    (bench.folder / "out.csv").unlink()
    assert bench.run() == (0, "")  # kept: elaboration cannot even be imported
    assert bench.result() == RESULT
    _, said = bench.run("--set", "k=1")
    assert "E699" in said  # not kept, so the trap closes
    trap.unlink()
    (bench.folder / "sum.yaml").write_text(SHEET.replace("add: [u, before]", "add: [u, before, before]"))
    assert bench.run() == (0, "")
    assert bench.result() == "y\n1.0\n4.0\n"
    over = SHEET + "budget: {operations: 0, period: 1}\n"
    (bench.folder / "sum.yaml").write_text(over)
    for _ in range(2):
        code, said = bench.run()
        assert code == 1 and "error[E401]" in said
