"""The tables of a campaign: Tables III and IV beside those of paper 004, then by category and by kind of fault."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from verification.campaigns.metrics import Figures, Group, SheetMetrics, share
from verification.campaigns.plan import Campaign

if TYPE_CHECKING:
    from rich.console import Console

PAPER_III = (("fault-free, paper", "2.44", "8.22", "0.02", "0.02"), ("faulty, paper", "16.39", "8.22", "0.24", "0.02"))
PAPER_IV = (("AOA, paper", "0", "0", "0.92", "19.16", "0.75"), ("VCAS, paper", "0", "0", "0", "4.64", "0.80"))
"""Paper 004, Tables III and IV."""
NAMES = {"alpha": "AOA", "vc": "VCAS"}


@dataclass(frozen=True)
class Table:
    """A table of text: title, heads of its columns, rows."""

    title: str
    heads: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    note: str = ""


def tables_of(metrics: SheetMetrics) -> tuple[Table, ...]:
    """All tables of one sheet."""
    found = [_table_iii(metrics), _table_iv(metrics), _bars(metrics)]
    if metrics.fault_free_beyond.runs or metrics.faulty_beyond.runs:
        found.append(_beyond(metrics))
    if metrics.faulty.runs:
        found += [_by_category(metrics), _by_kind(metrics)]
    if metrics.failures:
        rows = tuple((str(run), reason) for run, reason in metrics.failures)
        found.append(Table("Runs that failed (the first of them)", ("run", "reason"), rows))
    return tuple(found)


def _table_iii(metrics: SheetMetrics) -> Table:
    heads = ("runs", "max AOA [deg]", "max VCAS [kt]", "mean AOA [deg]", "mean VCAS [kt]")
    rows = []
    for group, paper in zip((metrics.fault_free, metrics.faulty), PAPER_III, strict=True):
        (a_max, a_mean), (v_max, v_mean) = group.alpha.error, group.vc.error
        ours = (f"{group.name} ({group.runs})", number(a_max), number(v_max), number(a_mean, 3), number(v_mean, 3))
        rows += [ours, paper] if group.runs else []
    lost = metrics.faulty.vc.error_lost
    note = "Absolute errors. VCAS without categories III and IV, as in the paper."
    if not math.isnan(lost[0]):
        note += (
            f" In configurations III and IV it errs by up to {number(lost[0])} kt, {number(lost[1])} kt in the mean."
        )
    return Table("Table III: estimation performance", heads, tuple(rows), note)


def _table_iv(metrics: SheetMetrics) -> Table:
    heads = ("sensors", "FAR [%]", "MDR [%]", "FIR [%]", "max delay [s]", "mean delay [s]")
    rows = []
    for sensor, paper in zip(NAMES, PAPER_IV, strict=True):
        free, faulty = metrics.fault_free.figures(sensor), metrics.faulty.figures(sensor)
        ours = (
            NAMES[sensor],
            percent(free.wrong, metrics.fault_free.runs),
            percent(faulty.missed, metrics.faulty.runs),
            percent(faulty.wrong, metrics.faulty.runs),
            number(faulty.delay.largest),
            number(faulty.delay.mean),
        )
        rows += [ours, paper]
    note = f"{metrics.fault_free.runs} fault-free and {metrics.faulty.runs} faulty runs in winds inside the assumed bounds."
    return Table("Table IV: fault diagnosis performance", heads, tuple(rows), note)


def _bars(metrics: SheetMetrics) -> Table:
    heads = ("what", "AOA", "VCAS")
    free, faulty = metrics.fault_free, metrics.faulty

    def row(what: str, text: Callable[[Figures], str], group: Group) -> tuple[str, ...]:
        return what, text(group.alpha), text(group.vc)

    rows = [row("fault-free runs with a false alarm", lambda f: of(f.wrong, free.runs), free)] if free.runs else []
    if faulty.runs:
        rows += [
            row("faults that must be found, missed", lambda f: of(f.detectable_missed, f.detectable), faulty),
            row(
                "other faults, missed",
                lambda f: of(f.missed - f.detectable_missed, f.hit - f.detectable),
                faulty,
            ),
            row("mean delay of fast faults that must be found [s]", lambda f: number(f.fast_delay.mean), faulty),
            row("faulty runs with a false isolation", lambda f: of(f.wrong, faulty.runs), faulty),
        ]
    note = (
        "A fault must be found if its own signal holds the residual above the threshold (verification/campaigns/detectable.py). "
        "Fast: bias, oscillation, jamming, non-return to zero, runaway above 2 deg/s or 10 kt/s."
    )
    return Table("What must be found, and what was", heads, tuple(rows), note)


def _beyond(metrics: SheetMetrics) -> Table:
    heads = ("runs", "false alarm or isolation, AOA", "VCAS", "missed that must be found, AOA", "VCAS")
    rows = []
    for group in (metrics.fault_free_beyond, metrics.faulty_beyond):
        if group.runs:
            a, v = group.alpha, group.vc
            wrong = of(a.wrong, group.runs), of(v.wrong, group.runs)
            missed = of(a.detectable_missed, a.detectable), of(v.detectable_missed, v.detectable)
            rows.append((f"{group.name} ({group.runs})", *wrong, *missed))
    return Table("Winds beyond the assumed bounds, counted apart", heads, tuple(rows))


_DETAILS = (
    "missed",
    "must be found",
    "missed of these",
    "wrong",
    "max delay [s]",
    "mean [s]",
    "max error",
    "mean error",
)


def _by_category(metrics: SheetMetrics) -> Table:
    heads = ("category", "sensors", "runs", *_DETAILS)
    rows = [
        (group.name, NAMES[sensor], of(group.figures(sensor).hit, group.runs), *_details(group, sensor))
        for group in metrics.categories
        for sensor in NAMES
        if group.runs
    ]
    note = "Runs: those with faults of these sensors, of all of the category. Errors in deg and kt."
    return Table("By category of Table I", heads, tuple(rows), note)


def _by_kind(metrics: SheetMetrics) -> Table:
    heads = ("fault", "sensors", "runs", *_DETAILS)
    rows = []
    for group in metrics.kinds:
        kind, sensor = group.name.split()
        if group.runs:
            rows.append((kind.replace("_", " "), NAMES[sensor], str(group.runs), *_details(group, sensor)))
    return Table(
        "By kind of fault", heads, tuple(rows), "Wrong: runs in which a healthy sensor of the same kind was confirmed."
    )


def _details(group: Group, sensor: str) -> tuple[str, ...]:
    f = group.figures(sensor)
    counts = (str(f.missed), str(f.detectable), str(f.detectable_missed), str(f.wrong))
    return (*counts, number(f.delay.largest), number(f.delay.mean), number(f.error[0]), number(f.error[1], 3))


def number(value: float, digits: int = 2) -> str:
    """With so many decimals; a dash for what is not there."""
    return "-" if math.isnan(value) else f"{value:.{digits}f}"


def percent(part: int, whole: int) -> str:
    """In percent with two decimals."""
    return number(share(part, whole)) if part else "0" if whole else "-"


def of(part: int, whole: int) -> str:
    """``3 of 109``."""
    return f"{part} of {whole}" if whole else "-"


# -- out


def markdown(campaign: Campaign, metrics: Sequence[SheetMetrics]) -> str:
    """The whole as Markdown."""
    lines = [f"# Campaign {campaign.name}", "", campaign.doc, ""]
    for sheet in metrics:
        lines += [f"## {sheet.sheet}", ""]
        for table in tables_of(sheet):
            lines += [f"### {table.title}", "", *markdown_table(table), ""]
            lines += [table.note, ""] if table.note else []
    return "\n".join(lines).rstrip() + "\n"


def markdown_table(table: Table) -> list[str]:
    """Lines of one table."""
    lines = [f"| {' | '.join(table.heads)} |", f"|{'---|' * len(table.heads)}"]
    return lines + [f"| {' | '.join(row)} |" for row in table.rows]


def print_tables(metrics: Sequence[SheetMetrics], console: Console) -> None:
    """On a terminal."""
    for sheet in metrics:
        for table in tables_of(sheet):
            print_table(replace(table, title=f"{sheet.sheet}: {table.title}"), console)


def print_table(table: Table, console: Console) -> None:
    """One table on a terminal."""
    from rich.box import SIMPLE_HEAD
    from rich.table import Table as RichTable
    from rich.text import Text

    shown = RichTable(title=Text(table.title), title_justify="left", box=SIMPLE_HEAD, pad_edge=False)
    for i, head in enumerate(table.heads):
        shown.add_column(Text(head), justify="left" if i == 0 else "right", no_wrap=i in (0, len(table.heads) - 1))
    for row in table.rows:
        shown.add_row(*(Text(cell) for cell in row))  # not markup: a variant has brackets
    console.print(shown)
    if table.note:
        console.print(Text(table.note, style="dim"))
    console.print()
