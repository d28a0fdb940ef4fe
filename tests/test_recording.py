"""Recordings: what is written comes back to the bit, what is broken is told with its place, nothing is half-written."""

from __future__ import annotations

import csv
import gzip
import os
import sys
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from saoflow import DiagnosisError
from saoflow.recordings import check_output, column_names, output_columns, read_frames, read_table, table, write_table
from saoflow.wires import WireType

SCALAR, VECTOR, MATRIX, FLAG = WireType(), WireType((2,)), WireType((2, 2)), WireType((), True)
AWKWARD = np.array([0.1 + 0.2, 1e-320, -0.0, 1.7976931348623157e308, 2.0**-1074, 1 / 3, np.inf, -np.inf, np.nan, 5.0])


def refused(do: Callable[[], object]) -> str:
    with pytest.raises(DiagnosisError) as caught:
        do()
    return str(caught.value)


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_columns_are_named_as_the_interface_says() -> None:
    assert column_names("vg", ()) == ["vg"]
    assert column_names("alpha", (3,)) == ["alpha_1", "alpha_2", "alpha_3"]
    assert column_names("P", (2, 2)) == ["P_1_1", "P_1_2", "P_2_1", "P_2_2"]


@pytest.mark.parametrize("name", ["x.csv", "x.csv.gz", "x.parquet"])
def test_every_bit_comes_back(here: Path, name: str) -> None:
    write_table(name, {"a": AWKWARD, "b": -AWKWARD})
    table = read_table(name)
    assert table.names == ("a", "b")
    assert table["a"].tobytes() == AWKWARD.tobytes()
    assert os.listdir(here) == [name]


def test_a_file_is_what_the_csv_module_reads(here: Path) -> None:
    write_table(
        "x.csv", {"t": np.array([0.0, 0.048]), "flag": np.array([True, False]), 'odd, "name"': np.array([1.5, np.nan])}
    )
    with open("x.csv", newline="") as file:
        assert list(csv.reader(file)) == [["t", "flag", 'odd, "name"'], ["0.0", "1", "1.5"], ["0.048", "0", "nan"]]


def test_the_same_columns_give_the_same_bytes(here: Path) -> None:
    for name in ("a.csv.gz", "b.csv.gz"):
        write_table(name, {"x": AWKWARD})
    assert Path("a.csv.gz").read_bytes() == Path("b.csv.gz").read_bytes()


def test_ports_are_gathered_and_further_columns_ignored(here: Path) -> None:
    Path("x.csv").write_text(
        'note,P_1_1,P_1_2,t,P_2_1,P_2_2,v_2,v_1,s,on\nhello,1,2,0.5,3,4,6,5,7,1\n"a, b",8,9,1,10,11,13,12,14,0\n'
    )
    frames = read_frames("x.csv", {"s": SCALAR, "v": VECTOR, "P": MATRIX, "on": FLAG})
    assert frames.count == 2 and not frames.missing and not frames.warnings
    assert frames.t is not None and frames.t.tolist() == [0.5, 1.0]
    assert frames.inputs["s"].tolist() == [7, 14]
    assert frames.inputs["v"].tolist() == [[5, 6], [12, 13]]
    assert frames.inputs["P"].tolist() == [[[1, 2], [3, 4]], [[8, 9], [10, 11]]]
    assert frames.inputs["on"].tolist() == [1, 0]


@pytest.mark.parametrize(
    "text",
    [
        "s\r\n1\r\n2\r\n",
        "\ufeffs\n1\n2\n",
        " s \n 1 \n+2\n",
        "s\n1\n2",
        "s\n1\n2\n\n\n",
        '"s"\n"1"\n"2"\n',
        "\ns\n1\n2\n",
    ],
)
def test_ordinary_variants_of_csv_are_read(here: Path, text: str) -> None:
    Path("x.csv").write_text(text, newline="")
    assert read_frames("x.csv", {"s": SCALAR}).inputs["s"].tolist() == [1, 2]


