"""The command ``saoflow fmu``."""

from __future__ import annotations

import sys
from contextlib import AbstractContextManager, nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from saoflow.commands.shell import (
    BAD_INPUT,
    Findings,
    Json,
    Set,
    SheetName,
    console,
    finish,
    load_sheet,
    one_of,
    tell,
)
from saoflow.diagnosis import Diagnosis

if TYPE_CHECKING:
    from saoflow.fmi import Unit


def fmu(
    name: SheetName,
    output: Annotated[
        str | None,
        typer.Option("-o", "--output", metavar="FILE.fmu", help="The unit; else NAME.fmu here.", show_default=False),
    ] = None,
    version: Annotated[int, typer.Option("--version", metavar="FMI", help="FMI 3 or 2.")] = 3,
    real: Annotated[int, typer.Option("--real", metavar="BITS", help="Reals of 64 or 32 bits.")] = 64,
    settings: Set = None,
    period: Annotated[
        float | None,
        typer.Option(
            "--period", metavar="S", help="Frame period, if the sheet's budget states none.", show_default=False
        ),
    ] = None,
    scalars: Annotated[
        bool, typer.Option("--scalars", help="Elements of vectors and matrices as scalars (FMI 2 has no others).")
    ] = False,
    source_only: Annotated[bool, typer.Option("--source-only", help="C sources, no binary for this machine.")] = False,
    json: Json = False,
) -> None:
    """Export a sheet as a functional mock-up unit for co-simulation (FMI 3.0 or 2.0): C sources and a binary.

    Example: saoflow fmu cmhe_fte -o cmhe_fte.fmu
    """
    from saoflow.fmi import build_unit, frame_period, write_unit
    from saoflow.fmi.unit import VERSIONS, check_target

    findings = Findings()
    if version not in VERSIONS:
        findings.add(one_of("--version", str(version), ("3", "2")))
    if real not in (64, 32):
        findings.add(one_of("--real", str(real), ("64", "32")))
    if output is not None:
        findings.attempt(lambda: check_target(output))
    usable = not findings.errors
    sheet = load_sheet(name, settings, findings)
    if sheet is not None:
        findings.attempt(lambda: frame_period(sheet, period))
        findings.attempt(lambda: sheet.budget().raise_if_over())
    if sheet is None or not usable or findings.errors:
        finish(findings.found, json)
        raise typer.Exit(BAD_INPUT)
    with _told(f"making the unit of {sheet.name}"):
        unit = findings.attempt(
            lambda: build_unit(sheet, version, real=real, period=period, scalar=scalars, binary=not source_only)
        )
    path = None if unit is None else findings.attempt(lambda: write_unit(unit, output or f"{unit.identifier}.fmu"))
    if unit is None or path is None:
        finish(findings.found, json)
        raise typer.Exit(BAD_INPUT)
    if unit.platform is None and not source_only:
        findings.add(_no_binary())
    facts = _facts(unit, output or path.name, path.stat().st_size)
    if json:
        finish(findings.found, json, facts)
        return
    tell(findings.found)
    print(_summary(facts))


def _told(title: str) -> AbstractContextManager[Any]:
    """A word on the terminal while the unit is made: compiling takes seconds."""
    return console(stderr=True).status(f"{title} ...") if sys.stderr.isatty() else nullcontext()


def _no_binary() -> Diagnosis:
    return Diagnosis(
        "W607",
        "the unit holds C sources and no binary",
        cause="there is no C compiler here, or FMI has no name for this machine",
        remedy="install gcc or clang, or `pip install ziglang`; an importer that compiles sources can use the unit as it is",
    )


def _facts(unit: Unit, output: str, size: int) -> dict[str, Any]:
    return {
        "sheet": unit.name,
        "output": output,
        "bytes": size,
        "fmi": f"{unit.version}.0",
        "token": unit.token,
        "period": unit.period,
        "inputs": unit.count("input"),
        "outputs": unit.count("output"),
        "states": unit.count("local"),
        "constants": unit.count("local", "constant"),
        "binary": unit.platform,
    }


def _summary(facts: dict[str, Any]) -> str:
    kinds = ("input", "output", "state", "constant")
    counted = ", ".join(f"{facts[kind + 's']} {kind}{'' if facts[kind + 's'] == 1 else 's'}" for kind in kinds)
    binary = f"sources and a binary for {facts['binary']}" if facts["binary"] else "sources"
    return (
        f"{facts['sheet']}: FMI {facts['fmi']} co-simulation, a frame every {facts['period']:g} s; "
        f"variables: {counted}; {binary}; {Path(facts['output'])} ({facts['bytes'] // 1024 + 1} KiB)"
    )
