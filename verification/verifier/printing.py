"""The report of a verification, as the terminal shows it."""

from __future__ import annotations

from typing import TYPE_CHECKING

from verification.verifier.report import Check, Report

if TYPE_CHECKING:
    from rich.console import Console
    from rich.table import Table

MOST_LISTED = 20
"""How many frames with another choice or decision are listed; the rest are counted."""


def print_report(report: Report, console: Console) -> None:
    """Print every check, the frames with another choice or decision, the tables' errors and the verdict."""
    parts: dict[str, list[Check]] = {}
    for check in report.checks:
        parts.setdefault(check.part, []).append(check)
    for part, checks in parts.items():
        console.print(_check_table(part, checks))
    if report.other_choices:
        console.print(_choice_table(report))
    if report.other_decisions:
        console.print(_decision_table(report))
    if report.tables:
        console.print(_table_errors(report))
    console.print(
        f"reference {report.reference}; {report.frames} frames in {len(report.scenarios)} runs, seed {report.seed}; "
        f"{report.seconds:.1f} s",
        style="dim",
        highlight=False,
    )
    style = "bold green" if report.passed else "bold red"
    console.print(report.summary, style=style, highlight=False, markup=False)


def _table(title: str, columns: tuple[tuple[str, str], ...]) -> Table:
    from rich import box
    from rich.table import Table

    table = Table(title=title, title_justify="left", title_style="bold", box=box.SIMPLE_HEAD, pad_edge=False)
    for name, justify in columns:
        table.add_column(name, justify="right" if justify == "right" else "left", overflow="fold")
    return table


def _check_table(part: str, checks: list[Check]) -> Table:
    columns = (("quantity", "left"), ("largest error", "right"), ("/ allowed", "right"))
    tolerances = {check.tolerance for check in checks}
    common = len(tolerances) == 1
    title = f"{part} [dim](allowed: {checks[0].tolerance})[/]" if common else part
    last = (("", "left"),) if common else (("tolerance", "left"), ("", "left"))
    table = _table(title, (*columns, ("where", "left"), *last))
    for check in _worst_of_repeats(checks):
        verdict = {True: "[green]ok[/]", False: "[bold red]FAILS[/]", None: "[dim]shown[/]"}[check.passed]
        if not check.frames:
            verdict = "[bold red]never compared[/]"
        where = check.where
        place = ""
        if where is not None and check.largest > 0.0:
            element = f" [{', '.join(map(str, where.element))}]" if where.element else ""
            repeat = f"{check.repeat}, " if check.repeat else ""
            place = f"{repeat}{where.scenario}, frame {where.frame}{element}".replace("[", r"\[")
        largest = f"{check.largest:.2g} {check.unit}".strip()
        tolerance = () if common else (check.tolerance,)
        table.add_row(check.quantity, largest, f"{check.ratio:.2g}", place, *tolerance, verdict)
    return table


def _worst_of_repeats(checks: list[Check]) -> list[Check]:
    """One check for each quantity: the first failing one of several, or the one with the largest difference."""
    worst: dict[str, Check] = {}
    for check in checks:
        before = worst.setdefault(check.quantity, check)
        if before.passed is not False and (check.passed is False or check.ratio > before.ratio):
            worst[check.quantity] = check
    return list(worst.values())


def _choice_table(report: Report) -> Table:
    columns = (("choice", "left"), ("run", "left"), ("frame", "right"), ("sheet", "right"), ("reference", "right"))
    table = _table("frames with another choice", (*columns, ("margin", "right"), ("", "left")))
    for other in report.other_choices[:MOST_LISTED]:
        verdict = "[green]by rounding[/]" if other.excused else "[bold red]FAILS[/]"
        where, margin = other.where, f"{other.margin:.2g}"
        values = f"{where.sheet:g}", f"{where.reference:g}"
        table.add_row(other.choice, where.scenario, str(where.frame), *values, margin, verdict)
    if (more := len(report.other_choices) - MOST_LISTED) > 0:
        table.add_row(f"... and {more} more", "", "", "", "", "", "")
    return table


def _decision_table(report: Report) -> Table:
    columns = (("decision", "left"), ("run", "left"), ("frame", "right"), ("measure", "right"), ("threshold", "right"))
    table = _table("runs in which a decision of the closed loop differs first", (*columns, ("", "left")))
    for other in report.other_decisions[:MOST_LISTED]:
        verdict = "[green]within the table error[/]" if other.excused else "[bold red]FAILS[/]"
        name = other.output + (rf"\[{', '.join(map(str, other.element))}]" if other.element else "")
        measure, threshold = f"{other.measure:.6g} {other.unit}", f"{other.threshold:g} {other.unit}"
        table.add_row(name, other.scenario, str(other.frame), measure, threshold, verdict)
    return table


def _table_errors(report: Report) -> Table:
    columns = (("table", "left"), ("points", "right"), ("proved error", "right"), ("sampled error", "right"))
    table = _table("tables against their functions", columns)
    for error in report.tables:
        kind = " (relative)" if error.relative else ""
        table.add_row(
            error.name.replace("[", r"\["), str(error.points), f"{error.proved:.2g}{kind}", f"{error.sampled:.2g}{kind}"
        )
    return table
