"""Recordings longer than memory: read, run and written in parts, to the bit and to the message as in one piece."""

from __future__ import annotations

import csv
import gzip
import math
import os
import resource
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

import saoflow
from saoflow import DiagnosisError, cli
from saoflow.codegen.compiler import find_compiler
from saoflow.recordings import (
    FrameReader,
    csv_reader,
    open_table,
    parquet_reader,
    read_frames,
    read_table,
    text,
    write_table,
)
from saoflow.wires import WireType
from verification.flights import load_recording, sensors

GOOD = Path(__file__).parent / "sheets" / "good"
LAG = str(GOOD / "first_order_lag.yaml")
SCALAR, VECTOR, FLAG = WireType(), WireType((2,)), WireType((), True)
BACKENDS = ["interpreter", *(["c"] if find_compiler() else [])]


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


def in_small_parts(monkeypatch: pytest.MonkeyPatch, size: int) -> None:
    monkeypatch.setattr(text, "BLOCK", size)
    monkeypatch.setattr(csv_reader, "ROWS", 3)
    monkeypatch.setattr(parquet_reader, "ROWS", 7)


def random_text(seed: int) -> str:
    """CSV as people write it: quotes, empty cells, text that nobody reads, cells over several lines."""
    rng = np.random.default_rng(seed)
    end = str(rng.choice(["\n", "\r\n"]))
    lines = ['v_2,note,"s",v_1,on']
    for k in range(int(rng.integers(1, 60))):
        note = str(rng.choice(["1", "1", "1", '"a, b"', f'"two{end}lines, ""quoted"""', "x"]))
        s = str(rng.choice(["", " 2.5 ", '"3"', "nan", "-inf", f"{rng.normal()!r}", f"{rng.normal()!r}"]))
        lines.append(f"{k},{note},{s},{rng.normal()!r},{rng.integers(2)}")
    blank = str(rng.choice(["", end, end * 5]))
    return str(rng.choice(["", end])) + end.join(lines) + blank


@pytest.mark.parametrize("size", [1, 13, 200])
def test_parts_together_are_what_the_csv_module_reads(here: Path, monkeypatch: pytest.MonkeyPatch, size: int) -> None:
    in_small_parts(monkeypatch, size)
    ports = {"s": SCALAR, "v": VECTOR, "on": FLAG}
    for seed in range(25):
        text = random_text(seed)
        Path("x.csv").write_text(text, newline="")
        Path("x.csv.gz").write_bytes(gzip.compress(text.encode()))
        rows = [row for row in csv.reader(text.splitlines(keepends=True)) if row][1:]
        number = [[float(cell) if cell.strip() else math.nan for cell in (r[0], r[2], r[3], r[4])] for r in rows]
        want = np.array(number)
        for name in ("x.csv", "x.csv.gz"):
            with FrameReader(name, ports) as reader:
                parts = list(reader)
            assert sum(part.count for part in parts) == reader.count == len(rows)
            together = {p: np.concatenate([part.inputs[p] for part in parts]) for p in ports}
            np.testing.assert_array_equal(together["s"], want[:, 1])
            np.testing.assert_array_equal(together["v"], want[:, [2, 0]])
            np.testing.assert_array_equal(together["on"], want[:, 3])
            assert reader.missing.get("s", 0) == np.count_nonzero(~np.isfinite(want[:, 1]))
            assert reader.share == 1.0
            assert reader.warnings == read_frames(name, ports).warnings


