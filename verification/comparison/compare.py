"""The comparison itself: every variant flies the same campaign, and each becomes one entry."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path

from saoflow.diagnosis import Diagnosis
from verification.campaigns.check import check_campaign
from verification.campaigns.metrics import Group, SheetMetrics, metrics_of
from verification.campaigns.plan import Campaign, Variant
from verification.campaigns.run import Progress, run_campaign
from verification.campaigns.store import rows_of
from verification.comparison.cost import costs_of


@dataclass(frozen=True)
class Entry:
    """One variant. Errors: mean absolute ones over the fault-free and the faulty runs [deg, kt], as in Table III."""

    label: str
    operations: int
    microseconds: float
    budget: float | None
    """Operations a frame: the one asked for, else the sheet's own."""
    alpha_error: float
    vc_error: float
    alpha_error_faulty: float
    vc_error_faulty: float
    found: float
    """Of the faults of one kind of sensor in one run: how many had all their sensors confirmed [%]."""
    must_missed: int
    """Missed among those that must be found."""
    delay: float
    """Mean detection delay of fast faults that must be found, both kinds of sensors [s]."""
    false_alarms: int
    """Fault-free runs with a confirmed sensor."""
    wrong: int
    """Faulty runs with a confirmed healthy sensor, AOA and VCAS counted apart."""
    failed: int

    @property
    def fits(self) -> bool | None:
        """Whether it is inside the budget; None: there is none."""
        return None if self.budget is None else self.operations <= self.budget


@dataclass(frozen=True)
class Comparison:
    """All entries, in the order in which they were named."""

    campaign: str
    fault_free: int
    faulty: int
    budget: float | None
    """Operations a frame that were asked for; None: each sheet's own budget counts."""
    entries: tuple[Entry, ...]
    warnings: tuple[Diagnosis, ...]

    def to_dict(self) -> dict[str, object]:
        """For JSON."""
        entries = [
            {**{k: None if v != v else v for k, v in asdict(entry).items()}, "fits": entry.fits}
            for entry in self.entries
        ]
        return {
            "campaign": self.campaign,
            "fault_free": self.fault_free,
            "faulty": self.faulty,
            "budget": self.budget,
            "entries": entries,
        }


def compare(
    variants: Sequence[Variant],
    campaign: Campaign,
    budget: float | None = None,
    workers: int | None = None,
    folder: str | os.PathLike[str] | None = None,
    progress: Progress | None = None,
) -> Comparison:
    """Fly ``campaign`` with every variant in place of its own sheets. ``budget``: operations a frame.

    ``folder`` keeps the runs, and a second call goes on from them; without one they are kept nowhere. Raises
    DiagnosisError as loading, checking and running a campaign do.
    """
    plan = replace(campaign, sheets=tuple(variants))
    check_campaign(plan)
    costs = costs_of(variants)
    if folder is None:
        with tempfile.TemporaryDirectory(prefix="saoflow-compare-") as temporary:
            outcome = run_campaign(plan, Path(temporary) / "runs", workers, progress=progress)
            metrics = metrics_of(rows_of(outcome.results))
    else:
        outcome = run_campaign(plan, folder, workers, progress=progress)
        metrics = metrics_of(rows_of(outcome.results))
    entries = []
    for variant, cost, found in zip(variants, costs, metrics, strict=True):
        limit = cost.own_budget if budget is None else budget
        entries.append(_entry(variant.label, cost.operations, cost.microseconds, limit, found))
    first = metrics[0]
    return Comparison(campaign.name, first.fault_free.runs, first.faulty.runs, budget, tuple(entries), outcome.warnings)


def _entry(label: str, operations: int, microseconds: float, limit: float | None, metrics: SheetMetrics) -> Entry:
    free, faulty = metrics.fault_free, metrics.faulty
    hit = faulty.alpha.hit + faulty.vc.hit
    missed = faulty.alpha.missed + faulty.vc.missed
    return Entry(
        label,
        operations,
        microseconds,
        limit,
        free.alpha.error[1],
        free.vc.error[1],
        faulty.alpha.error[1],
        faulty.vc.error[1],
        100.0 * (hit - missed) / hit if hit else float("nan"),
        faulty.alpha.detectable_missed + faulty.vc.detectable_missed,
        _delay(faulty),
        free.alpha.wrong + free.vc.wrong,
        faulty.alpha.wrong + faulty.vc.wrong,
        free.failed + faulty.failed,
    )


def _delay(faulty: Group) -> float:
    both = (faulty.alpha.fast_delay, faulty.vc.fast_delay)
    count = sum(delay.count for delay in both)
    return sum(delay.count * delay.mean for delay in both if delay.count) / count if count else float("nan")


def pareto(entries: Sequence[Entry], cost: str, value: str, larger_is_better: bool = False) -> tuple[Entry, ...]:
    """The entries that no other beats in both: at most the cost and at least as good, one of them strictly.

    Values count to three significant digits: the fourth depends on the flights. ``cost``, ``value``: names of fields.
    Entries without a value (NaN) are left out. In order of cost.
    """
    sign = -1.0 if larger_is_better else 1.0
    values = [float(f"{getattr(entry, value):.3g}") for entry in entries]
    points = [(getattr(e, cost), sign * v, e) for e, v in zip(entries, values, strict=True) if v == v]
    best = [
        (c, v, e) for c, v, e in points if not any(c2 <= c and v2 <= v and (c2 < c or v2 < v) for c2, v2, _ in points)
    ]
    return tuple(e for _, _, e in sorted(best, key=lambda point: point[:2]))
