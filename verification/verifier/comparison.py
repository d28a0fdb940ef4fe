"""The measure of a difference, and the record of its worst over many runs."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from verification.verifier.case import Array, Scenario
from verification.verifier.report import Check, Place


def relative_difference(got: Array, right: Array, sigma: Array | float) -> Array:
    """Return |got - right| / max(|right|, sigma), element-wise.

    Equal values, two NaN and infinities of one sign differ by 0; anything else that is not finite by infinity.
    """
    with np.errstate(all="ignore"):
        difference = np.abs(got - right) / np.maximum(np.abs(right), sigma)
    difference = np.where(np.isnan(difference), np.inf, difference)
    same = (got == right) | (np.isnan(got) & np.isnan(right))
    result: Array = np.where(same, 0.0, difference)
    return result


@dataclass
class Worst:
    """The worst difference of one quantity so far."""

    ratio: float = 0.0
    largest: float = 0.0
    frames: int = 0
    where: Place | None = None

    def see(self, scenario: Scenario, frames: Array, got: Array, right: Array, ratio: Array) -> None:
        """Take in the rows of one scenario: ``frames`` (n,) their numbers, the others (n, ...)."""
        self.frames += len(frames)
        if not ratio.size:
            return
        flat = int(np.argmax(ratio))
        worst = float(ratio.flat[flat])
        if self.where is not None and worst <= self.ratio:
            return
        row, *element = (int(i) for i in np.unravel_index(flat, ratio.shape))
        frame = int(frames[row])
        values = float(got.flat[flat]), float(right.flat[flat])
        self.where = Place(scenario.name, frame, scenario.first_frame + frame, tuple(element), *values)
        self.ratio = worst
        with np.errstate(all="ignore"):
            self.largest = float(np.nan_to_num(np.abs(got.flat[flat] - right.flat[flat]), nan=np.inf))

    def check(
        self, part: str, quantity: str, wire: str, unit: str, tolerance: str, judged: bool = True, repeat: str = ""
    ) -> Check:
        """The finished check: it holds if it was compared at all and nowhere exceeds what is allowed."""
        passed = (self.ratio <= 1.0 and self.frames > 0) if judged else None
        numbers = self.largest, self.ratio
        return Check(part, quantity, wire, unit, *numbers, tolerance, self.frames, self.where, passed, repeat)
