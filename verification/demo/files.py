"""The files of the demonstration: the readings, the estimates, the page."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import saoflow
from saoflow import Diagnosis, DiagnosisError
from saoflow.recordings import check_output, output_columns, write_table
from saoflow.report import Difference, Mark, Report, RunShown, limits_of, write_report
from verification.demo.facts import equality_table, error_table, facts
from verification.demo.result import DemoResult, Method

RECORDING, ESTIMATES, PAGE = "recording.csv", "estimates.csv", "report.html"


def prepare(folder: str | Path) -> Path:
    """Make the folder, and refuse it now if its files could not be written later. Raises DiagnosisError E601."""
    place = Path(folder)
    try:
        place.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise DiagnosisError(
            [
                Diagnosis(
                    "E601",
                    f"{folder}: the folder cannot be made",
                    cause=error.strerror or str(error),
                    remedy="name a folder that you may make: saoflow demo -o out",
                )
            ]
        ) from None
    for name in (RECORDING, ESTIMATES):
        check_output(place / name)
    page = place / PAGE
    if page.is_dir():
        raise DiagnosisError(
            [
                Diagnosis(
                    "E601", f"{page}: cannot be written", cause="it is a folder", remedy="remove it, or use another -o"
                )
            ]
        )
    return place


def write_files(
    result: DemoResult, folder: str | Path, progress: Callable[[float], None] | None = None
) -> tuple[str, ...]:
    """Write readings, estimates and page; returns their paths, the page first. Raises DiagnosisError E601.

    ``saoflow run cmhe_fte recording.csv -o ...`` on the readings gives the estimates again, bit for bit.
    """
    place = prepare(folder)
    recording = result.recording
    write_table(place / RECORDING, dict(zip(recording.names, recording.columns, strict=True)))
    columns = output_columns(result.cmhe.outputs, result.cmhe.sheet.output_types, recording["t"])
    write_table(place / ESTIMATES, columns)
    write_report(place / PAGE, page_of(result, place), progress)
    return tuple(str(place / name) for name in (PAGE, ESTIMATES, RECORDING))


def page_of(result: DemoResult, folder: Path) -> Report:
    """The report of the demonstration."""
    fault = result.scenario.fault
    truth = {name: result.recording[f"{name}_true"] for name in ("alpha", "vc", "wx", "wz")}
    lead = (
        f"An A320 flies level at 350 kt and 5000 ft in calm air. At t = {fault.onset:g} s all three airspeed sensors run away "
        f"together, at {-(fault.rate or 0.0):g} kt/s downwards, so that no vote among them can help. CMHE-FTE, wired in YAML "
        "from restricted symbols, knows how strong wind can be; UMHE-FTE is the same estimator without these bounds. "
        "This is the condition of Fig. 4 of Wan and Keviczky (IEEE TCST 27, 2019), flown with JSBSim."
    )
    differences = tuple(
        Difference(
            f"{name}, {result.cmhe.label}",
            {
                "tables": result.cmhe.difference(quantity, exact=False),
                "exact functions": result.cmhe.difference(quantity, exact=True),
            },
        )
        for quantity, name in (("alpha", "angle of attack [deg]"), ("vc", "airspeed [kt]"))
    )
    return Report(
        title="Three airspeed sensors run away",
        time=result.time,
        runs=tuple(_run(result, method) for method in result.methods),
        lead=lead,
        inputs=result.recording.inputs(),
        truth=truth,
        limits=limits_of(result.cmhe.sheet),
        marks=(Mark(fault.onset, "fault"),),
        remarks={
            "wx": (
                "UMHE-FTE explains the failing sensors by a wind that cannot be. CMHE-FTE can do so up to the bound and no "
                "further: there the residual above begins to grow."
            ),
            "airspeed_error": (
                "Without any airspeed sensor (configuration III) wind cannot be told from airspeed: the sensors are rightly "
                "removed, but the estimate stays wrong by the wind that was made up before. The paper says so too (III-C)."
            ),
        },
        facts=facts(result),
        tables=(error_table(result), equality_table(result)),
        budget=result.cmhe.budget,
        differences=differences,
        difference_note=(
            "The sheet as it flies (with tables), and with exact functions in place of its tables, against the plain numpy "
            "reference that follows the paper. All three run in closed loop, so that differences may build up."
        ),
        repeat=(
            f"saoflow run cmhe_fte {folder / RECORDING} -o again.csv    # equals {folder / ESTIMATES}",
            "saoflow budget cmhe_fte",
            "saoflow verify cmhe_fte",
        ),
        version=saoflow.__version__,
    )


def _run(result: DemoResult, method: Method) -> RunShown:
    frame = result.isolated_frame(method)
    marks = () if frame is None else (Mark(float(result.time[frame]), f"isolated {result.time[frame]:.1f} s"),)
    return RunShown(method.label, method.outputs, marks)