def test_missing_samples_run_and_are_counted(here: Path) -> None:
    Path("x.csv").write_text("s,v_1,v_2,on\n1,,2,1\nnan,inf,-Infinity,\n3,4,5,0\n")
    frames = read_frames("x.csv", {"s": SCALAR, "v": VECTOR, "on": FLAG})
    assert frames.missing == {"s": 1, "v_1": 2, "v_2": 1, "on": 1}
    np.testing.assert_array_equal(frames.inputs["v"], [[np.nan, 2], [np.inf, -np.inf], [4, 5]])
    assert frames.inputs["on"].tolist() == [1, 0, 0]
    (warning,) = frames.warnings
    assert warning.render() == (
        "x.csv:1:1: warning[W501]: 5 missing samples in 3 rows\n"
        "    = cause: not a finite number, or an empty cell: v_1 2, s 1, v_2 1, on 1\n"
        "    = remedy: none needed if the sheet is made for it: the samples go in as they are, an empty cell as NaN; "
        "a missing boolean is taken as 0"
    )


def test_missing_samples_of_parquet(here: Path) -> None:
    pyarrow = pytest.importorskip("pyarrow")
    pytest.importorskip("pyarrow.parquet")
    table = pyarrow.table({"s": [1, None, 3], "on": [True, False, None], "note": ["a", "b", "c"]})
    pyarrow.parquet.write_table(table, "x.parquet")
    frames = read_frames("x.parquet", {"s": SCALAR, "on": FLAG})
    assert frames.missing == {"s": 1, "on": 1}
    np.testing.assert_array_equal(frames.inputs["s"], [1, np.nan, 3])
    assert frames.inputs["on"].tolist() == [1, 0, 0]


# -- bad input, exact messages

MISSING = """\
x.csv:1:3: error[E502]: there is no column `v_1`
 1 | t,v1,v_2
   |   ^^
    = cause: input `v` is a vector of 2: columns v_1, v_2
    = remedy: did you mean `v1`? then rename it in the recording to `v_1`
x.csv:1:1: error[E502]: there is no column `s`
    = cause: input `s` is a scalar: one column of its name
    = remedy: add it; the recording has: t, v1, v_2
x.csv:1:1: error[E502]: there are no columns `w_1`, `w_2`
    = cause: input `w` is a vector of 2: columns w_1, w_2
    = remedy: add them; the recording has: t, v1, v_2"""

TEXT = """\
x.csv:3:3: error[E503]: `fast` in row 2 of column `v_1` is not a number
 3 | 0,fast,2
   |   ^^^^
    = cause: a cell is a number such as -1.5e-3
    = remedy: correct the cell; a missing sample is an empty cell or nan
x.csv:4:3: error[E503]: `1_000` in row 3 of column `v_1` is not a number
 4 | 0,1_000,2
   |   ^^^^^
    = cause: a cell is a number such as -1.5e-3
    = remedy: correct the cell; a missing sample is an empty cell or nan
x.csv:5:7: error[E503]: `0x10` in row 4 of column `v_2` is not a number
 5 | 0,"1",0x10
   |       ^^^^
    = cause: a cell is a number such as -1.5e-3
    = remedy: correct the cell; a missing sample is an empty cell or nan"""

LENGTHS = """\
x.csv:3:3: error[E505]: row 2 has 2 cells, the header 3
 3 | 0,1
   |   ^
    = cause: every row has one cell for each name of the header
    = remedy: drop the line, or fill in the cells; a missing sample is an empty cell
x.csv:4:7: error[E505]: row 3 has 4 cells, the header 3
 4 | 0,1,2,3
   |       ^
    = cause: every row has one cell for each name of the header
    = remedy: drop what is too much; numbers are written with a point, as 1.5"""

FLAGS = """\
x.csv:2:1: error[E503]: `2` in row 1 of column `on` is not 0 or 1
 2 | 2
   | ^
    = cause: the column is a boolean input: 0 or 1
    = remedy: correct the cell; a missing sample is an empty cell or nan
x.csv:3:1: error[E503]: `yes` in row 2 of column `on` is not 0 or 1
 3 | yes
   | ^^^
    = cause: the column is a boolean input: 0 or 1
    = remedy: correct the cell; a missing sample is an empty cell or nan"""

TWICE = """\
x.csv:1:5: error[E506]: column `s` is there 2 times
 1 | s,t,s
   |     ^
    = cause: column 3 has the name of column 1
    = remedy: rename or drop one of them"""

NO_ROWS = """\
x.csv:1:1: error[E504]: the recording has no rows
    = cause: there is only a header
    = remedy: give a header line with the names, and a row for each frame"""

