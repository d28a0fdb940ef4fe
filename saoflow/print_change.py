"""Two budgets side by side: as a table for a terminal, and as Markdown for a merge request."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from saoflow.printing import number
from saoflow.scheduler.budget_change import BudgetChange

if TYPE_CHECKING:
    from rich.console import Console

MOST_PARTS = 40
"""Changed parts that are shown."""


def print_change(change: BudgetChange, console: Console) -> None:
    """What changed, by kind and by part."""
    from rich.table import Table
    from rich.text import Text

    console.print(Text(headline(change), style="bold"))
    for title, rows in (("kind", kind_rows(change)), ("sub-sheet", part_rows(change, "  "))):
        if not rows:
            continue
        table = Table(box=None, pad_edge=False, padding=(0, 2, 0, 0))
        table.add_column(title, no_wrap=True, overflow="ellipsis", min_width=24)
        for column in ("before", "now", "change"):
            table.add_column(column, justify="right", no_wrap=True)
        for row in rows:
            table.add_row(*map(Text, row))
        with console.capture() as captured:
            console.print(table)
        console.file.write("".join(f"{line.rstrip()}\n" for line in captured.get().splitlines()))
    if len(change.parts) > MOST_PARTS:
        console.print(Text(f"{len(change.parts) - MOST_PARTS} further parts changed; --json lists them all"))


def markdown(change: BudgetChange) -> str:
    """The same for a merge request."""
    lines = [f"**{headline(change)}**", ""]
    for title, rows in (("kind", kind_rows(change)), ("sub-sheet", part_rows(change, "&emsp;"))):
        if rows:
            lines += [f"| {title} | before | now | change |", "|---|--:|--:|--:|"]
            lines += ["| " + " | ".join(row) + " |" for row in rows]
            lines.append("")
    return "\n".join(lines)


def headline(change: BudgetChange) -> str:
    """The verdict in one line."""
    after = change.after
    limit = next((line.limit for line in after.lines if line.kind == "operations"), None)
    allowed = "" if limit is None else f" of {number(limit)}"
    over = ", OVER BUDGET" if after.over else ""
    difference = signed(after.total - change.before.total)
    what = "the same operations" if change.same else f"{difference} operations"
    return f"{after.sheet}: {number(after.total)} operations a frame{allowed}{over}; {what} as against {change.before_name}"


def kind_rows(change: BudgetChange) -> list[tuple[str, str, str, str]]:
    """Kinds that changed, and the total."""
    return [
        (kind.kind, number(kind.before), number(kind.after), signed(kind.after - kind.before))
        for kind in change.kinds
        if kind.before != kind.after or kind.kind == "operations"
    ]


def part_rows(change: BudgetChange, indent: str) -> list[tuple[str, str, str, str]]:
    """Parts that changed, indented by level."""
    rows = []
    for part in change.parts[:MOST_PARTS]:
        name = indent * part.level + part.path.rpartition(".")[2]
        new = "new" if not part.before else "gone" if not part.after else signed(part.after - part.before)
        rows.append((name, number(part.before), number(part.after), new))
    return rows


def signed(value: int) -> str:
    """With its sign; 0 as it is."""
    return "0" if not value else ("+" if value > 0 else "−") + number(abs(value))


__all__: Sequence[str] = ("headline", "markdown", "print_change")
