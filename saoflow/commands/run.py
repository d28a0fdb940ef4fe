"""The command ``saoflow run``."""

from __future__ import annotations

import warnings
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
    exit_code,
    finish,
    load_sheet,
    one_of,
    progress_bar,
    tell,
)
from saoflow.diagnosis import Diagnosis, refusal

if TYPE_CHECKING:
    from saoflow.pipeline import LoadedSheet
    from saoflow.recordings import FrameReader, Output
    from saoflow.recordings.run import Done, Kept
    from saoflow.scheduler.simulator import Simulator
    from saoflow.wires import WireType

BACKENDS = ("interpreter", "c")
REPORT_FRAMES = 100_000
"""Frames that a report shows, at most."""


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
    report: Annotated[
        str | None, typer.Option("--report", metavar="FILE", help="Write a page with plots, too.", show_default=False)
    ] = None,
    json: Json = False,
) -> None:
    """Run a recording of any length through a sheet, one row a frame.

    Example: saoflow run cmhe_fte flight.csv -o estimates.csv --report estimates.html
    """
    from saoflow.recordings import FrameReader, check_output

    findings = Findings()
    probes = list(dict.fromkeys(probe or ()))
    place = findings.attempt(lambda: check_output(output, recording))
    if report is not None:
        findings.attempt(lambda: _check_report(report, recording, output))
    known = backend in BACKENDS and real in (64, 32)
    if backend not in BACKENDS:
        findings.add(one_of("--backend", backend, BACKENDS))
    if real not in (64, 32):
        findings.add(one_of("--real", str(real), ("64", "32")))
    sheet = load_sheet(name, settings, findings, check=False)
    simulator = _kept(sheet, real, probes) if sheet and known and backend == "c" and not exact else None
    if sheet is not None and simulator is None:
        sheet = _checked(sheet, findings)
        simulator = _simulator(sheet, backend, real, probes, exact, findings, json) if sheet and known else None
    if simulator is not None:
        _refuse_twins(simulator, probes, findings)
    ports = _ports(sheet, simulator)
    reader = None if ports is None else findings.attempt(lambda: FrameReader(recording, ports))
    if sheet is None or simulator is None or reader is None or place is None or findings.errors:
        finish(findings.found, json)
        raise typer.Exit(BAD_INPUT)
    done = findings.attempt(lambda: _run(sheet, simulator, reader, place, report, findings))
    if done is None:
        finish(findings.found, json)
        raise typer.Exit(BAD_INPUT)
    written = {"output": output} if report is None else {"output": output, "report": report}
    facts = {"sheet": simulator.program.sheet, "recording": recording, **written, **_facts(done)}
    if json:
        finish(findings.found, json, facts)
        return
    tell(findings.found)
    print(_summary(facts))


def _kept(sheet: LoadedSheet, real: int, probes: list[str]) -> Simulator | None:
    """Compiled frames of a sheet that was right before: a sheet that has not changed is not elaborated."""
    from saoflow.codegen.backend import kept_simulator

    return kept_simulator(sheet, real, probes)


def _checked(sheet: LoadedSheet, findings: Findings) -> LoadedSheet | None:
    """The sheet if it is right."""
    before = len(findings.errors)
    findings.attempt(sheet.check)
    return sheet if len(findings.errors) == before else None


def _ports(sheet: LoadedSheet | None, simulator: Simulator | None) -> dict[str, WireType] | None:
    """The inputs; those of a simulator need no elaborated sheet."""
    if simulator is not None:
        return {port.name: port.type for port in simulator.program.inputs}
    return None if sheet is None else sheet.input_types


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
    return simulator


def _refuse_twins(simulator: Simulator, probes: list[str], findings: Findings) -> None:
    """E603 for probes that are outputs."""
    for twin in sorted({port.name for port in simulator.program.outputs} & set(probes)):
        findings.add(
            Diagnosis(
                "E603",
                f"`--probe {twin}` is an output already",
                cause="an output and a probe of one name would share their columns",
                remedy="leave out this --probe",
            )
        )


def _check_report(report: str, recording: str, output: str) -> None:
    """Refuse now a report that could not be written later. Raises DiagnosisError E601."""
    from saoflow.recordings import check_place
    from saoflow.whole_file import check_ending

    if Path(report).resolve() == Path(output).resolve():
        cause, remedy = "it is the recording that is written", "name another file"
        raise refusal("E601", f"{report}: cannot be written", cause=cause, remedy=remedy)
    check_place(report, recording)
    check_ending(report, ".html", "a page")


def _run(
    sheet: LoadedSheet,
    simulator: Simulator,
    reader: FrameReader,
    place: Output,
    report: str | None,
    findings: Findings,
) -> Done:
    """Run all frames, write them, and the report. Raises DiagnosisError; warnings go to the findings."""
    from saoflow.recordings.run import Kept, run_recording

    kept = None if report is None else Kept(REPORT_FRAMES)
    with reader, progress_bar(f"running {simulator.program.sheet}", 1.0) as bar:
        done = run_recording(simulator, reader, place, bar, kept)
    findings.extend(reader.warnings)
    if report is not None and kept is not None:
        if kept.count < done.frames:
            findings.add(
                Diagnosis(
                    "W502",
                    f"{report} shows the first {kept.count} of {done.frames} frames",
                    cause="more would be no picture, and no page that opens",
                    remedy="none needed: the output holds all; run a part of the recording to see it",
                )
            )
        _write_report(sheet, kept, report)
    return done


def _write_report(sheet: LoadedSheet, kept: Kept, report: str) -> None:
    from saoflow.report import report_of_run, write_report

    with progress_bar(f"drawing {report}", 1.0) as bar:
        write_report(report, report_of_run(sheet, kept.inputs(), kept.outputs(), kept.t()), bar)


def _facts(done: Done) -> dict[str, Any]:
    return {
        "frames": done.frames,
        "seconds": round(done.seconds, 6),
        "frames_per_second": round(done.frames / max(done.seconds, 1e-9)),
        "missing": done.missing,
        "columns": list(done.columns),
    }


def _summary(facts: dict[str, Any]) -> str:
    missing = sum(facts["missing"].values())
    samples = f"{missing or 'no'} missing sample{'' if missing == 1 else 's'}"
    frames = f"{facts['frames']} frame{'' if facts['frames'] == 1 else 's'}"
    return (
        f"{facts['sheet']}: {frames} in {facts['seconds']:.2f} s ({facts['frames_per_second']} frames/s), {samples}; "
        f"{len(facts['columns'])} column{'' if len(facts['columns']) == 1 else 's'} in {facts['output']}"
        + (f"; {facts['report']}" if "report" in facts else "")
    )