EMPTY = """\
x.csv:1:1: error[E103]: the recording is empty
    = cause: {}
    = remedy: give a header line with the names, and a row for each frame"""

NO_HEADER = """\
x.csv:1:1: error[E502]: there is no column `s`
    = cause: the first line holds numbers, not the names of the columns
    = remedy: put a header line first: the names, separated by commas"""

SEMICOLONS = """\
x.csv:1:1: error[E502]: there is no column `s`
    = cause: the names in the first line are not separated by commas
    = remedy: save the file as CSV with commas"""

QUOTE = """\
x.csv:3:1: error[E501]: the recording cannot be read
 3 | "1
   | ^
    = cause: unexpected end of data: a quote is opened or closed in the wrong place, or a cell is enormous
    = remedy: mend the line; a quote inside a quoted cell is written twice"""


@pytest.mark.parametrize(
    ("text", "ports", "message"),
    [
        ("t,v1,v_2\n0,1,2\n", {"v": VECTOR, "s": SCALAR, "w": VECTOR}, MISSING),
        ('t,v_1,v_2\n0,1,2\n0,fast,2\n0,1_000,2\n0,"1",0x10\n', {"v": VECTOR}, TEXT),
        ("t,v_1,v_2\n0,1,2\n0,1\n0,1,2,3\n", {"v": VECTOR}, LENGTHS),
        ("on\n2\nyes\n1\n", {"on": FLAG}, FLAGS),
        ("s,t,s\n1,2,3\n", {"s": SCALAR}, TWICE),
        ("s\n", {"s": SCALAR}, NO_ROWS),
        ("s\n\n\n", {"s": SCALAR}, NO_ROWS),
        ("", {"s": SCALAR}, EMPTY.format("the file has no bytes")),
        ("\n\n", {"s": SCALAR}, EMPTY.format("the file has blank lines only")),
        ("1,2,3\n4,5,6\n", {"s": SCALAR}, NO_HEADER),
        ("t;s\n0;1\n", {"s": SCALAR}, SEMICOLONS),
        ('s\n1\n"1\n', {"s": SCALAR}, QUOTE),
    ],
    ids=[
        "missing", "text", "lengths", "flags", "twice", "no rows", "blank", "empty", "blank only", "no header",
        "semicolons", "quote",
    ],
)  # fmt: skip
def test_exact_messages(here: Path, text: str, ports: dict[str, WireType], message: str) -> None:
    Path("x.csv").write_text(text, newline="")
    assert refused(lambda: read_frames("x.csv", ports)) == message
    Path("x.csv.gz").write_bytes(gzip.compress(text.encode()))
    if text:
        packed = message.replace("x.csv:", "x.csv.gz:")
        assert refused(lambda: read_frames("x.csv.gz", ports)) == packed


def test_mistakes_of_every_kind_are_told_in_one_go_and_in_bounds(here: Path) -> None:
    Path("x.csv").write_text("s\n" + "bad\n" * 60_000)
    told = refused(lambda: read_frames("x.csv", {"s": SCALAR, "v": VECTOR}))
    assert told.count("error[E502]: there are no columns `v_1`, `v_2`") == 1
    assert told.count("is not a number") == 0  # columns are missing: cells are looked at when the header is right
    told = refused(lambda: read_frames("x.csv", {"s": SCALAR}))
    assert told.count("is not a number") == 50
    assert "59950 further mistakes are not shown" in told


@pytest.mark.parametrize(
    ("name", "content", "words"),
    [
        ("x.csv", b"\xff\xfes\x00", "holds a null character"),
        ("x.csv", b"s\n\xe9\n", "line 2 holds the byte 0xe9, which is not UTF-8 text"),
        ("x.csv.gz", b"no gzip", "it is not a whole gzip file"),
        ("x.csv.gz", gzip.compress(b"s\n1\n" * 1000, mtime=0)[:30], "it is not a whole gzip file"),
        ("x.parquet", b"no parquet at all", "it is not a Parquet file"),
        ("x.txt", b"s\n1\n", "the kind of file is not known by its extension"),
        ("x.csv", b's\n"' + b"x" * 200_000 + b'"\n', "a cell is enormous"),
    ],
    ids=["null", "latin", "no gzip", "cut gzip", "no parquet", "extension", "enormous"],
)
def test_what_cannot_be_read_is_refused(here: Path, name: str, content: bytes, words: str) -> None:
    Path(name).write_bytes(content)
    told = refused(lambda: read_frames(name, {"s": SCALAR}))
    assert words in told and "E501" in told and "remedy" in told


