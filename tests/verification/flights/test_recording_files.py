"""Recordings in files: what is written comes back, what is broken is diagnosed, nothing is half-written."""

import csv
import gzip
import os
import subprocess
import sys

import numpy as np
import pytest

from saoflow import DiagnosisError
from verification.flights import Recording
from verification.recordings import FOLDER, load_recording, read_recording, shipped_recordings, write_recording

SMALL = Recording(("t", "vg"), (np.array([0.0, 0.048]), np.array([374.628449, np.nan])))


@pytest.mark.parametrize("name", ["x.csv", "x.csv.gz"])
def test_csv_round_trip(tmp_path, name):
    whole = load_recording("a320_slow_190kt_3000ft")
    write_recording(whole, tmp_path / name)
    back = read_recording(tmp_path / name)
    assert back.names == whole.names
    assert all((a == b).all() for a, b in zip(back.columns, whole.columns, strict=True))
    assert os.listdir(tmp_path) == [name]


def test_csv_is_read_alike_by_the_csv_module(tmp_path):
    write_recording(SMALL, tmp_path / "x.csv")
    with open(tmp_path / "x.csv", newline="") as file:
        assert list(csv.reader(file)) == [["t", "vg"], ["0", "374.628449"], ["0.048", "nan"]]


def test_parquet_is_read_alike_by_pyarrow(tmp_path):
    parquet = pytest.importorskip("pyarrow.parquet")
    whole = load_recording("a320_slow_190kt_3000ft")
    write_recording(whole, tmp_path / "x.parquet")
    table = parquet.read_table(tmp_path / "x.parquet")
    assert tuple(table.column_names) == whole.names
    assert (table["vg"].to_numpy() == whole["vg"]).all()


def test_the_same_recording_gives_the_same_file(tmp_path):
    for name in ("a.csv.gz", "b.csv.gz"):
        write_recording(SMALL, tmp_path / name)
    assert (tmp_path / "a.csv.gz").read_bytes() == (tmp_path / "b.csv.gz").read_bytes()


def test_shipped_files_are_small_and_need_neither_pyarrow_nor_jsbsim():
    assert sum((FOLDER / f"{name}.csv.gz").stat().st_size for name in shipped_recordings()) < 3_000_000
    code = (
        "import sys; sys.modules['pyarrow'] = sys.modules['jsbsim'] = None\n"
        "from verification.flights import load_recording, sensors, shipped_recordings\n"
        "print(sum(len(sensors(load_recording(n), 1).inputs()['vg']) for n in shipped_recordings()))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert int(done.stdout) == sum(len(load_recording(name)) for name in shipped_recordings())


def test_columns_are_not_writable():
    with pytest.raises(ValueError, match="read-only"):
        load_recording("a320_calm_350kt_5000ft")["vg"][0] = 1.0


def test_part():
    whole = load_recording("a320_calm_350kt_5000ft")
    part = whole.part(4.8, 9.6)
    assert len(part) == 100
    assert (part["vg"] == whole["vg"][100:200]).all()


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"", "the recording is empty"),
        (b"t,vg\n", "the recording has no rows"),
        (b"t,vg\n0,1\n1\n", ":3:1: error[E505]: row 2 has 1 cell, the header 2"),
        (b"t,vg\n0,1\n1,fast\n", ":3:3: error[E503]: `fast` in row 2 of column `vg` is not a number"),
        (b"t,t\n0,1\n", "column `t` is there 2 times"),
        (b"\xff\xfe\x00", "cannot be read"),
    ],
)
def test_broken_files_are_diagnosed(tmp_path, content, message):
    path = tmp_path / "broken.csv"
    path.write_bytes(content)
    with pytest.raises(DiagnosisError) as caught:
        read_recording(path)
    assert message in str(caught.value)


def test_a_broken_gzip_file_and_a_missing_file_are_diagnosed(tmp_path):
    path = tmp_path / "broken.csv.gz"
    for content in (b"no gzip", gzip.compress(b"t,vg\n0,1\n" * 100)[:20]):
        path.write_bytes(content)
        with pytest.raises(DiagnosisError, match="cannot be read"):
            read_recording(path)
    with pytest.raises(DiagnosisError, match="cannot be read"):
        read_recording(tmp_path / "none.csv")


def test_unwritable_paths_are_diagnosed_and_leave_nothing(tmp_path):
    for path in (tmp_path / "no" / "x.csv", tmp_path / "x.txt", tmp_path):
        with pytest.raises(DiagnosisError) as caught:
            write_recording(SMALL, path)
        assert caught.value.diagnoses[0].code == "E601"
    (tmp_path / "x.csv").mkdir()
    with pytest.raises(DiagnosisError, match=r"x\.csv: cannot be written"):
        write_recording(SMALL, tmp_path / "x.csv")
    assert os.listdir(tmp_path) == ["x.csv"]


def test_parquet_without_pyarrow_names_the_extra(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    with pytest.raises(DiagnosisError) as caught:
        write_recording(SMALL, tmp_path / "x.parquet")
    assert "saoflow[parquet]" in str(caught.value)
    assert os.listdir(tmp_path) == []


def test_columns_that_do_not_fit_are_refused():
    for names, columns in (
        (("a", "b"), (np.zeros(2),)),
        (("a", "a"), (np.zeros(2), np.zeros(2))),
        (("a", "b"), (np.zeros(2), np.zeros(3))),
        (("a",), (np.zeros((2, 2)),)),
        (("a",), (np.zeros(0),)),
    ):
        with pytest.raises(DiagnosisError) as caught:
            Recording(names, columns)
        assert caught.value.diagnoses[0].code == "E725"
