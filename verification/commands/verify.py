"""The command ``saoflow verify``."""

from __future__ import annotations

import json as json_text
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from verification.verifier.report import Report


def verify(
    sheet: Annotated[str, typer.Argument(metavar="SHEET", help="Path of a sheet, or the name of a shipped one.")],
    frames: Annotated[int, typer.Option("--frames", help="How many frames to compare.")] = 10_000,
    seed: Annotated[int, typer.Option("--seed", help="Of noise, faults and missing samples.")] = 1,
    reference: Annotated[
        str | None,
        typer.Option("--reference", metavar="MODULE:NAME", help="The numpy reference.", show_default=False),
    ] = None,
    json: Annotated[bool, typer.Option("--json", help="Machine-readable result.")] = False,
) -> None:
    """Compare a sheet with its numpy reference, frame by frame from the same state.

    The reference is found by the sheet's name; your own is a function from a dictionary of input arrays (one row
    a frame) to one of output arrays, named with --reference. Exit code 1 if a check fails.

    Example: saoflow verify cmhe_fte --frames 600
    """
    from saoflow import DiagnosisError

    try:
        report = _verify(sheet, reference, frames, seed)
    except DiagnosisError as error:
        if json:
            typer.echo(json_text.dumps({"diagnoses": [d.to_dict() for d in error.diagnoses]}, indent=1))
        else:
            typer.echo(str(error), err=True)
        raise typer.Exit(2) from None
    if json:
        typer.echo(json_text.dumps(report.to_dict(), indent=1))
    else:
        from rich.console import Console

        from verification.verifier.printing import print_report

        print_report(report, Console())
    if not report.passed:
        raise typer.Exit(1)


def _verify(sheet: str, reference: str | None, frames: int, seed: int) -> Report:
    """Verify with a progress bar on the terminal's standard error."""
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn, TimeRemainingColumn

    from verification.verifier import verify as run_verification

    columns = (TextColumn("{task.description}"), BarColumn(), TaskProgressColumn(), TimeRemainingColumn())
    console = Console(stderr=True)
    with Progress(*columns, console=console, transient=True, disable=not console.is_terminal) as bar:
        task = bar.add_task(f"verifying {sheet}", total=1.0)

        def show(what: str, done: float) -> None:
            bar.update(task, completed=done, description=f"verifying {sheet}, {what}")

        return run_verification(sheet, reference, frames=frames, seed=seed, progress=show)
