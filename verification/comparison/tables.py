"""The table of a comparison."""

from __future__ import annotations

from verification.campaigns.tables import Table, number
from verification.comparison.compare import Comparison, Entry, pareto
from verification.comparison.picture import QUALITIES

HEADS = (
    "sheet",
    "ops a frame",
    "budget",
    "time [us]",
    "AOA [deg]",
    "faulty",
    "VCAS [kt]",
    "faulty",
    "found [%]",
    "must, missed",
    "delay [s]",
    "false alarms",
    "wrong",
    "best in",
)


def table_of(comparison: Comparison) -> Table:
    """One row for each entry."""
    best = {
        quality.field: pareto(comparison.entries, "operations", quality.field, quality.more_is_better)
        for quality in QUALITIES
    }
    rows = tuple(
        _row(entry, [field for field, found in best.items() if entry in found]) for entry in comparison.entries
    )
    note = (
        f"Campaign {comparison.campaign}: {comparison.fault_free} fault-free and {comparison.faulty} faulty runs a sheet. "
        "AOA, VCAS: mean absolute errors, fault-free and faulty, after the start-up (VCAS without categories III and IV). "
        "Found: faults of one kind of sensor all of whose sensors were confirmed; must, missed: of those that must be found; "
        "delay: mean over fast faults that must be found. Wrong: faulty runs with a healthy sensor condemned. Best in: no "
        "other has fewer operations and is as good, to three digits. Time: a frame of one flight in C on this machine."
    )
    return Table("Comparison", HEADS, rows, note)


_SHORT = {"alpha_error_faulty": "AOA", "vc_error_faulty": "VCAS", "found": "found", "delay": "delay"}


def _row(entry: Entry, best: list[str]) -> tuple[str, ...]:
    fits = {None: "-", True: "fits", False: "over"}[entry.fits]
    failed = f" ({entry.failed} runs failed)" if entry.failed else ""
    return (
        entry.label + failed,
        str(entry.operations),
        fits,
        number(entry.microseconds),
        number(entry.alpha_error, 3),
        number(entry.alpha_error_faulty, 3),
        number(entry.vc_error, 3),
        number(entry.vc_error_faulty, 3),
        number(entry.found, 1),
        str(entry.must_missed),
        number(entry.delay),
        str(entry.false_alarms),
        str(entry.wrong),
        ",".join(_SHORT[field] for field in best) or "-",
    )
