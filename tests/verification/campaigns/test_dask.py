"""A campaign on a real Dask cluster of processes, one of which is killed half-way."""

from __future__ import annotations

import os
import signal
from pathlib import Path

import pytest
from small_campaign import yaml_of

from saoflow import DiagnosisError
from verification.campaigns.reader import load_campaign
from verification.campaigns.run import run_campaign
from verification.campaigns.store import rows_of

distributed = pytest.importorskip("distributed", reason="needs saoflow[cluster]")


@pytest.fixture
def cluster():
    with distributed.LocalCluster(
        n_workers=2, threads_per_worker=2, processes=True, dashboard_address=None, silence_logs=50
    ) as made:
        yield made


def test_a_killed_worker_changes_nothing(cluster, tmp_path: Path) -> None:
    file = tmp_path / "small.yaml"
    file.write_text(yaml_of(12, 24), encoding="utf-8")
    plan = load_campaign(str(file))
    expected = run_campaign(plan, tmp_path / "here", workers=1).results.read_bytes()
    with distributed.Client(cluster.scheduler_address) as client:
        before = set(client.run(os.getpid).values())
    killed: list[int] = []

    def kill(stage: str, done: int, total: int) -> None:
        if stage == "flying" and 3 * done >= total and not killed:
            killed.append(next(iter(before)))
            os.kill(killed[0], signal.SIGKILL)

    outcome = run_campaign(plan, tmp_path / "there", dask=cluster.scheduler_address, progress=kill)
    assert killed
    assert not [row.failure for row in rows_of(outcome.results) if row.failure]
    assert outcome.results.read_bytes() == expected
    with distributed.Client(cluster.scheduler_address) as client:
        assert killed[0] not in client.run(os.getpid).values()


def test_no_cluster_there(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("verification.campaigns.cluster.PATIENCE", "200ms")
    file = tmp_path / "small.yaml"
    file.write_text(yaml_of(1, 2), encoding="utf-8")
    with pytest.raises(DiagnosisError, match="E806"):
        run_campaign(load_campaign(str(file)), tmp_path / "out", dask="tcp://127.0.0.1:9")
    assert not (tmp_path / "out").exists()
