"""What goes wrong with runs, chunks and processes: told by the run concerned, and by nothing else."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from small_campaign import SMALL, yaml_of

from saoflow import DiagnosisError
from verification.campaigns import work
from verification.campaigns.cases import Cases
from verification.campaigns.pool import spread
from verification.campaigns.summary import OUTPUTS


def test_what_is_not_finite_is_told_with_its_frame() -> None:
    flight = work._flight(SMALL, Cases(SMALL).case(4))
    frames = len(flight.truth)
    out = {name: np.zeros((frames, 3) if name.endswith(("faulty", "rms")) else frames) for name in OUTPUTS}
    assert work._row(flight, out).failure == ""
    out["vc_rms"][77, 2] = np.inf
    assert work._row(flight, out).failure == "`vc_rms` is not finite in frame 77"
    # frames that repeat the last one of a shorter flight do not count
    longer = {name: np.concatenate([values, values[-1:]]) for name, values in out.items()}
    longer["vc_rms"][77, 2] = 0.0
    longer["vc_hat"][-1] = np.nan
    assert work._row(flight, longer).failure == ""


class Narrow:
    """A simulator that has room for one flight at a time, and none for the one with this first reading."""

    def __init__(self, simulator, refused: float) -> None:
        self.simulator, self.refused = simulator, refused

    def reset(self) -> None:
        self.simulator.reset()

    def run(self, inputs):
        if len(inputs["vg"]) > 1 or inputs["vg"][0, 0] == self.refused:
            raise MemoryError
        return self.simulator.run(inputs)


def test_a_chunk_without_memory_is_flown_one_by_one(monkeypatch: pytest.MonkeyPatch) -> None:
    chunk = replace(Cases(SMALL).chunks[1], stop=7)
    expected = work.fly_chunk(SMALL, chunk)
    flights = [work._flight(SMALL, Cases(SMALL).case(i)) for i in range(3, 7)]
    refused = work.stacked_readings(flights[2:3])["vg"][0, 0]
    real = work.simulator_of(SMALL.sheets[0])
    monkeypatch.setattr(work, "simulator_of", lambda *_: Narrow(real, refused))
    rows = work.fly_chunk(SMALL, chunk)
    assert [row.failure for row in rows] == ["", "", "out of memory", ""]
    assert [repr(row) for i, row in enumerate(rows) if i != 2] == [
        repr(row) for i, row in enumerate(expected) if i != 2
    ]


def test_a_fault_after_the_end_is_told() -> None:
    late = replace(SMALL.runs[1].faults, onset=replace(SMALL.runs[1].faults.onset, low=11.9, high=13.0))
    plan = replace(SMALL, runs=(replace(SMALL.runs[1], count=8, faults=late),))
    (chunk,) = Cases(plan).chunks
    rows = work.fly_chunk(plan, chunk)
    told = {row.failure.split(";")[0] for row in rows if row.failure}
    assert told and all(text.startswith("E711: ") for text in told)


class Unloadable:
    """Kills the process that unpickles it."""

    def __call__(self, item: int) -> int:
        raise AssertionError

    def __reduce__(self):
        return os._exit, (1,)


def test_processes_that_do_not_start_are_told_as_such() -> None:
    with pytest.raises(DiagnosisError, match="E808"):
        list(spread(Unloadable(), range(5), 2, lambda item: item))


@pytest.mark.skipif(not Path("/proc/self/task").is_dir(), reason="needs /proc")
def test_workers_go_with_their_parent(tmp_path: Path) -> None:
    (tmp_path / "small.yaml").write_text(yaml_of(40, 60), encoding="utf-8")
    process = subprocess.Popen(
        [sys.executable, "-m", "saoflow.cli", "campaign", "small.yaml", "-o", "out", "--workers", "2"],
        cwd=tmp_path, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
    )  # fmt: skip
    while process.poll() is None and not list(tmp_path.glob("out/parts/*.parquet")):
        time.sleep(0.01)
    children = Path(f"/proc/{process.pid}/task/{process.pid}/children").read_text().split()
    process.send_signal(signal.SIGKILL)
    process.wait()
    assert len(children) >= 2
    deadline = time.monotonic() + 30.0
    while time.monotonic() < deadline and any(_alive(pid) for pid in children):
        time.sleep(0.05)
    assert not [pid for pid in children if _alive(pid)]


def _alive(pid: str) -> bool:
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False
