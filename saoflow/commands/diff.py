"""The command ``saoflow diff``."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Annotated

import typer

from saoflow.commands.shell import BAD_INPUT, FAILED, Findings, Json, Set, console, finish, load_sheet

if TYPE_CHECKING:
    from saoflow.authoring.difference import Change
    from saoflow.scheduler.budget_change import BudgetChange

MOST = 200
"""Differences that are shown; ``--json`` has them all."""
SIGNS = {"added": "+", "removed": "-", "changed": "~", "renamed": "="}


def diff(
    before: Annotated[str, typer.Argument(metavar="A", help="The sheet as it was.", show_default=False)],
    after: Annotated[str, typer.Argument(metavar="B", help="The sheet as it is.", show_default=False)],
    settings: Set = None,
    json: Json = False,
) -> None:
    """What differs in meaning between two sheets: blocks, wires, parameters, shapes, units, cost.

    Comments, texts, the order of lines and the names of blocks are no difference. Exits 0 if the sheets mean the same, 1 if
    they differ, 2 if one of them cannot be compared. `--set` holds for both.

    Example: saoflow diff umhe_fte cmhe_fte
    """
    from saoflow.authoring.difference import difference
    from saoflow.scheduler.budget_change import compare_budgets

    findings = Findings()
    sheets = [load_sheet(name, settings, findings) for name in (before, after)]
    first, second = sheets
    if first is None or second is None:
        finish(findings.found, json)
        raise typer.Exit(BAD_INPUT)
    found = difference(first.netlist, second.netlist)
    cost = findings.attempt(lambda: compare_budgets(first.budget(), second.budget(), before, depth=4))
    if cost is None:
        finish(findings.found, json)
        raise typer.Exit(BAD_INPUT)
    same = found.same
    facts = {
        "before": before,
        "after": after,
        "same": same,
        "changes": [change.to_dict() for change in found.changes],
        "cost": cost.to_dict(),
    }
    if not json:
        print("\n".join(_lines(found.changes, f"{before} and {after} {'mean the same' if same else 'differ'}")))
        _cost(cost)
    finish(findings.found, json, facts)
    if not same:
        raise typer.Exit(FAILED)


def _lines(changes: list[Change], verdict: str) -> Iterator[str]:
    yield verdict
    for change in changes[:MOST]:
        place = f"  ({change.place})" if change.place is not None else ""
        yield f"  {SIGNS[change.what]} {change.part} {change.path}: {_words(change)}{place}"
    if len(changes) > MOST:
        yield f"  {len(changes) - MOST} further differences; --json lists them all"


def _words(change: Change) -> str:
    if change.what == "added":
        return change.after or "added"
    if change.what == "removed":
        return change.before or "removed"
    if change.what == "renamed":
        return f"`{change.before}` is `{change.after}`"
    return f"{change.before or 'none'} -> {change.after or 'none'}"


def _cost(cost: BudgetChange) -> None:
    if all(kind.before == kind.after for kind in cost.kinds):
        return
    from saoflow.print_change import print_change

    print()
    print_change(cost, console())
