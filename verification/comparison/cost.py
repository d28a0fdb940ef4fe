"""What a frame of a sheet costs: operations, counted, and time in compiled C, measured on this machine."""

from __future__ import annotations

import statistics
import time
from collections.abc import Sequence
from dataclasses import dataclass, replace

from verification.campaigns.plan import Variant
from verification.campaigns.sheets import load_variant
from verification.campaigns.work import simulator_of
from verification.flights import load_recording, sensors
from verification.recordings.recording import Array

ROUNDS = 7
SECONDS = 0.05
"""Processor time of a round, about."""
FLIGHT = "a320_wind_350kt_5000ft"


@dataclass(frozen=True)
class Cost:
    """Of one frame of one flight."""

    operations: int
    own_budget: float | None
    """Operations that the sheet's own budget allows."""
    microseconds: float
    """Processor time, the median of several rounds."""


def costs_of(variants: Sequence[Variant]) -> list[Cost]:
    """The variants take turns, so that what else the machine does is shared. Raises DiagnosisError as loading does."""
    counted = [_operations(variant) for variant in variants]
    inputs = sensors(load_recording(FLIGHT).part(0.0, 30.0), seed=1).inputs()
    times: list[list[float]] = [[] for _ in variants]
    for _ in range(ROUNDS):
        for variant, found in zip(variants, times, strict=True):
            found.append(_round(variant, inputs))
    return [Cost(*count, 1e6 * statistics.median(found)) for count, found in zip(counted, times, strict=True)]


def _operations(variant: Variant) -> tuple[int, float | None]:
    report = load_variant(replace(variant, unlimited=False)).budget()
    return report.total, next((line.limit for line in report.lines if line.kind == "operations"), None)


def _round(variant: Variant, inputs: dict[str, Array]) -> float:
    """Processor seconds a frame."""
    simulator = simulator_of(variant)
    frames = len(inputs["vg"])
    simulator.reset()
    start, done = time.process_time(), 0
    while (used := time.process_time() - start) < SECONDS:
        simulator.run(inputs)
        done += frames
    return used / done
