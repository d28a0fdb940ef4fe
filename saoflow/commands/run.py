"""The command ``saoflow run``."""

from __future__ import annotations

import time
import warnings
from typing import TYPE_CHECKING, Annotated, Any

import typer

from saoflow.commands.shell import (
    BAD_INPUT,
    Findings,
    Json,
    Set,
    SheetName,
    console,
    exit_code,
    finish,
    load_sheet,
    one_of,
    progress_bar,
    tell,
)
from saoflow.diagnosis import Diagnosis

if TYPE_CHECKING:
    from saoflow.pipeline import LoadedSheet
    from saoflow.recording import Frames, Output
    from saoflow.scheduler.simulator import Simulator

BACKENDS = ("interpreter", "c")


def run(
    name: SheetName,
    recording: Annotated[
        str, typer.Argument(metavar="IN", help="Recording of the inputs: .csv, .csv.gz, .parquet.", show_default=False)
    ],
    output: Annotated[
        str, typer.Option("-o", "--output", metavar="OUT", help="Recording to write.", show_default=False)
    ],
    backend: Annotated[str, typer.Option("--backend", metavar="NAME", help="interpreter or c.")] = "interpreter",
    real: Annotated[int, typer.Option("--real", metavar="BITS", help="Reals of 64 or 32 bits.")] = 64,
    settings: Set = None,
    probe: Annotated[
        list[str] | None,
        typer.Option(
            "--probe",
            metavar="WIRE",
            help="Record a wire too, by its path: step3.ip[2].K; repeatable.",
            show_default=False,
        ),
    ] = None,
    exact: Annotated[bool, typer.Option("--exact", help="Put the functions of tables in their place.")] = False,
    json: Json = False,
) -> None:
    """Run a recording through a sheet, one row a frame.

    Example: saoflow run cmhe_fte flight.csv -o estimates.csv
    """
    from saoflow.recording import check_output, read_frames

    findings = Findings()
    probes = list(dict.fromkeys(probe or ()))
    place = findings.attempt(lambda: check_output(output, recording))
    known = backend in BACKENDS and real in (64, 32)
    if backend not in BACKENDS:
        findings.add(one_of("--backend", backend, BACKENDS))
    if real not in (64, 32):
        findings.add(one_of("--real", str(real), ("64", "32")))
    sheet = load_sheet(name, settings, findings)
    simulator = _simulator(sheet, backend, real, probes, exact, findings, json) if sheet and known else None
    ports = None if sheet is None else sheet.input_types
    frames = None if ports is None else findings.attempt(lambda: read_frames(recording, ports))
    if simulator is None or frames is None or place is None or findings.errors:
        finish(findings.found, json)
        raise typer.Exit(BAD_INPUT)
    findings.extend(frames.warnings)
    facts = _run(simulator, frames, place)
    facts = {"sheet": simulator.program.sheet, "recording": recording, "output": output, **facts}
    if json:
        finish(findings.found, json, facts)
        return
    tell(findings.found)
    print(_summary(facts))


def _simulator(
    sheet: LoadedSheet, backend: str, real: int, probes: list[str], exact: bool, findings: Findings, json: bool
) -> Simulator | None:
    """Frames of the sheet. A sheet over its budget is refused here, with the table that shows what costs."""
    budget = findings.attempt(sheet.budget)
    if budget is not None and budget.over:
        over = findings.attempt(budget.raise_if_over)
        assert over is None
        if json:
            finish(findings.found, json, {"budget": budget.to_dict()})
        from saoflow.printing import print_budget

        print_budget(budget, console(stderr=True))
        tell(findings.found)
        raise typer.Exit(exit_code(findings.found))
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        simulator = findings.attempt(lambda: sheet.simulator(backend, real=real, probes=probes, exact=exact))
    # Backend `c` says so when something else does the work.
    findings.extend(warning.message.diagnosis for warning in caught if hasattr(warning.message, "diagnosis"))
    if simulator is not None:
        for twin in {port.name for port in simulator.program.outputs} & set(probes):
            findings.add(
                Diagnosis(
                    "E603",
                    f"`--probe {twin}` is an output already",
                    cause="an output and a probe of one name would share their columns",
                    remedy="leave out this --probe",
                )
            )
    return simulator


def _run(simulator: Simulator, frames: Frames, place: Output) -> dict[str, Any]:
    import numpy as np

    from saoflow.recording import output_columns, write_table

    program = simulator.program
    start = time.perf_counter()
    with progress_bar(f"running {program.sheet}", frames.count) as bar:
        # A sheet without inputs takes the number of frames from any array.
        arrays = simulator.run(frames.inputs or {"frames": np.zeros(frames.count)}, progress=bar)
    seconds = time.perf_counter() - start
    types = {port.name: port.type for port in (*program.outputs, *program.probes)}
    columns = output_columns(arrays, types, frames.t)
    write_table(place, columns)
    return {
        "frames": frames.count,
        "seconds": round(seconds, 6),
        "frames_per_second": round(frames.count / max(seconds, 1e-9)),
        "missing": frames.missing,
        "columns": list(columns),
    }


def _summary(facts: dict[str, Any]) -> str:
    missing = sum(facts["missing"].values())
    samples = f"{missing or 'no'} missing sample{'' if missing == 1 else 's'}"
    frames = f"{facts['frames']} frame{'' if facts['frames'] == 1 else 's'}"
    return (
        f"{facts['sheet']}: {frames} in {facts['seconds']:.2f} s ({facts['frames_per_second']} frames/s), {samples}; "
        f"{len(facts['columns'])} columns in {facts['output']}"
    )
