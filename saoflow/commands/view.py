"""The command ``saoflow view``."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import numpy as np
import typer

from saoflow.commands.shell import BAD_INPUT, Findings, Json, Set, SheetName, finish, load_sheet, tell
from saoflow.diagnosis import Diagnosis

if TYPE_CHECKING:
    from saoflow.drawing.page import RunShown
    from saoflow.pipeline import LoadedSheet

MOST_FRAMES = 20_000
"""Frames that a page plays, at most: about a quarter of an hour of the flagship."""


def view(
    name: SheetName,
    output: Annotated[
        str | None,
        typer.Option("-o", "--output", metavar="FILE", help="File to write [default: SHEET.html or .svg].", show_default=False),
    ] = None,
    recording: Annotated[
        str | None,
        typer.Option("--run", metavar="RECORDING", help="Play this recording through the drawings.", show_default=False),
    ] = None,
    inside: Annotated[
        str, typer.Option("--inside", metavar="PATH", help="With --svg: the sub-sheet to draw, as step3.ip[2].", show_default=False)
    ] = "",
    svg: Annotated[bool, typer.Option("--svg", help="One drawing as SVG, for documents (extra saoflow[svg]).")] = False,
    settings: Set = None,
    json: Json = False,
) -> None:
    """Draw a sheet as a page to walk through: one file, no network; with a recording, to play.

    Example: saoflow view cmhe_fte --run flight.csv -o cmhe_fte.html
    """
    findings = Findings()
    if svg and recording is not None:
        findings.add(_refused("--run", "a picture does not play", "leave out --svg, or --run"))
    if inside and not svg:
        findings.add(_refused("--inside", "a page holds all sub-sheets", "add --svg, or open the page at #" + inside))
    sheet = load_sheet(name, settings, findings)
    target = output or (f"{sheet.name}.{'svg' if svg else 'html'}" if sheet else None)
    if target is not None:
        findings.attempt(lambda: _check_target(target, recording, svg))
    run = None
    if sheet is not None and recording is not None and not svg:
        run = findings.attempt(lambda: _read(sheet, recording, findings))
    if sheet is None or target is None or findings.errors:
        finish(findings.found, json)
        raise typer.Exit(BAD_INPUT)
    findings.attempt(lambda: _write(sheet, target, run, inside, svg))
    facts = {"sheet": sheet.name, "output": target, "frames": run.frames if run else 0}
    if findings.errors or json:
        finish(findings.found, json, facts if not findings.errors else None)
        return
    tell(findings.found)
    played = f", {run.frames} frames to play" if run else ""
    print(f"{sheet.name}: {target}, {Path(target).stat().st_size / 1e6:.1f} MB{played}")


def _check_target(target: str, recording: str | None, svg: bool) -> None:
    """Raise DiagnosisError E601 for a file that cannot be written, or is named as what it will not be."""
    from saoflow.recordings.output import check_place
    from saoflow.whole_file import check_ending

    check_place(target, recording)
    if svg:
        check_ending(target, ".svg", "a picture")
    else:
        check_ending(target, ".html", "a page", "add --svg for a picture" if target.endswith(".svg") else "")


def _write(sheet: LoadedSheet, target: str, run: RunShown | None, inside: str, svg: bool) -> None:
    from saoflow.drawing.page import write_view
    from saoflow.whole_file import write_text

    if svg:
        from saoflow.drawing.svg import render_svg

        write_text(target, render_svg(sheet, inside), "the picture")
    else:
        write_view(target, sheet, run)


def _read(sheet: LoadedSheet, recording: str, findings: Findings) -> RunShown:
    """The inputs of a recording, no more of them than a page plays."""
    from saoflow.drawing.page import RunShown
    from saoflow.recordings import FrameReader

    parts, count, more = [], 0, False
    with FrameReader(recording, sheet.input_types) as reader:
        for frames in reader:
            parts.append(frames)
            count += frames.count
            if count > MOST_FRAMES:
                more = True
                break
        findings.extend(reader.warnings)
    kept = min(count, MOST_FRAMES)
    if more:
        findings.add(
            Diagnosis(
                "W502",
                f"the page plays the first {MOST_FRAMES} frames",
                cause=f"{recording} has more, and a page that opens can hold no more",
                remedy="none needed, or cut the part that you want to see",
            )
        )
    inputs = {
        port: np.concatenate([np.asarray(part.inputs[port], dtype=np.float64) for part in parts])[:kept]
        for port in sheet.input_types
    }
    return RunShown(inputs, kept, sheet.budget().period)


def _refused(option: str, cause: str, remedy: str) -> Diagnosis:
    return Diagnosis("E603", f"`{option}` makes no sense here", cause=cause, remedy=remedy)
