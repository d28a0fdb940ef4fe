"""The demonstration's last screen."""

from __future__ import annotations

from rich.console import Console
from rich.table import Table
from rich.text import Text

from verification.demo.facts import facts
from verification.demo.result import DemoResult


def print_summary(result: DemoResult, files: tuple[str, ...], console: Console | None = None) -> None:
    """What was found, and where it is written, on standard output."""
    out = console or Console(highlight=False)
    fault = result.scenario.fault
    out.print()
    out.print(Text("Three airspeed sensors run away", style="bold"), end="")
    out.print(
        f": A320, 350 kt, 5000 ft, calm; {fault.rate:g} kt/s from t = {fault.onset:g} s; noise of seed {result.scenario.seed}"
    )
    table = Table(box=None, show_header=False, padding=(0, 1), pad_edge=False)
    table.add_column(width=1)
    table.add_column(style="dim", no_wrap=True)
    table.add_column()
    for fact in facts(result):
        verdict = (
            Text("")
            if fact.holds is None
            else Text("\N{CHECK MARK}", "green")
            if fact.holds
            else Text("\N{BALLOT X}", "bold red")
        )
        table.add_row(verdict, fact.label, fact.text)
    table.add_row("", "written", ", ".join(files))
    out.print(table)
    if not result.holds:
        out.print(Text("Something claimed does not hold.", style="bold red"))