def test_missing_files_folders_and_bombs_are_refused(here: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    assert "there is no such file" in refused(lambda: read_table("none.csv"))
    Path("folder.csv").mkdir()
    assert "it is a folder" in refused(lambda: read_table("folder.csv"))
    monkeypatch.setattr(table, "MOST_BYTES", 100_000)
    Path("bomb.csv.gz").write_bytes(gzip.compress(b"s\n" + b"1\n" * 100_000))
    assert "error[E110]: the recording is too large" in refused(lambda: read_table("bomb.csv.gz"))


def test_parquet_without_numbers_and_without_pyarrow(here: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    pyarrow = pytest.importorskip("pyarrow")
    pytest.importorskip("pyarrow.parquet")
    pyarrow.parquet.write_table(pyarrow.table({"s": ["a"], "on": [2]}), "x.parquet")
    assert "error[E503]: column `s` does not hold numbers" in refused(lambda: read_frames("x.parquet", {"s": SCALAR}))
    assert "`2` in row 1 of column `on` is not 0 or 1" in refused(lambda: read_frames("x.parquet", {"on": FLAG}))
    assert "there is no column `z`" in refused(lambda: read_frames("x.parquet", {"z": SCALAR}))
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    for do in (lambda: read_table("x.parquet"), lambda: check_output("y.parquet")):
        told = refused(do)
        assert "error[E605]" in told and "pip install 'saoflow[parquet]'" in told


# -- writing


def test_a_carriage_return_alone_ends_no_line(here: Path) -> None:
    Path("mac.csv").write_bytes(b"u\r1\r2\r")
    told = refused(lambda: read_frames("mac.csv", {"u": WireType(())}))
    assert "error[E501]" in told and "save the file with line feeds" in told and "\r" not in told


def test_outputs_become_columns_with_t_first_and_flags_as_0_and_1() -> None:
    arrays = {"y": np.array([[1.0, 2.0], [3.0, 4.0]]), "on": np.array([0.0, 1.0])}
    columns = output_columns(arrays, {"y": VECTOR, "on": FLAG}, np.array([0.0, 0.5]))
    assert {name: column.tolist() for name, column in columns.items()} == {
        "t": [0.0, 0.5], "y_1": [1.0, 3.0], "y_2": [2.0, 4.0], "on": [0, 1],
    }  # fmt: skip
    assert columns["on"].dtype.kind == "i"
    ports = {"P": VECTOR, "P_1": SCALAR}
    told = refused(lambda: output_columns({"P": np.zeros((1, 2)), "P_1": np.zeros(1)}, ports))
    assert "error[E506]: `P` and `P_1` share the column `P_1`" in told


def test_outputs_that_cannot_be_written_are_refused_at_once(here: Path) -> None:
    Path("in.csv").write_text("s\n1\n")
    Path("folder.csv").mkdir()
    for name, words in (
        ("none/x.csv", "there is no folder `none`"),
        ("x.txt", "the kind of file is not known by its extension"),
        ("folder.csv", "it is a folder"),
        ("in.csv", "it is the recording that is read"),
        ("x" * 300 + ".csv", "too long"),
    ):
        told = refused(lambda name=name: check_output(name, "in.csv"))  # type: ignore[misc]
        assert "error[E601]" in told and words in told, told
    assert sorted(os.listdir(here)) == ["folder.csv", "in.csv"]


def test_a_failure_leaves_the_old_file_and_nothing_else(here: Path) -> None:
    write_table("x.csv", {"a": np.array([1.0])})

    def breaks(value: float) -> str:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        write_table("x.csv", {"a": np.array([2.0])}, breaks)
    assert os.listdir(here) == ["x.csv"]
    assert read_table("x.csv")["a"].tolist() == [1.0]


def test_reading_is_quick(here: Path) -> None:
    """100 000 rows of 20 columns in about a second; the bound leaves room for a busy machine."""
    rng = np.random.default_rng(1)
    write_table("x.csv", {f"v_{i + 1}": rng.normal(size=25_000) for i in range(20)})
    start = time.process_time()
    read_frames("x.csv", {"v": WireType((20,))})
    assert time.process_time() - start < 1.5
