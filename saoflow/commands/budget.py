"""The command ``saoflow budget``."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

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
    tell,
)
from saoflow.diagnosis import Diagnosis, refusal

if TYPE_CHECKING:
    from saoflow.pipeline import LoadedSheet
    from saoflow.scheduler.budget import BudgetReport
    from saoflow.targets import FrameCost


def budget(
    name: SheetName,
    settings: Set = None,
    depth: Annotated[int, typer.Option("--depth", min=0, metavar="N", help="Levels of sub-sheets shown.")] = 3,
    target: Annotated[
        str | None,
        typer.Option(
            "--target", metavar="NAME", help="Cycles and time on a processor: mpc755, ...", show_default=False
        ),
    ] = None,
    clock: Annotated[
        float | None, typer.Option("--clock", metavar="MHZ", help="The target's clock.", show_default=False)
    ] = None,
    share: Annotated[
        float | None,
        typer.Option("--share", metavar="PART", help="Part of the frame allowed, 0 to 1.", show_default=False),
    ] = None,
    report_file: Annotated[
        str | None, typer.Option("--report", metavar="FILE", help="Write a page with a picture, too.", show_default=False)
    ] = None,
    versus: Annotated[
        str | None, typer.Option("--vs", metavar="SHEET", help="Show what changed from this sheet.", show_default=False)
    ] = None,
    versus_git: Annotated[
        str | None,
        typer.Option("--vs-git", metavar="REV", help="Show what changed since this revision of git.", show_default=False),
    ] = None,
    markdown: Annotated[bool, typer.Option("--markdown", help="With --vs or --vs-git: for a merge request.")] = False,
    everything: Annotated[bool, typer.Option("--all", help="Show small parts one by one, too.")] = False,
    json: Json = False,
) -> None:
    """Operations of one frame by kind and by sub-sheet, against the sheet's budget. Exits 1 if it is over.

    Example: saoflow budget cmhe_fte --depth 2

    Example: saoflow budget cmhe_fte --target mpc755 --clock 400 --share 0.1

    Example: saoflow budget my_sheet.yaml --vs-git main --markdown
    """
    from saoflow.scheduler.rate_frames import frame_of
    from saoflow.targets import find_target, frame_cost
    from saoflow.targets.print_cost import print_cost

    findings = Findings()
    if target is None and (clock is not None or share is not None):
        findings.add(
            Diagnosis(
                "E603",
                "`--clock` and `--share` need a target",
                cause="cycles are known for a target only",
                remedy="add --target mpc755",
            )
        )
    if markdown and versus is None and versus_git is None:
        cause, remedy = "it is the form of a comparison", "add --vs SHEET or --vs-git REV, or leave it out"
        findings.add(Diagnosis("E603", "`--markdown` makes no sense here", cause=cause, remedy=remedy))
    if report_file is not None:
        findings.attempt(lambda: _check_report(report_file))
    processor = None if target is None else findings.attempt(lambda: find_target(target))
    sheet = load_sheet(name, settings, findings)
    report = None if sheet is None else findings.attempt(sheet.budget)
    if report is None or findings.errors:
        finish(findings.found, json)
        raise typer.Exit(BAD_INPUT)
    cost = None
    if processor is not None and sheet is not None:
        cost = findings.attempt(
            lambda: frame_cost(
                frame_of(sheet.frame_program, report.worst),
                processor,
                clock_mhz=clock,
                period=report.period,
                share=share,
            )
        )
        if cost is None:
            finish(findings.found, json)
            raise typer.Exit(BAD_INPUT)
        findings.attempt(cost.raise_if_over)
    findings.attempt(report.raise_if_over)
    if report_file is not None and sheet is not None:
        _write_report(sheet, report_file, findings, json)
    if sheet is not None and (versus is not None or versus_git is not None):
        _compare(sheet, report, cost, versus, versus_git, markdown, findings, json)
        return
    if json:
        facts = report.to_dict()
        finish(findings.found, json, facts if cost is None else {**facts, "target": cost.to_dict()})
        return
    from saoflow.printing import print_budget

    print_budget(report, console(), depth, everything)
    if cost is not None:
        print_cost(cost, console())
    tell(findings.found)
    if report.over or (cost is not None and cost.over):
        raise typer.Exit(exit_code(findings.found))


def _compare(
    sheet: LoadedSheet,
    report: BudgetReport,
    cost: FrameCost | None,
    versus: str | None,
    versus_git: str | None,
    markdown: bool,
    findings: Findings,
    json: bool,
) -> None:
    """Tell what changed. What is compared with may be over its own budget."""
    from saoflow.print_change import markdown as as_markdown
    from saoflow.print_change import print_change
    from saoflow.scheduler.budget_change import compare_budgets
    from saoflow.targets.print_cost import print_cost

    before = findings.attempt(lambda: _before(sheet, versus, versus_git))
    if before is None:
        finish(findings.found, json)
        raise typer.Exit(BAD_INPUT)
    change = compare_budgets(before, report, versus or str(versus_git))
    if json:
        finish(findings.found, json, change.to_dict() if cost is None else {**change.to_dict(), "target": cost.to_dict()})
        return
    if markdown:
        print(as_markdown(change))
    else:
        print_change(change, console())
    if cost is not None:
        print_cost(cost, console())
    tell(findings.found)
    if report.over or (cost is not None and cost.over):
        raise typer.Exit(exit_code(findings.found))


def _before(sheet: LoadedSheet, versus: str | None, versus_git: str | None) -> BudgetReport:
    """The budget that is compared with. Raises DiagnosisError."""
    from saoflow.git_revision import sheet_at
    from saoflow.pipeline import load

    if versus is not None and versus_git is not None:
        cause, remedy = "both say what to compare with", "leave out one of them"
        raise refusal("E603", "`--vs` and `--vs-git` exclude each other", cause=cause, remedy=remedy)
    if versus is not None:
        return load(versus).budget()
    assert versus_git is not None
    with sheet_at(sheet.sheet.file, versus_git) as path:
        return load(str(path)).budget()


def _check_report(file: str) -> None:
    """Refuse now a page that could not be written later. Raises DiagnosisError E601."""
    from saoflow.recordings import check_place
    from saoflow.whole_file import check_ending

    check_place(file)
    check_ending(file, ".html", "a page")


def _write_report(sheet: LoadedSheet, file: str, findings: Findings, json: bool) -> None:
    """Write the page; a frame over its budget is shown too."""
    from saoflow.report import report_of_budget, write_report

    own = Findings()
    own.attempt(lambda: write_report(file, report_of_budget(sheet)))
    findings.extend(own.found)
    if own.errors:
        finish(findings.found, json)
        raise typer.Exit(BAD_INPUT)
