"""The command line: exit codes, messages, machine-readable answers, files whole or not at all."""

from __future__ import annotations

import io
import json
import os
import re
import resource
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from saoflow import cli
from saoflow.recordings import read_table

GOOD = Path(__file__).parent / "sheets" / "good"
LAG = str(GOOD / "first_order_lag.yaml")
TABLES = str(GOOD / "tables.yaml")
COMMANDS = ("check", "run", "budget", "show", "symbols", "demo", "verify", "fly")


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


def ends(capsys: pytest.CaptureFixture[str], code: int, *arguments: str) -> tuple[str, str]:
    """Run a command line that must end with that code; returns standard output and standard error."""
    found = cli.run(arguments)
    out, err = capsys.readouterr()
    assert found == code, (out, err)
    assert "Traceback" not in out + err
    return out, err


# -- the command line itself


def test_help_lists_every_command_and_each_has_an_example(capsys: pytest.CaptureFixture[str]) -> None:
    out, _ = ends(capsys, 0, "--help")
    for command in COMMANDS:
        assert re.search(rf"^  {command} +\S", out, re.M), command
        shown, _ = ends(capsys, 0, command, "--help")
        assert f"Example: saoflow {command}" in " ".join(shown.split()), command
    assert ends(capsys, 0, "help", "run") == ends(capsys, 0, "run", "--help")
    ends(capsys, 2)


def test_the_version_is_that_of_the_package(capsys: pytest.CaptureFixture[str]) -> None:
    from importlib.metadata import version

    assert ends(capsys, 0, "--version")[0] == f"saoflow {version('saoflow')}\n"


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["chekc", "x"], "error[E609]: there is no command `chekc`"),
        (["chekc", "x"], "= remedy: did you mean `check`?"),
        (["--jsno"], "there is no option `--jsno`"),
        (["run", LAG, "in.csv", "-o", "x.csv", "--rael", "32"], "= remedy: did you mean `--real`?"),
        (["run", LAG, "in.csv"], "missing option '-o'"),
        (["run", LAG], "missing argument 'IN'"),
        (["run", LAG, "in.csv", "-o", "x.csv", "--real", "many"], "invalid value for '--real'"),
        (["budget", LAG, "--depth", "-1"], "invalid value for '--depth'"),
        (["check"], "missing argument 'SHEET...'"),
    ],
)
def test_usage_errors_exit_with_2(capsys: pytest.CaptureFixture[str], arguments: list[str], words: str) -> None:
    out, err = ends(capsys, 2, *arguments)
    assert not out and words in err, err


def test_usage_errors_are_machine_readable_too(capsys: pytest.CaptureFixture[str]) -> None:
    for arguments in (["run", LAG, "--json"], ["chekc", "--json"], ["check", "--json", "--jsno"]):
        out, err = ends(capsys, 2, *arguments)
        assert not err
        assert json.loads(out)["diagnoses"][0]["code"] == "E609"


def test_progress_shows_on_a_terminal_for_work_that_takes_time(monkeypatch: pytest.MonkeyPatch) -> None:
    from saoflow.commands import shell

    class Terminal(io.StringIO):
        def isatty(self) -> bool:
            return True

    def shown(stream: io.StringIO, patience: float) -> bool:
        monkeypatch.setattr(sys, "stderr", stream)
        monkeypatch.setattr(shell, "PATIENCE", patience)
        with shell.progress_bar("running", 10) as bar:
            bar(5)
            return bar.progress is not None

    assert shown(Terminal(), 0.0)
    assert not shown(Terminal(), 60.0)
    assert not shown(io.StringIO(), 0.0)


