"""The command ``saoflow compare``."""

from __future__ import annotations

import json as json_text
from typing import TYPE_CHECKING, Annotated

import typer

from saoflow.commands.shell import BAD_INPUT, FAILED, Findings, Json, console, finish, tell
from saoflow.diagnosis import Diagnosis
from verification.commands.progress import stages

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    from verification.campaigns.plan import Campaign, Variant
    from verification.comparison.compare import Comparison

INTERRUPTED = 130


def compare(
    sheets: Annotated[
        list[str] | None,
        typer.Argument(metavar="SHEET...", help="Sheets, or variants: cmhe_fte[n_QP=1..4].", show_default=False),
    ] = None,
    campaign: Annotated[
        str, typer.Option("--campaign", metavar="FILE", help="The flights: a campaign's file or shipped name.")
    ] = "comparison",
    budget: Annotated[
        float | None,
        typer.Option("--budget", metavar="OPS", help="Operations a frame; else each sheet's own.", show_default=False),
    ] = None,
    output: Annotated[
        str | None,
        typer.Option(
            "-o", "--output", metavar="FILE", help="Page (.html), picture (.png) or table (.md).", show_default=False
        ),
    ] = None,
    runs: Annotated[
        str | None,
        typer.Option("--runs", metavar="DIR", help="Keep the runs here, and go on from them.", show_default=False),
    ] = None,
    workers: Annotated[
        int | None,
        typer.Option("--workers", metavar="N", help="Processes; one a core if left out.", show_default=False),
    ] = None,
    json: Json = False,
) -> None:
    """Fly sheets and variants of them on the same flights; accuracy and detection against operations and time a frame.

    A variant names values of parameters: [n_QP=1..4] is four of them, [n_QP=1|3, N=2..4] every one with every other.
    One over its budget is compared, too, and marked.

    Example: saoflow compare cmhe_fte cmhe_fte_lean umhe_fte -o out/compare.html

    Example: saoflow compare "cmhe_fte[n_QP=1..4]" --budget 19500 -o out/compare.html
    """
    findings = Findings()
    variants = _variants(sheets, findings)
    plan = _plan(campaign, findings)
    path = _path(output, findings)
    if budget is not None and not 0.0 < budget < float("inf"):
        findings.add(
            Diagnosis(
                "E603",
                f"`--budget` cannot be {budget:g}",
                cause="it is operations a frame",
                remedy="write --budget 19500",
            )
        )
    if workers is not None and workers < 1:
        findings.add(
            Diagnosis(
                "E603", f"`--workers` cannot be {workers}", cause="work needs a process", remedy="write --workers 2"
            )
        )
    if findings.errors or variants is None or plan is None:
        finish(findings.found, json)
        raise typer.Exit(BAD_INPUT)
    comparison = _compare(variants, plan, budget, workers, runs, findings, json)
    _tell(comparison, path, findings, json)


def _variants(sheets: list[str] | None, findings: Findings) -> Sequence[Variant] | None:
    from verification.comparison.variants import SYNTAX, parse_variants

    if not sheets:
        findings.add(Diagnosis("E609", "no sheet is named", cause="SHEET is missing", remedy=f"write {SYNTAX}"))
        return None
    return findings.attempt(lambda: parse_variants(sheets))


def _plan(name: str, findings: Findings) -> Campaign | None:
    from verification.campaigns.reader import load_campaign

    return findings.attempt(lambda: load_campaign(name))


def _path(output: str | None, findings: Findings) -> Path | None:
    from verification.comparison.files import check_output

    return None if output is None else findings.attempt(lambda: check_output(output))


def _compare(
    variants: Sequence[Variant],
    plan: Campaign,
    budget: float | None,
    workers: int | None,
    runs: str | None,
    findings: Findings,
    json: bool,
) -> Comparison:
    from verification.comparison.compare import compare as compared

    try:
        with stages() as progress:
            found = findings.attempt(lambda: compared(variants, plan, budget, workers, runs, progress))
    except KeyboardInterrupt:
        kept = f"what has been flown is kept in {runs}" if runs else "nothing is kept without --runs"
        typer.echo(f"stopped; {kept}", err=True)
        raise typer.Exit(INTERRUPTED) from None
    if found is None:
        finish(findings.found, json)
        raise typer.Exit(BAD_INPUT)
    return found


def _tell(comparison: Comparison, path: Path | None, findings: Findings, json: bool) -> None:
    from verification.campaigns.tables import print_table
    from verification.comparison.files import write
    from verification.comparison.tables import table_of

    findings.extend(comparison.warnings)
    if path is not None:
        findings.attempt(lambda: write(comparison, path))
    if json:
        typer.echo(json_text.dumps(comparison.to_dict(), indent=1, allow_nan=False))
    else:
        print_table(table_of(comparison), console(width=160))
    tell(findings.found)
    if findings.errors:
        raise typer.Exit(BAD_INPUT)
    if path is not None and not json:
        typer.echo(f"written: {path}")
    if any(entry.failed for entry in comparison.entries):
        raise typer.Exit(FAILED)
