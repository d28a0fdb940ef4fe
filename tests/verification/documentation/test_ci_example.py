"""docs/ci_example.yml: the job runs, and fails when a change takes a sheet over its budget."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import pytest
import yaml

from verification.documentation.commands import prepare, run
from verification.documentation.shown_commands import ROOT

JOB = yaml.safe_load((ROOT / "docs" / "ci_example.yml").read_text(encoding="utf-8"))["frame-budget"]
INSTALLS = "pip install saoflow"
SHEET = """\
sheet: estimator
inputs: [u]
blocks:
  y: {mul: [u, 2]}
outputs: [y]
budget: {operations: 2, period: 0.05}
"""
DEARER = SHEET.replace("{mul: [u, 2]}", "{mul: [u, u, u, 2]}")

pytestmark = pytest.mark.skipif(shutil.which("git") is None or shutil.which("bash") is None, reason="needs git and bash")


@pytest.fixture
def checkout(tmp_path: Path) -> Path:
    """A clone with a branch for a merge request; its origin's main has the sheet as it was."""
    prepare(tmp_path, ROOT / "docs" / "view.md")  # the programs on the path
    typed = (
        "git init -q -b main origin && cd origin && git config user.name a && git config user.email a@b"
        " && mkdir sheets && cp ../sheet.yaml sheets/estimator.yaml && git add . && git commit -q -m first"
        " && cd .. && git clone -q origin clone"
    )
    (tmp_path / "sheet.yaml").write_text(SHEET, encoding="utf-8")
    done = run(typed, tmp_path)
    assert done.returncode == 0, done.stderr
    return tmp_path


def job(checkout: Path, shell: str) -> subprocess.CompletedProcess[str]:
    """The script, but for the installation, in the shell that the service gives it."""
    script = [line for line in JOB["script"] if line != INSTALLS]
    assert len(script) == len(JOB["script"]) - 1
    (checkout / "job.sh").write_text("\n".join(script) + "\n", encoding="utf-8")
    return run(f"cd clone && CI_MERGE_REQUEST_TARGET_BRANCH_NAME=main bash {shell} ../job.sh", checkout)


def test_the_job_passes_then_fails_over_budget(checkout: Path) -> None:
    clone = checkout / "clone"
    done = job(checkout, "-eo pipefail")  # as GitLab calls it
    assert done.returncode == 0, done.stderr
    assert [path for path in JOB["artifacts"]["paths"] if not (clone / path).is_file()] == []
    (clone / "sheets" / "estimator.yaml").write_text(DEARER, encoding="utf-8")
    for shell in ("-eo pipefail", "-e"):  # the second: as GitHub does
        done = job(checkout, shell)
        assert done.returncode == 1, done.stderr
    shown = (clone / "budget.md").read_text(encoding="utf-8")
    assert "3 operations a frame of 2" in shown and "multiply" in shown
