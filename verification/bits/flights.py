"""Long rows of flagship inputs: flights one after another, with noise, faults, missing samples and odd numbers."""

from __future__ import annotations

import math

import numpy as np

from verification.flights import load_recording, random_fault, sensors, shipped_recordings

ORDER = ("alpha", "vc", "vg", "vz", "theta", "q", "ax", "az", "z")
ODD = np.array([math.nan, math.inf, -math.inf, 0.0, -0.0, 5e-324, -1e-310, 1e308, 1e-40])


def flagship_rows(frames: int, seed: int) -> np.ndarray:
    """(frames, 13): the flagship's inputs in the order of its ports."""
    rng = np.random.default_rng(seed)
    parts: list[np.ndarray] = []
    names = list(shipped_recordings())
    count = 0
    flight = 0
    while count < frames:
        recording = load_recording(names[flight % len(names)])
        faults = []
        if flight % 3:
            kind = ("bias", "runaway", "oscillation", "jamming", "noise", "non_return_to_zero")[flight % 6]
            sensor = "vc" if flight % 2 else "alpha"
            which = tuple(range(1, 1 + flight % 3))
            faults = [random_fault(seed + flight, kind, sensor, which, 15.0)]
        inputs = sensors(recording, seed=seed + flight, faults=faults).inputs()
        rows = np.column_stack([np.asarray(inputs[name]).reshape(len(inputs["vg"]), -1) for name in ORDER])
        parts.append(_with_gaps(rows, rng))
        count += len(rows)
        flight += 1
    return np.concatenate(parts)[:frames]


def _with_gaps(rows: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Odd numbers in some columns for some frames, here and there."""
    rows = rows.copy()
    for _ in range(8):
        start = int(rng.integers(0, len(rows)))
        length = int(rng.integers(1, 30))
        columns = rng.random(rows.shape[1]) < 0.3
        rows[start : start + length, columns] = rng.choice(ODD)
    return rows