def test_a_command_that_cannot_be_loaded_does_not_disturb_the_others(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(cli, "_joined", lambda: {"broken": "no_such_package.commands:broken"})
    out, _ = ends(capsys, 0, "--help")
    assert "broken" in out and "cannot be loaded" in out and "check" in out
    _, err = ends(capsys, 2, "broken")
    assert "error[E609]: the command `broken` cannot be loaded" in err and "No module named 'no_such_package'" in err
    ends(capsys, 0, "check", LAG)


def test_an_error_of_ours_asks_for_a_report(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    from saoflow import pipeline

    def breaks(*_: object) -> None:
        raise ZeroDivisionError("a mistake")

    monkeypatch.setattr(pipeline, "load", breaks)
    _, err = ends(capsys, 2, "budget", LAG)
    assert err.startswith("error[E699]: an error inside saoflow: ZeroDivisionError: a mistake\n")
    assert "please report it" in err
    monkeypatch.setenv("SAOFLOW_TRACEBACK", "1")
    assert cli.run(["budget", LAG]) == 2
    assert "Traceback" in capsys.readouterr().err


def test_interruption_is_quiet(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    from saoflow import pipeline

    def interrupted(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(pipeline, "load", interrupted)
    assert ends(capsys, 130, "budget", LAG) == ("", "")


def test_a_reader_that_has_enough_gets_no_more() -> None:
    process = subprocess.Popen(
        [sys.executable, "-m", "saoflow.cli", "show", "inverse_8x8", "--stage", "program"],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
    )
    assert process.stdout is not None and process.stderr is not None
    process.stdout.read(10)
    process.stdout.close()
    told = process.stderr.read()
    process.stderr.close()
    assert process.wait() in (0, -signal.SIGPIPE) and told == b""


def streams(*arguments: str, out: str, err: str = "2>told") -> tuple[int, str]:
    """Run a command with its streams as the shell makes them; the exit code and what stands in the file `told`."""
    line = f"{sys.executable} -m saoflow {' '.join(arguments)} {err} {out}"
    code = subprocess.run(["bash", "-c", f"set -o pipefail; {line}"], check=False).returncode
    return code, Path("told").read_text(encoding="utf-8") if Path("told").exists() else ""


@pytest.mark.parametrize("arguments", [("budget", LAG, "--json"), ("symbols",), ("schema",), ("check", LAG)])
def test_a_full_disk_behind_standard_output_is_a_diagnosis(here: Path, arguments: tuple[str, ...]) -> None:
    code, told = streams(*arguments, out=">/dev/full")
    assert code == 2 and told.startswith("error[E601]: standard output cannot be written\n")
    assert "No space left" in told and "Traceback" not in told and "E699" not in told


def test_streams_that_are_closed_or_full_change_no_exit_code(here: Path) -> None:
    assert streams("check", LAG, out=">&-") == (0, "")
    code, told = streams("check", "nowhere", out=">&-")
    assert code == 2 and told.startswith("error[E602]")
    assert streams("check", "nowhere", out=">/dev/null", err="2>/dev/full")[0] == 2
    assert streams("check", "nowhere", out=">/dev/full", err="2>/dev/full")[0] == 2
    assert streams("check", LAG, out=">/dev/full", err="2>&-")[0] == 2


def test_a_terminal_without_our_letters_shows_others(here: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for encoding in ("ascii", "latin-1"):
        monkeypatch.setenv("PYTHONIOENCODING", encoding)
        assert streams("budget", "umhe_fte", out="> shown") == (0, "")
        assert b"operations a frame" in Path("shown").read_bytes() and b"?" in Path("shown").read_bytes()
    monkeypatch.delenv("PYTHONIOENCODING")
    monkeypatch.setenv("LC_ALL", "C")
    monkeypatch.setenv("PYTHONUTF8", "0")
    monkeypatch.setenv("PYTHONCOERCECLOCALE", "0")
    assert streams("budget", "umhe_fte", out="> shown") == (0, "")


def test_a_name_that_is_no_text_is_shown_as_it_is(here: Path) -> None:
    code, told = streams("check", "$'\\xff.yaml'", out="> shown")
    assert code == 2 and "E101" in told and Path("shown").read_bytes() == b"\xff.yaml: 1 error\n"


def test_a_working_folder_that_is_gone_is_told(here: Path) -> None:
    line = f"mkdir sub && cd sub && rmdir ../sub && {sys.executable} -m saoflow check {LAG}"
    done = subprocess.run(["bash", "-c", line], capture_output=True, text=True, check=False)
    assert done.returncode == 2 and done.stderr.startswith("error[E101]: the working folder is gone\n")


def test_tables_that_nobody_reads_on_are_no_failure(here: Path) -> None:
    assert streams("symbols", out="| head -1 > /dev/null") == (0, "")


def test_errors_that_nobody_reads_on_are_errors_all_the_same(here: Path) -> None:
    lines = "".join(f"  y{i}: {{add: [x, z{i}]}}\n" for i in range(2000))  # more than a pipe holds
    Path("bad.yaml").write_text(f"sheet: bad\ninputs: [x]\nblocks:\n{lines}outputs: [y0]\n", encoding="utf-8")
    assert streams("check", "bad.yaml", err="2>&1", out="| head -1 > /dev/null")[0] == 2
    assert streams("check", "bad.yaml", "--json", err="", out="| head -1 > /dev/null")[0] == 2


@pytest.mark.parametrize("checked_before", [False, True])
def test_start_up_is_quick_and_loads_nothing_heavy(tmp_path: Path, checked_before: bool) -> None:
    environment = {**os.environ, "XDG_CACHE_HOME": str(tmp_path)}
    heavy = ["pint", "networkx", "matplotlib", "jsbsim", "pyarrow", "scipy", "rich.table"]
    if checked_before:
        subprocess.run([sys.executable, "-m", "saoflow", "check", LAG], env=environment, check=True)
        heavy += ["numpy", "yaml", "typer", "pydantic", "rich"]
    code = (
        "import sys, time; start = time.process_time(); import saoflow; print(time.process_time() - start)\n"
        "from saoflow import cli\n"
        f"assert cli.run(['check', {LAG!r}]) == 0\n"
        f"print([m for m in {heavy} if m in sys.modules])"
    )
    before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, env=environment)
    # Half of these bounds on a machine that has nothing else to do; processor time, as others may be at work.
    taken = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before
    assert taken < (0.4 if checked_before else 1.0)
    first, _, last = done.stdout.splitlines()
    assert float(first) < 0.3
    assert last == "[]"


# -- check


def test_check_counts_what_it_finds(capsys: pytest.CaptureFixture[str]) -> None:
    out, err = ends(capsys, 0, "check", LAG, "inverse_8x8")
    assert out == "first_order_lag: 5 blocks, 0 sub-sheets, 0 errors\ninverse_8x8: 37 blocks, 2 sub-sheets, 0 errors\n"
    assert not err


def test_check_tells_everything_of_every_sheet(capsys: pytest.CaptureFixture[str], here: Path) -> None:
    Path("bad.yaml").write_text(
        "sheet: bad\ninputs: {u: {shape: []}}\nblocks:\n  y: {ad: [u, w]}\n  z: {mul: [v, u]}\noutputs: [y]\n"
    )
    out, err = ends(capsys, 2, "check", "bad.yaml", LAG, "no_such_sheet", "missing.yaml")
    assert out.splitlines() == [
        "bad.yaml: 2 errors", "first_order_lag: 5 blocks, 0 sub-sheets, 0 errors", "no_such_sheet: 1 error", "missing.yaml: 1 error",
    ]  # fmt: skip
    assert [line.split(":")[-2] for line in err.splitlines() if "error[" in line] != []
    assert re.findall(r"error\[(\w+)\]", err) == ["E201", "E202", "E602", "E101"]
    answer = json.loads(ends(capsys, 2, "check", "bad.yaml", LAG, "--json")[0])
    assert [sheet["errors"] for sheet in answer["sheets"]] == [2, 0]
    first = answer["diagnoses"][0]
    assert (first["code"], first["file"], first["line"], first["column"]) == ("E201", "bad.yaml", 4, 7)
    assert first["remedy"] == "did you mean `add`?"


def test_set_reaches_the_parameters_of_every_command(capsys: pytest.CaptureFixture[str], here: Path) -> None:
    _, err = ends(capsys, 2, "check", "window_rms")
    assert "error[E207]" in err and "give --set n=VALUE" in err
    ends(capsys, 0, "check", "window_rms", "--set", "n=3", "--set", "largest=2*pi")
    one = json.loads(ends(capsys, 0, "budget", "window_rms", "--set", "n=3", "--set", "largest=2", "--json")[0])
    two = json.loads(ends(capsys, 0, "budget", "window_rms", "--set", "n=5", "--set", "largest=2", "--json")[0])
    assert two["operations"] > one["operations"]


@pytest.mark.parametrize(
    ("setting", "words"),
    [
        ("gain", "there is no `=` in it"),
        ("gain=", "there is no value"),
        ("=1", "no parameter name"),
        ("gian=1", "did you mean `gain`?"),
        ("gain=sqrt(", "error[E111]"),
        ("gain=nonsense", "unknown parameter `nonsense`"),
        ("gain=1/0", "division by zero"),
        ("gain=[1, [2]]", "error[E209]"),
    ],
)
def test_settings_that_make_no_sense_are_refused(capsys: pytest.CaptureFixture[str], setting: str, words: str) -> None:
    _, err = ends(capsys, 2, "check", LAG, "--set", setting)
    assert words in err, err


# -- run


def test_run_writes_what_the_sheet_computes(capsys: pytest.CaptureFixture[str], here: Path) -> None:
    out, err = ends(capsys, 0, "run", LAG, str(GOOD / "first_order_lag.csv"), "-o", "out.csv")
    assert out.startswith("first_order_lag: 5 frames in ") and "no missing samples; 2 columns in out.csv" in out
    assert not err and os.listdir() == ["out.csv"]
    assert Path("out.csv").read_text() == "t,y\n0.0,0.5\n0.048,0.75\n0.096,0.875\n0.144,0.4375\n0.192,-0.28125\n"


def test_run_with_other_parameters_probes_and_reals(capsys: pytest.CaptureFixture[str], here: Path) -> None:
    recording = str(GOOD / "first_order_lag.csv")
    out, _ = ends(
        capsys, 0, "run", LAG, recording, "-o", "o.csv.gz", "--set", "gain=0.1", "--probe", "step", "--probe", "step",
        "--real", "32", "--json",
    )  # fmt: skip
    answer = json.loads(out)
    assert answer["columns"] == ["t", "y", "step"] and answer["frames"] == 5 and answer["missing"] == {}
    table = read_table("o.csv.gz")
    assert table["step"][0] == float(np.float32(0.1))
    _, err = ends(capsys, 2, "run", LAG, recording, "-o", "o.csv", "--probe", "stpe", "--probe", "y")
    assert "error[E303]: there is no wire `stpe`" in err and "did you mean `step`?" in err
    _, err = ends(capsys, 2, "run", LAG, recording, "-o", "o.csv", "--probe", "y")
    assert "`--probe y` is an output already" in err


def test_exact_mode_puts_the_function_in_place_of_its_table(capsys: pytest.CaptureFixture[str], here: Path) -> None:
    Path("s.yaml").write_text(
        "sheet: s\ninputs: {u: {shape: []}}\nblocks:\n  y: {lookup: u, function: sin, range: [0, 1], error: 1e-2}\noutputs: [y]\n"
    )
    Path("in.csv").write_text("u\n0.3\n")
    found = []
    for options in ([], ["--exact"]):
        ends(capsys, 0, "run", "s.yaml", "in.csv", "-o", "o.csv", *options)
        found.append(read_table("o.csv")["y"][0])
    assert found[1] == pytest.approx(np.sin(0.3), rel=1e-15)
    assert 1e-6 < abs(found[0] - found[1]) <= 1e-2


def test_missing_samples_are_warned_of_and_run(capsys: pytest.CaptureFixture[str], here: Path) -> None:
    Path("in.csv").write_text('u\n1\n""\nnan\n')
    out, err = ends(capsys, 0, "run", LAG, "in.csv", "-o", "o.csv")
    assert "3 frames" in out and "2 missing samples" in out
    assert "warning[W501]: 2 missing samples in 3 rows" in err and "u 2" in err
    answer = json.loads(ends(capsys, 0, "run", LAG, "in.csv", "-o", "o.csv", "--json")[0])
    assert answer["missing"] == {"u": 2} and answer["diagnoses"][0]["severity"] == "warning"


def test_run_tells_all_that_is_wrong_and_writes_nothing(capsys: pytest.CaptureFixture[str], here: Path) -> None:
    Path("in.csv").write_text("w\n1\n")
    _, err = ends(capsys, 2, "run", LAG, "in.csv", "-o", "none/o.csv", "--backend", "d", "--real", "16")
    assert re.findall(r"error\[(\w+)\]", err) == ["E601", "E603", "E603", "E502"]
    assert "there is no column `u`" in err and "`--backend` cannot be `d`" in err
    _, err = ends(capsys, 2, "run", LAG, "in.csv", "-o", "o.csv", "--set", "gain=[1, 2]")
    assert "error[" in err
    assert os.listdir() == ["in.csv"]


def test_a_sheet_without_inputs_takes_its_frames_from_the_rows(capsys: pytest.CaptureFixture[str], here: Path) -> None:
    Path("s.yaml").write_text("sheet: s\nblocks:\n  k: {add: [was, 1]}\n  was: {delay: k}\noutputs: [k]\n")
    Path("in.csv").write_text("t\n0\n1\n2\n")
    ends(capsys, 0, "run", "s.yaml", "in.csv", "-o", "o.csv")
    assert Path("o.csv").read_text() == "t,k\n0.0,1.0\n1.0,2.0\n2.0,3.0\n"


OVER = """\
sheet: over
inputs: {u: {shape: [2]}}
blocks:
  squares: {mul: [u, u]}
  sum: {add: ["squares[0]", "squares[1]"]}
outputs: [sum]
budget: {operations: 2, add: 5, period: 0.01}
"""


def test_over_budget_is_refused_before_it_runs(capsys: pytest.CaptureFixture[str], here: Path) -> None:
    Path("over.yaml").write_text(OVER)
    Path("in.csv").write_text("u_1,u_2\n1,2\n")
    _, err = ends(capsys, 1, "run", "over.yaml", "in.csv", "-o", "o.csv")
    assert "error[E401]: a frame of `over` is over budget: 3 operations, 2 allowed" in err
    assert "OVER BUDGET" in err and "squares" in err
    answer = json.loads(ends(capsys, 1, "run", "over.yaml", "in.csv", "-o", "o.csv", "--json")[0])
    assert answer["budget"]["over"] is True and answer["diagnoses"][0]["code"] == "E401"
    out, _ = ends(capsys, 1, "budget", "over.yaml")
    assert "over: 3 operations a frame of 2 (150 %), every 0.01 s" in out
    ends(capsys, 0, "check", "over.yaml")
    assert sorted(os.listdir()) == ["in.csv", "over.yaml"]


def test_the_c_backend_is_told_or_runs(capsys: pytest.CaptureFixture[str], here: Path) -> None:
    recording = str(GOOD / "first_order_lag.csv")
    code = cli.run(["run", LAG, recording, "-o", "o.csv", "--backend", "c"])
    told = capsys.readouterr().err
    assert (code == 2 and "error[E607]" in told) or (code == 0 and Path("o.csv").exists())


# -- budget, show, symbols

TABLES_BUDGET = """\
tables: 3 operations a frame
kind        used  limit
operations     3
lookup         3
sub-sheet                 operations    share
tables                             3  100.0 %  ████████████████████
  line                             1   33.3 %  ██████▋
  step                             1   33.3 %  ██████▋
  plane                            1   33.3 %  ██████▋
table                     look-ups  points  search steps
data                             1       3             2
data                             1       3             2
data                             1       4             2
0 state slots, 0 procedures, 3 tables
"""


def test_budget_as_text(capsys: pytest.CaptureFixture[str]) -> None:
    assert ends(capsys, 0, "budget", TABLES)[0] == TABLES_BUDGET


def test_instances_of_equal_cost_are_one_line(capsys: pytest.CaptureFixture[str], here: Path) -> None:
    out, _ = ends(capsys, 0, "budget", str(GOOD / "folds" / "main.yaml"), "--depth", "1")
    lines = [" ".join(line.split()) for line in out.splitlines()]
    assert any(line.startswith("forwards[0..2] 6") and line.endswith("3 x 2") for line in lines), out
    assert any(line.startswith("backwards[0..2]") for line in lines), out
    assert any(line.startswith("numbered[1..2] 2") for line in lines), out  # instance 0 adds a zero: nothing to do


def test_small_parts_are_told_together(capsys: pytest.CaptureFixture[str]) -> None:
    out, _ = ends(capsys, 0, "budget", "cmhe_fte", "--depth", "1")
    assert re.search(r"^  \d+ small parts +\d+", out, re.M), out
    rows = re.findall(r"^  (\S.*?) {2,}([\d ]+?) +\d+\.\d %", out, re.M)
    total = int(re.match(r"cmhe_fte: ([\d ]+?) operations", out)[1].replace(" ", ""))  # type: ignore[index]
    assert sum(int(number.replace(" ", "")) for _, number in rows) == total
    everything, _ = ends(capsys, 0, "budget", "cmhe_fte", "--depth", "1", "--all")
    assert "small parts" not in everything and len(everything) > len(out)


def test_the_tree_adds_up(capsys: pytest.CaptureFixture[str]) -> None:
    answer = json.loads(ends(capsys, 0, "budget", "inverse_8x8", "--json")[0])
    assert answer["operations"] == sum(answer["tree"]["kinds"].values())
    assert answer["operations"] == sum(part["operations"] for part in answer["tree"]["parts"])
    assert answer["over"] is False and answer["diagnoses"] == []


def test_an_unknown_target_is_refused(capsys: pytest.CaptureFixture[str]) -> None:
    _, err = ends(capsys, 2, "budget", LAG, "--target", "ppc755")
    assert "error[E608]: there is no target `ppc755`" in err


STAGES = {
    "sheet": "gain = 0.5\n",
    "netlist": "change: real scalar = add(u, before)  # line 9\n",
    "schedule": "  before: real scalar = delay(y)  # line 12\n  change: real scalar = add(u, before)  # line 9\n",
    "program": "  v2 = subtract v0 v1   # change, first_order_lag.yaml:9\n",
    "python": "v4 = (s0+(k0*(v0-s0)))\n",
}

PROGRAM = """\
frame program of first_order_lag, reals of 64 bits
  input  u: real scalar = v0
  state  s0: before, element 0, age 0, starts at 0.0

frame, every 1 from 0
  v1 = read s0          # before, first_order_lag.yaml:12
  v2 = subtract v0 v1   # change, first_order_lag.yaml:9
  v3 = multiply 0.5 v2  # step, first_order_lag.yaml:10
  v4 = add v1 v3        # y, first_order_lag.yaml:11
  write s0 = v4         # before, first_order_lag.yaml:12

  output y: real scalar = v4
"""


@pytest.mark.parametrize("stage", list(STAGES))
def test_every_stage_can_be_shown(capsys: pytest.CaptureFixture[str], stage: str) -> None:
    out, _ = ends(capsys, 0, "show", LAG, "--stage", stage)
    assert STAGES[stage] in out, out
    answer = json.loads(ends(capsys, 0, "show", LAG, "--stage", stage, "--json")[0])
    assert answer["text"] + "\n" == out
    ends(capsys, 0, "show", "inverse_8x8", "--stage", stage)


def test_the_program_is_readable(capsys: pytest.CaptureFixture[str]) -> None:
    assert ends(capsys, 0, "show", LAG, "--stage", "program")[0] == PROGRAM
    _, err = ends(capsys, 2, "show", LAG, "--stage", "programme")
    assert "did you mean `program`?" in err


def test_symbols_are_listed_with_what_they_cost(capsys: pytest.CaptureFixture[str]) -> None:
    from saoflow.blocks.library import SYMBOLS

    answer = json.loads(ends(capsys, 0, "symbols", "--json")[0])
    by_name = {entry["name"]: entry for entry in answer["symbols"]}
    assert list(by_name) == list(SYMBOLS)
    costs = {e["text"]: e["cost"] for entry in by_name.values() for e in entry["examples"]}
    assert costs["{add: [x, y, -z]}"] == "1 add, 1 subtract"
    assert costs["{mul: [A, B], product: matrix}"] == "4 add, 8 multiply"
    assert costs['{inv2: "[[x, 0], [0, 1]]"}'] == "1 multiply, 1 reciprocal"
    assert json.loads(ends(capsys, 0, "budget", "reciprocal", "--json")[0])["tree"]["kinds"] == {"reciprocal": 1}
    assert costs["{lookup: x, breakpoints: [0, 1, 3], values: [5, 6, 6.5]}"] == "1 lookup (3 points, 2 search steps)"
    assert costs["{delay: v, frames: 2}"] == "6 state slots"
    assert all(
        costs[e["text"]] == "free" for n in ("select", "concatenate", "transpose") for e in by_name[n]["examples"]
    )
    assert {"reciprocal", "window_rms", "inverse_8x8"} <= {sheet["name"] for sheet in answer["sheets"]}
    listed, _ = ends(capsys, 0, "symbols")
    for name in by_name:
        assert re.search(rf"^{name} ", listed, re.M), name
        assert by_name[name]["equation"] in ends(capsys, 0, "symbols", name)[0]
    assert "The library sheet" not in ends(capsys, 0, "symbols", "window_rms")[0]
    assert "did you mean `saturation`?" in ends(capsys, 2, "symbols", "saturate")[1]


# -- what would be ignored or misnamed in silence is refused


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (("view", LAG, "-o", "lag.svg"), "add --svg for a picture"),
        (("view", LAG, "-o", "lag.pdf"), "write lag.html"),
        (("view", LAG, "--svg", "-o", "lag.html"), "write lag.svg"),
        (("budget", LAG, "--report", "lag.yaml"), "write lag.html"),
        (("run", LAG, "in.csv", "-o", "out.csv", "--report", "lag.yaml"), "write lag.html"),
        (("budget", LAG, "--markdown"), "add --vs SHEET"),
        (("schema", "-o", "/"), "E601"),
        (("new", "add"), "such as my_add"),
        (("new", "a" * 65), "names have at most 64"),
        (("check", "nowhere"), "shipped estimators: cmhe_fte, "),
    ],
)
def test_an_answer_of_another_kind_is_refused(
    arguments: tuple[str, ...], told: str, here: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    Path("lag.yaml").write_text("mine", encoding="utf-8")
    assert told in ends(capsys, 2, *arguments)[1]
    assert os.listdir() == ["lag.yaml"] and Path("lag.yaml").read_text(encoding="utf-8") == "mine"


def test_a_comparison_writes_the_report_and_tells_the_cost_too(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out, _ = ends(capsys, 0, "budget", LAG, "--vs", LAG, "--report", "page.html", "--target", "mpc755")
    assert Path("page.html").exists() and "on mpc755" in out
    out, _ = ends(capsys, 0, "budget", LAG, "--vs", LAG, "--target", "mpc755", "--json")
    assert json.loads(out)["target"]["target"]
