"""The command ``saoflow demo``."""

from __future__ import annotations

import json as json_text
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from rich.progress import Progress, TaskID

    from verification.demo import DemoResult


def demo(
    output: Annotated[str, typer.Option("-o", "--output", metavar="FOLDER", help="Folder for the files.")] = "out",
    seed: Annotated[int, typer.Option("--seed", help="Of the sensor noise.")] = 1,
    json: Annotated[bool, typer.Option("--json", help="Machine-readable result.")] = False,
) -> None:
    """Fly the flagship through a triple airspeed failure, from YAML to a report.

    An A320 at 350 kt, 5000 ft; three airspeed sensors run away at -15 kt/s from t = 20 s (Fig. 4 of the paper). The
    sheets cmhe_fte and umhe_fte are read, checked, held against their budgets and flown; their numpy references run
    beside them. Writes report.html, estimates.csv and recording.csv. Exit code 1 if anything claimed does not hold.

    Example: saoflow demo -o out
    """
    from saoflow import DiagnosisError

    try:
        result, files = _demo(output, seed)
    except DiagnosisError as error:
        if json:
            typer.echo(json_text.dumps({"diagnoses": [d.to_dict() for d in error.diagnoses]}, indent=1))
        else:
            typer.echo(str(error), err=True)
        over = {d.code for d in error.diagnoses} == {"E401"}
        raise typer.Exit(1 if over else 2) from None
    if json:
        from verification.demo.facts import to_dict

        typer.echo(json_text.dumps(to_dict(result, files), indent=1))
    else:
        from verification.demo.summary import print_summary

        print_summary(result, files)
    if not result.holds:
        raise typer.Exit(1)


def _demo(folder: str, seed: int) -> tuple[DemoResult, tuple[str, ...]]:
    """Run with progress on standard error: a bar a stage."""
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn, TimeElapsedColumn

    from verification.demo import Scenario, run_demo, write_files
    from verification.demo.files import prepare

    prepare(folder)
    columns = (TextColumn("{task.description:<34}"), BarColumn(32), TaskProgressColumn(), TimeElapsedColumn())
    with Progress(*columns, console=Console(stderr=True)) as bars:
        stages = _Stages(bars)
        result = run_demo(Scenario(seed=seed), stages)
        files = write_files(result, folder, lambda share: stages("report drawn and written", round(1000 * share), 1000))
    return result, files


class _Stages:
    """A bar for each stage, made when the stage begins."""

    def __init__(self, bars: Progress) -> None:
        self._bars = bars
        self._tasks: dict[str, TaskID] = {}

    def __call__(self, stage: str, done: int, total: int) -> None:
        if stage not in self._tasks:
            self._tasks[stage] = self._bars.add_task(stage, total=total)
        self._bars.update(self._tasks[stage], completed=done)
