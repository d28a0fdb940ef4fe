"""The command ``saoflow fly``."""

from __future__ import annotations

import json as json_text
from functools import partial
from typing import Annotated

import typer

from saoflow.commands.shell import Findings, finish
from saoflow.diagnosis import Diagnosis


def fly(
    output: Annotated[
        str | None,
        typer.Option("-o", "--output", help="File to write: .csv, .csv.gz or .parquet.", show_default=False),
    ] = None,
    flight: Annotated[
        str, typer.Option("--flight", help="Name of the flight; --list shows all.")
    ] = "a320_calm_350kt_5000ft",
    aircraft: Annotated[
        str | None, typer.Option("--aircraft", help="A320 or 787-8, instead of the flight's own.")
    ] = None,
    seed: Annotated[
        int | None, typer.Option("--seed", help="Of turbulence and noise, instead of the flight's own.")
    ] = None,
    noise: Annotated[bool, typer.Option("--noise", help="Add sensor noise.")] = False,
    fault: Annotated[
        list[str] | None,
        typer.Option("--fault", metavar="FAULT", help="Add a fault, see above; repeatable."),
    ] = None,
    missing: Annotated[
        list[str] | None,
        typer.Option("--missing", metavar="GAP", help="Let samples be missing, see above; repeatable."),
    ] = None,
    show_list: Annotated[bool, typer.Option("--list", help="List the flights and end.")] = False,
    json: Annotated[bool, typer.Option("--json", help="Machine-readable result.")] = False,
) -> None:
    """Record a flight with JSBSim: inputs of the estimator, and the truth beside them.

    A fault is SENSOR:KIND[:VALUE][:onset=S][:sensors=1,2,3][:frequency=HZ]: SENSOR alpha or vc; KIND bias,
    jamming, oscillation, runaway, non_return_to_zero or noise; VALUE in deg or kt (runaway: deg/s or kt/s).
    Missing samples are INPUT[,INPUT...]:frames=N[:onset=S][:value=nan|inf|-inf].

    Example: saoflow fly --noise --fault vc:runaway:-15:onset=20 -o flight.csv
    """
    if show_list:
        _list(json)
        return
    findings = Findings()
    findings.attempt(lambda: _fly(findings, output, flight, aircraft, seed, noise, fault or [], missing or [], json))
    if findings.errors:
        finish(findings.found, json)


def _fly(
    findings: Findings,
    output: str | None,
    flight: str,
    aircraft: str | None,
    seed: int | None,
    noise: bool,
    faults: list[str],
    gaps: list[str],
    json: bool,
) -> None:
    """Flies; finds everything that is wrong with the request, and then does not fly."""
    from rich.console import Console
    from rich.progress import Progress

    from saoflow.recordings import check_output
    from verification.flights.catalogue import find_flight
    from verification.flights.fault_text import parse_fault, parse_missing
    from verification.flights.fly import check_onsets, fly_plan, summary

    attempt = findings.attempt
    plan = attempt(lambda: find_flight(flight, aircraft, seed))
    parsed = [attempt(partial(parse_fault, text)) for text in faults]
    missing = [attempt(partial(parse_missing, text)) for text in gaps]
    if output is None:
        findings.add(NO_OUTPUT)
    else:
        attempt(partial(check_output, output))
    if plan is not None:
        for event in (*parsed, *missing):
            attempt(partial(check_onsets, plan, [event] if event else []))
    if findings.errors or plan is None or output is None:
        return
    with Progress(console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task(f"flying {flight}", total=1.0)
        recording = fly_plan(
            plan,
            noise,
            [fault for fault in parsed if fault],
            output,
            [gap for gap in missing if gap],
            lambda done: bar.update(task, completed=done),
        )
    if json:
        facts = {"output": output, "flight": flight, "frames": len(recording), "columns": list(recording.names)}
        typer.echo(json_text.dumps(facts, indent=1))
    else:
        typer.echo(summary(recording, output))


NO_OUTPUT = Diagnosis(
    "E609",
    "no file to write",
    cause="the option -o is missing",
    remedy="add -o flight.csv, or another path that ends in .csv, .csv.gz or .parquet",
)


def _list(json: bool) -> None:
    from verification.flights.catalogue import FLIGHTS

    if json:
        facts = [
            {"name": p.name, "aircraft": p.aircraft, "duration_s": p.duration_s, "seed": p.seed, "doc": p.doc}
            for p in FLIGHTS
        ]
        typer.echo(json_text.dumps(facts, indent=1))
        return
    for plan in FLIGHTS:
        typer.echo(f"{plan.name:<32} {plan.duration_s:5.0f} s  {plan.doc}")
