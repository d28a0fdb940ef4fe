"""Budget reports as tables for a terminal."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from saoflow.scheduler.counts import CountTree

if TYPE_CHECKING:
    from rich.console import Console

    from saoflow.scheduler.budget import BudgetReport

BAR = 20
"""Characters of a full bar."""


@dataclass(frozen=True, slots=True)
class CostLine:
    """One line of the tree: a sub-sheet or block, or several instances of a fold or map that cost the same."""

    level: int
    name: str
    instances: int
    operations: int
    """Of all instances together."""
    together: bool = False
    """Several small parts in one line."""


SMALL = 0.005
"""Parts below this share of the whole are told together, if there are several of them side by side in a sheet."""


def print_budget(report: BudgetReport, console: Console, depth: int = 3, everything: bool = False) -> None:
    """By kind against the limits, by sub-sheet, look-ups with their inner costs, and what else a frame needs.

    ``everything``: small parts one by one, too.
    """
    with console.capture() as captured:
        _budget(report, console, depth, 0 if everything else SMALL * report.total)
    # Tables are padded to their full width; that is of no use in a file.
    console.file.write("".join(f"{line.rstrip()}\n" for line in captured.get().splitlines()))


def _budget(report: BudgetReport, console: Console, depth: int, least: float) -> None:
    from rich.table import Table
    from rich.text import Text

    limit = next((line.limit for line in report.lines if line.kind == "operations"), None)
    share = "" if not limit else f" of {number(limit)} ({_percent(report.total, limit)})"
    period = "" if report.period is None else f", every {report.period:g} s"
    which = f" in frame {report.worst}, the dearest of {len(report.frames)}" if report.frames else " a frame"
    console.print(Text(f"{report.sheet}: {number(report.total)} operations{which}{share}{period}", style="bold"))
    kinds = Table(box=None, pad_edge=False, padding=(0, 2, 0, 0))
    for title in ("kind", "used", "limit", "", ""):
        kinds.add_column(title, justify="right" if title in ("used", "limit") else "left", no_wrap=True)
    for line in report.lines:
        allowed = "" if line.limit is None else number(line.limit)
        bar = "" if not line.limit else f"{_bar(line.used / line.limit)} {_percent(line.used, line.limit)}"
        style = "bold red" if line.over else ""
        over = "OVER BUDGET" if line.over else ""
        kinds.add_row(*(Text(cell, style) for cell in (line.kind, number(line.used), allowed, bar, over)))
    console.print(kinds)
    if report.rates:
        console.print(_rate_table(report))
    if report.tree.parts and depth:
        console.print(_tree_table(report, depth, least))
    if report.tables:
        console.print(_lookup_table(report))
    console.print(
        Text(
            f"{_many(report.state_slots, 'state slot')}, {_many(report.procedures, 'procedure')}, "
            f"{_many(len(report.tables), 'table')}"
        )
    )


def _tree_table(report: BudgetReport, depth: int, least: float) -> object:
    from rich.table import Table
    from rich.text import Text

    table = Table(box=None, pad_edge=False, padding=(0, 2, 0, 0))
    table.add_column("sub-sheet", no_wrap=True, overflow="ellipsis", min_width=24)
    for title in ("operations", "share"):
        table.add_column(title, justify="right", no_wrap=True)
    table.add_column("", no_wrap=True)
    table.add_column("", no_wrap=True)
    for line in cost_lines(report.tree, depth, least):
        each = (
            ""
            if line.instances == 1 or line.together
            else f"{line.instances} x {number(line.operations // line.instances)}"
        )
        share = line.operations / max(1, report.total)
        cells = ("  " * line.level + line.name, number(line.operations), f"{100 * share:.1f} %", _bar(share), each)
        table.add_row(*map(Text, cells))
    return table


MOST_FRAMES = 32
"""Frames of a hyperperiod that are shown one by one."""


def _rate_table(report: BudgetReport) -> object:
    """What runs when, and what each frame of the hyperperiod costs."""
    from rich.console import Group
    from rich.table import Table
    from rich.text import Text

    table = Table(box=None, pad_edge=False, padding=(0, 2, 0, 0))
    table.add_column("own rate", no_wrap=True, overflow="ellipsis", min_width=24)
    for title in ("every", "offset"):
        table.add_column(title, justify="right", no_wrap=True)
    table.add_column("", no_wrap=True)
    for rate in report.rates:
        chosen = "chosen to balance the frames" if rate.balanced else ""
        table.add_row(*map(Text, (rate.path, str(rate.every), str(rate.offset), chosen)))
    frames = Table(box=None, pad_edge=False, padding=(0, 2, 0, 0))
    frames.add_column("frame", justify="right")
    frames.add_column("operations", justify="right", no_wrap=True)
    frames.add_column("", no_wrap=True)
    shown = list(enumerate(report.frames))
    if len(shown) > MOST_FRAMES:
        shown = sorted(shown, key=lambda frame: (-frame[1], frame[0]))[:MOST_FRAMES]
    for frame, cost in shown:
        frames.add_row(*map(Text, (str(frame), number(cost), _bar(cost / max(1, report.total)))))
    left = len(report.frames) - len(shown)
    return Group(table, frames, *([Text(f"{left} frames that cost no more")] if left else []))


def _lookup_table(report: BudgetReport) -> object:
    from rich.table import Table
    from rich.text import Text

    table = Table(box=None, pad_edge=False, padding=(0, 2, 0, 0))
    table.add_column("table", no_wrap=True, overflow="ellipsis", min_width=24)
    for title in ("look-ups", "points", "search steps"):
        table.add_column(title, justify="right", no_wrap=True)
    for cost in report.tables:
        cells = (cost.name, number(cost.uses), number(cost.points), number(cost.search_steps))
        table.add_row(*map(Text, cells))
    return table


def cost_lines(tree: CountTree, depth: int, least: float = 0) -> Iterator[CostLine]:
    """The sub-sheets of a count tree down to a depth.

    Instances that cost the same are one line ``stages[0..2]``; parts with fewer operations than ``least`` are one line.
    """
    stack: list[tuple[int, CostLine, CountTree]] = [(0, CostLine(0, tree.name, 1, tree.total), tree)]
    while stack:
        level, line, here = stack.pop()
        yield line
        if level >= depth:
            continue
        below: list[tuple[CostLine, CountTree]] = []
        for name, count, part in _runs([p for p in here.parts.values() if p.total]):
            instances = line.instances * count
            below.append((CostLine(level + 1, name, instances, instances * part.total), part))
        small = [entry for entry in below if entry[0].operations < least]
        if len(small) > 2:
            below = [entry for entry in below if entry[0].operations >= least]
            operations = sum(cost.operations for cost, _ in small)
            rest = CostLine(level + 1, f"{len(small)} small parts", 1, operations, together=True)
            below.append((rest, CountTree(rest.name)))
        stack += [(level + 1, *entry) for entry in reversed(below)]


INSTANCE = re.compile(r"(.*)\[(\d+)\]")


def _runs(parts: Sequence[CountTree]) -> Iterator[tuple[str, int, CountTree]]:
    """Instances with consecutive numbers and equal costs, together: name, how many, and the first of them."""
    i = 0
    while i < len(parts):
        first = INSTANCE.fullmatch(parts[i].name)
        end = i + 1
        while first and end < len(parts) and _follows(parts[end - 1], parts[end]):
            end += 1
        count = end - i
        if first is None or count == 1:
            yield parts[i].name, 1, parts[i]
        else:
            low, high = int(first[2]), int(first[2]) + count - 1
            last = INSTANCE.fullmatch(parts[end - 1].name)
            assert last is not None
            low, high = min(int(first[2]), int(last[2])), max(int(first[2]), int(last[2]))
            yield f"{first[1]}[{low}..{high}]", count, parts[i]
        i = end


def _follows(a: CountTree, b: CountTree) -> bool:
    """Whether ``b`` is the next (or, in a reverse fold, the previous) instance after ``a`` and costs the same."""
    one, two = INSTANCE.fullmatch(a.name), INSTANCE.fullmatch(b.name)
    if one is None or two is None or one[1] != two[1] or abs(int(one[2]) - int(two[2])) != 1:
        return False
    return _same_costs(a, b)


def _same_costs(a: CountTree, b: CountTree) -> bool:
    stack = [(a, b)]
    while stack:
        x, y = stack.pop()
        if x.kinds != y.kinds or list(x.parts) != list(y.parts):
            return False
        stack.extend(zip(x.parts.values(), y.parts.values(), strict=True))
    return True


def _bar(share: float) -> str:
    eighths = min(BAR * 8, round(max(0.0, share) * BAR * 8))
    whole, rest = divmod(eighths, 8)
    return "█" * whole + ("", "▏", "▎", "▍", "▌", "▋", "▊", "▉")[rest]


def _percent(used: float, limit: float) -> str:
    return f"{100 * used / limit:.0f} %"


def number(value: float) -> str:
    """Thousands apart: ``19 500``."""
    return f"{value:,.0f}".replace(",", " ") if math.isclose(value, round(value)) else f"{value:g}"


def _many(count: int, word: str) -> str:
    return f"{number(count)} {word}{'' if count == 1 else 's'}"