@pytest.mark.parametrize("extension", ["csv", "csv.gz", "parquet"])
def test_the_file_that_is_written_does_not_depend_on_the_parts(here: Path, extension: str) -> None:
    rng = np.random.default_rng(3)
    n = 150_000 if extension == "parquet" else 20_000
    columns = {"t": np.arange(n) * 0.048, "y": rng.normal(size=n), "on": rng.integers(0, 2, n).astype(np.int8)}
    write_table(f"whole.{extension}", columns)
    with open_table(f"parts.{extension}") as writer:
        start = 0
        while start < n:
            stop = min(n, start + int(rng.integers(1, n // 4)))
            writer.write({name: column[start:stop] for name, column in columns.items()})
            start = stop
    assert Path(f"parts.{extension}").read_bytes() == Path(f"whole.{extension}").read_bytes()


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize("real", [64, 32])
@pytest.mark.parametrize("flights", [None, 3])
def test_chunks_have_the_bits_of_the_whole_run(backend: str, real: int, flights: int | None) -> None:
    rng = np.random.default_rng(5)
    sheet = saoflow.load(LAG)
    lead = () if flights is None else (flights,)
    u = rng.normal(size=(*lead, 500))
    u.flat[77] = math.nan if flights else 1e300
    whole = sheet.simulator(backend, real=real).run({"u": u})["y"]
    edges = [0, 1, 2, 100, 101, 499, 500]
    in_chunks = sheet.simulator(backend, real=real)
    parts = in_chunks.run_chunks({"u": u[..., a:b]} for a, b in pairwise(edges))
    assert np.concatenate([part["y"] for part in parts], axis=-1).tobytes() == whole.tobytes()
    assert in_chunks.state().frame == 500


@pytest.mark.parametrize("backend", BACKENDS)
def test_blocks_that_do_not_run_every_frame_keep_their_turn(backend: str) -> None:
    sheet = saoflow.load(str(GOOD / "rates" / "main.yaml"))
    inputs = {name: np.random.default_rng(2).normal(size=(60, *wire.shape)) for name, wire in sheet.input_types.items()}
    whole = sheet.simulator(backend).run(inputs)
    chunks = ({name: array[a:b] for name, array in inputs.items()} for a, b in pairwise([0, 1, 3, 8, 9, 40, 60]))
    parts = list(sheet.simulator(backend).run_chunks(chunks))
    for name, values in whole.items():
        assert np.concatenate([part[name] for part in parts]).tobytes() == values.tobytes()


def test_the_flagship_in_chunks() -> None:
    sheet = saoflow.load("cmhe_fte")
    inputs = sensors(load_recording("a320_wind_350kt_5000ft").part(0.0, 20.0), seed=4).inputs()
    whole = sheet.simulator(BACKENDS[-1]).run(inputs)
    cuts = [0, 1, 150, 151, 417] if BACKENDS[-1] == "c" else [0, 5, 40]
    chunks = ({name: array[a:b] for name, array in inputs.items()} for a, b in pairwise(cuts))
    parts = list(sheet.simulator(BACKENDS[-1]).run_chunks(chunks))
    for name, values in whole.items():
        together = np.concatenate([part[name] for part in parts])
        assert together.tobytes() == values[: len(together)].tobytes()


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize("extension", ["csv", "csv.gz", "parquet"])
def test_the_command_writes_the_same_bytes_in_parts(
    here: Path, monkeypatch: pytest.MonkeyPatch, extension: str, backend: str
) -> None:
    u = np.random.default_rng(1).normal(size=300)
    u[117] = -math.inf
    source = f"in.{extension}"
    write_table(source, {"t": np.arange(300) * 0.048, "u": u})
    arguments = ["run", LAG, source, "--backend", backend, "-o"]
    assert cli.run([*arguments, f"whole.{extension}"]) == 0
    in_small_parts(monkeypatch, 500)
    assert cli.run([*arguments, f"parts.{extension}"]) == 0
    assert Path(f"parts.{extension}").read_bytes() == Path(f"whole.{extension}").read_bytes()
    want = saoflow.load(LAG).simulator().run({"u": u})["y"]
    np.testing.assert_array_equal(read_table(f"parts.{extension}")["y"], want)


# -- mistakes far down


def long_recording(path: str, rows: int, mistakes: dict[int, str]) -> None:
    """Rows of t and u; ``mistakes``: lines of text in the place of rows, from 1."""
    block = "".join(f"{k * 0.048:.3f},{math.sin(k):.6f}\n" for k in range(1000))
    with open(path, "w") as file:
        file.write("t,u\n")
        at = 0
        for row, text in sorted(mistakes.items()):
            whole, part = divmod(row - 1 - at, 1000)
            file.write(block * whole + "".join(block.splitlines(keepends=True)[:part]) + text + "\n")
            at = row
        file.write(block * ((rows - at) // 1000))


def test_a_mistake_far_down_has_its_place_and_leaves_nothing(
    here: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    long_recording("x.csv", 250_000, {200_001: "1,fast", 200_002: "7", 210_001: "0,"})
    assert cli.run(["run", LAG, "x.csv", "-o", "out.csv", "--backend", BACKENDS[-1]]) == 2
    assert capsys.readouterr().err.splitlines() == [
        "x.csv:200002:3: error[E503]: `fast` in row 200001 of column `u` is not a number",
        " 200002 | 1,fast",
        "        |   ^^^^",
        "    = cause: a cell is a number such as -1.5e-3",
        "    = remedy: correct the cell; a missing sample is an empty cell or nan",
        "x.csv:200003:1: error[E505]: row 200002 has 1 cell, the header 2",
        " 200003 | 7",
        "        | ^",
        "    = cause: every row has one cell for each name of the header",
        "    = remedy: drop the line, or fill in the cells; a missing sample is an empty cell",
    ]
    assert os.listdir(here) == ["x.csv"]


def test_mistakes_far_apart_are_told_together_in_bounds(here: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    Path("x.csv").write_text("u\n1\n2\nbad\n" + "3\n" * 400 + "worse\n" + "4\n" * 4000)
    in_small_parts(monkeypatch, 100)

    def told() -> list[str]:
        with pytest.raises(DiagnosisError) as caught:
            list(FrameReader("x.csv", {"u": SCALAR}))
        return [f"{d.position}: {d.message}" for d in caught.value.diagnoses]

    first, second, rest = told()
    assert first == "x.csv:4:1: `bad` in row 3 of column `u` is not a number"
    assert second == "x.csv:405:1: `worse` in row 404 of column `u` is not a number"
    assert "nothing from line 1598 on" in rest
    monkeypatch.setattr(csv_reader, "LOOK_ON", 10**9)
    assert told() == [first, second]


def test_a_boolean_far_down_in_parquet(here: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("pyarrow")
    on = np.zeros(100)
    on[55], on[77] = 2.0, math.nan
    write_table("x.parquet", {"on": on})
    in_small_parts(monkeypatch, 100)
    seen = 0
    with pytest.raises(DiagnosisError) as caught:
        for part in FrameReader("x.parquet", {"on": FLAG}):
            seen += part.count
    assert seen == 49  # whole parts of 7 rows before the mistake
    assert [str(d.message) for d in caught.value.diagnoses] == ["`2` in row 56 of column `on` is not 0 or 1"]


@pytest.mark.parametrize("extension", ["csv", "csv.gz", "parquet"])
def test_an_interrupt_or_a_full_disk_leaves_the_old_file_and_nothing_else(here: Path, extension: str) -> None:
    name = f"x.{extension}"
    write_table(name, {"a": np.array([1.0])})

    def interrupted() -> None:
        with open_table(name) as writer:
            writer.write({"a": np.zeros(100_000)})
            raise KeyboardInterrupt

    def full() -> None:
        before = resource.getrlimit(resource.RLIMIT_FSIZE)
        resource.setrlimit(resource.RLIMIT_FSIZE, (20_000, before[1]))
        try:
            write_table(name, {"a": np.random.default_rng(1).normal(size=200_000)})
        finally:
            resource.setrlimit(resource.RLIMIT_FSIZE, before)

    tests: list[tuple[Callable[[], None], type[BaseException], str]] = [
        (interrupted, KeyboardInterrupt, "^$"),
        (full, DiagnosisError, "File too large"),
    ]
    for do, kind, words in tests:
        with pytest.raises(kind, match=words):
            do()
        assert os.listdir(here) == [name]
        assert read_table(name)["a"].tolist() == [1.0]


@pytest.mark.parametrize(("number", "code"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_a_command_that_is_stopped_leaves_nothing_half_written(here: Path, number: int, code: int) -> None:
    long_recording("x.csv", 300_000, {})
    command = [sys.executable, "-m", "saoflow.cli", "run", LAG, "x.csv", "-o", "out.csv"]
    heard = lambda: signal.signal(signal.SIGINT, signal.SIG_DFL)  # noqa: E731  a shell's background job ignores it
    process = subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, preexec_fn=heard
    )
    part = here / f".saoflow-{process.pid}.part"
    while not (part.exists() and part.stat().st_size) and process.poll() is None:
        time.sleep(0.005)
    assert process.poll() is None, "it ran to its end before it could be stopped"
    process.send_signal(number)
    said = process.communicate()
    assert (process.returncode, said) == (code, ("", ""))
    assert os.listdir(here) == ["x.csv"]


# -- memory


def peak(script: str, *arguments: str, limit: int | None = None) -> int:
    """Run Python in a process of its own, its address space limited; the most memory it had, in KiB."""

    def limited() -> None:
        if limit is not None:
            resource.setrlimit(resource.RLIMIT_AS, (limit, limit))

    # Not ru_maxrss: that counts what the process was before it became another, a copy of this one.
    script += "\nprint(next(line.split()[1] for line in open('/proc/self/status') if line.startswith('VmHWM')))"
    done = subprocess.run(
        [sys.executable, "-c", script, *arguments],
        env={**os.environ, "OPENBLAS_NUM_THREADS": "1"},
        capture_output=True,
        text=True,
        preexec_fn=limited,
    )
    assert done.returncode == 0, done.stderr
    return int(done.stdout.splitlines()[-1])


RUN = "import sys\nfrom saoflow import cli\nassert cli.run(['run', *sys.argv[1:]]) == 0"


@pytest.mark.skipif(sys.platform != "linux", reason="limits of the address space are Linux's")
def test_a_recording_larger_than_the_address_space_runs(here: Path) -> None:
    """Long cells keep this quick: a byte of text costs a hundredth of a byte of short rows."""
    limit = 230 * 2**20
    with open("long.csv", "wb") as file:
        file.write(b"u\n")
        for k in range(62):
            file.write((b"0.%02d" % k + b"0" * 4000 + b"\n") * 1000)
    try:
        assert os.stat("long.csv").st_size > limit
        peak(RUN, LAG, "long.csv", "-o", "out.csv", limit=limit)
    finally:
        os.unlink("long.csv")
    want = saoflow.load(LAG).simulator().run({"u": np.repeat(np.arange(62) / 100.0, 1000)})["y"]
    assert read_table("out.csv")["y"].tobytes() == want.tobytes()


def test_memory_does_not_grow_with_the_recording(here: Path) -> None:
    peaks = []
    for name, rows in (("one.csv", 500_000), ("four.csv", 2_000_000)):
        long_recording(name, rows, {})
        peaks.append(peak(RUN, LAG, name, "-o", f"of_{name}", "--backend", BACKENDS[-1]))
    grown = Path("four.csv").stat().st_size - Path("one.csv").stat().st_size
    assert grown > 6 * 2**20
    assert (peaks[1] - peaks[0]) * 1024 < grown / 3, peaks


def test_too_little_memory_is_told(here: Path) -> None:
    Path("x.csv").write_text("u\n1\n")
    script = (
        "import sys\nfrom saoflow import cli\nimport saoflow.recordings\n"
        "def short(*_): raise MemoryError\nsaoflow.recordings.FrameReader.__init__ = short\n"
        "sys.exit(cli.run(['run', *sys.argv[1:]]))"
    )
    done = subprocess.run(
        [sys.executable, "-c", script, LAG, "x.csv", "-o", "o.csv"], capture_output=True, text=True
    )
    assert done.returncode == 2 and "error[E611]: there is not enough memory" in done.stderr
    assert os.listdir(here) == ["x.csv"]
