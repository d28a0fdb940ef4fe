"""A frame's cost on a target as text for a terminal."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from saoflow.targets.frame_cost import CAVEAT, FORMS, FormCost, FrameCost

if TYPE_CHECKING:
    from rich.console import Console

MOST_BODIES = 6
"""Bodies shown by name, the dearest first."""


def print_cost(cost: FrameCost, console: Console) -> None:
    """The two ways, what part of the frame period they take, the dearest bodies, and what the number is not."""
    for line in cost_lines(cost):
        console.print(line, markup=False, soft_wrap=True)


def cost_lines(cost: FrameCost) -> Iterator[str]:
    """The lines of the report."""
    clock = f"{cost.clock_mhz:g} MHz"
    if cost.assumed_clock:
        clock += f" ({cost.target.clock_source}; --clock MHZ for another)"
    yield ""
    yield f"{cost.sheet} on {cost.target.name}: {cost.target.title}, binary{cost.real}, {clock}"
    period = "" if cost.period is None else f"{'of ' + format(cost.period * 1e3, 'g') + ' ms':>14}"
    yield f"  {'':<34}{'instructions':>13}{'cycles':>11}{'time':>11}{period}"
    for form in cost.forms:
        yield f"  {FORMS[form.form]:<34}{_number(form.instructions):>13}{_number(form.cycles):>11}" + _time(cost, form)
    if cost.share is not None and cost.period is not None:
        verdict = "OVER" if cost.over else "within"
        allowed = cost.share * cost.period * 1e6
        yield f"  {verdict} the share given: {100 * cost.share:g} % of the frame, {allowed:.0f} us (every operand from memory)"
    yield from _bodies(cost.forms[-1])
    yield f"  {CAVEAT}"
    yield f"  Calibration: {cost.target.instruction_set.calibrated} (docs/cost_model.md)."
    for note in cost.target.notes:
        yield f"  {note}"


def _time(cost: FrameCost, form: FormCost) -> str:
    part = cost.part_of_period(form)
    return f"{cost.microseconds(form):>8.1f} us" + ("" if part is None else f"{100 * part:>12.2f} %")


def _bodies(form: FormCost) -> Iterator[str]:
    dearest = sorted(form.bodies, key=lambda b: -b.times * b.cycles)[:MOST_BODIES]
    if len(dearest) < 2:
        return
    yield f"  where the cycles go ({FORMS[form.form]}):"
    for b in dearest:
        part = b.times * b.cycles / max(1, form.cycles)
        each = "" if b.times == 1 else f"{b.times} x {_number(b.cycles)}"
        yield f"    {b.name:<32}{_number(b.times * b.cycles):>13}{100 * part:>9.1f} %  {each}".rstrip()


def _number(n: int) -> str:
    return f"{n:,}".replace(",", " ")
