"""The command ``saoflow campaign``."""

from __future__ import annotations

import time
from dataclasses import replace
from typing import TYPE_CHECKING, Annotated

import typer

from saoflow.commands.shell import BAD_INPUT, FAILED, Findings, Json, Set, finish, parse_settings, tell
from saoflow.diagnosis import Diagnosis, DiagnosisError
from verification.commands.progress import stages

if TYPE_CHECKING:
    from verification.campaigns.plan import Campaign
    from verification.campaigns.run import Outcome

INTERRUPTED = 130


def campaign(
    name: Annotated[
        str | None,
        typer.Argument(
            metavar="FILE", help="A campaign's YAML file, or the name of a shipped one.", show_default=False
        ),
    ] = None,
    output: Annotated[
        str | None, typer.Option("-o", "--output", metavar="DIR", help="Folder of the results.", show_default=False)
    ] = None,
    workers: Annotated[
        int | None,
        typer.Option("--workers", metavar="N", help="Processes; one a core if left out.", show_default=False),
    ] = None,
    dask: Annotated[
        str | None, typer.Option("--dask", metavar="ADDRESS", help="A Dask scheduler to run on.", show_default=False)
    ] = None,
    settings: Set = None,
    show_list: Annotated[bool, typer.Option("--list", help="List the shipped campaigns and end.")] = False,
    json: Json = False,
) -> None:
    """Fly many flights with and without faults through sheets, and tell false alarms, misses, delays and errors.

    Results come into DIR as Parquet; a campaign that was stopped or killed goes on when it is called again, and ends
    with the same bytes. Writes results.parquet (a row a run), report.html, .png, .md and .json. Exit code 1 if a run
    failed.

    Example: saoflow campaign table_iv -o out/table_iv

    Example: saoflow campaign monte_carlo -o out/monte_carlo --workers 2
    """
    if show_list:
        _list(json)
        return
    findings = Findings()
    plan = _plan(name, settings, findings)
    if output is None:
        findings.add(_no_folder())
    if workers is not None and workers < 1:
        findings.add(
            Diagnosis(
                "E603", f"`--workers` cannot be {workers}", cause="work needs a process", remedy="write --workers 2"
            )
        )
    if findings.errors or plan is None or output is None:
        finish(findings.found, json)
        raise typer.Exit(BAD_INPUT)
    _run(plan, output, workers, dask, findings, json)


def _plan(name: str | None, settings: list[str] | None, findings: Findings) -> Campaign | None:
    """The campaign, its sheets with the parameters of ``--set``."""
    from verification.campaigns.reader import load_campaign, shipped_campaigns

    parse_settings(settings or (), findings)
    if name is None:
        shipped = ", ".join(shipped_campaigns())
        findings.add(
            Diagnosis(
                "E609", "no campaign is named", cause="FILE is missing", remedy=f"name a file, or one of {shipped}"
            )
        )
        return None
    plan = findings.attempt(lambda: load_campaign(name))
    if plan is None or findings.errors:
        return None
    pairs = {key.strip(): value.strip() for key, _, value in (text.partition("=") for text in settings or ())}
    sheets = (replace(v, settings=tuple({**dict(v.settings), **pairs}.items())) for v in plan.sheets)
    return replace(plan, sheets=tuple(dict.fromkeys(sheets)))


def _run(plan: Campaign, output: str, workers: int | None, dask: str | None, findings: Findings, json: bool) -> None:
    from verification.campaigns.report import json_of, write_report
    from verification.campaigns.run import run_campaign

    start = time.monotonic()
    try:
        with stages() as progress:
            outcome = run_campaign(plan, output, workers, dask, progress)
        metrics, files = write_report(plan, outcome.results)
    except DiagnosisError as error:
        findings.extend(error.diagnoses)
        finish(findings.found, json)
        raise typer.Exit(BAD_INPUT) from None
    except KeyboardInterrupt:
        typer.echo(
            f"stopped; what has been flown is kept in {output}, and the same command goes on from there", err=True
        )
        raise typer.Exit(INTERRUPTED) from None
    findings.extend(outcome.warnings)
    if json:
        tell(findings.found)
        typer.echo(json_of(plan, metrics), nl=False)
    else:
        from saoflow.commands.shell import console
        from verification.campaigns.tables import print_tables

        print_tables(metrics, console())
        tell(findings.found)
        typer.echo(_summary(outcome, time.monotonic() - start))
        typer.echo(f"written: {outcome.results}, {', '.join(map(str, files))}")
    if any(sheet.failures for sheet in metrics):
        raise typer.Exit(FAILED)


def _summary(outcome: Outcome, seconds: float) -> str:
    there = outcome.runs - outcome.flown
    before = f", {there} were there" if there else ""
    return f"{outcome.runs} runs: {outcome.flown} flown in {seconds:.1f} s{before}"


def _no_folder() -> Diagnosis:
    return Diagnosis("E609", "no folder to write", cause="the option -o is missing", remedy="add -o out/campaign")


def _list(json: bool) -> None:
    import json as json_text

    from verification.campaigns.reader import load_campaign, shipped_campaigns

    plans = [load_campaign(name) for name in shipped_campaigns()]
    if json:
        facts = [{"name": p.name, "runs": p.total, "doc": p.doc} for p in plans]
        typer.echo(json_text.dumps(facts, indent=1))
        return
    for plan in plans:
        typer.echo(f"{plan.name:<14} {plan.total:6d} runs  {plan.doc}")
