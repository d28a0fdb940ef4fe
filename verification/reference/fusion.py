"""Step 2 of paper 004, III-A: the adaptively weighted fusion (19), and the configuration of Table I."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from verification.reference.arrays import Array, Mask
from verification.reference.conditioning import Conditioned
from verification.reference.residuals import Judgement
from verification.reference.tuning import Tuning


@dataclass(frozen=True)
class Fused:
    """The fused measurements of alpha and V_c."""

    value: Array  # (2,), rad and m/s
    present: Mask  # (2,), at least one sensor was fused
    lost: Mask  # (2,), all three sensors are confirmed faulty
    configuration: int  # 1 to 4, Table I


def fuse(inputs: Conditioned, judgement: Judgement, prediction: Array, tuning: Tuning) -> Fused:
    """Fuse the sensors that are present, not confirmed faulty and not above the threshold now; else those in doubt.

    J is floored: at the first frame it is 0, and 1/J^2 would let one sensor decide alone. Where no sensor
    is left, (19) is 0/0: the value is the prediction, and `present` says that it must not count.
    """
    usable = inputs.sensors_valid & ~judgement.faulty
    trusted = usable & ~judgement.over
    fused = np.where(trusted.any(axis=1, keepdims=True), trusted, usable & judgement.doubtful)
    weight = np.where(fused, 1.0 / np.maximum(judgement.rms, tuning.floor) ** 2, 0.0)
    total = weight.sum(axis=1)
    present = np.any(fused, axis=1)
    mean = (weight * inputs.sensors).sum(axis=1) / np.where(present, total, 1.0)
    lost = np.all(judgement.faulty, axis=1)
    configuration = 1 + int(lost[0]) + 2 * int(lost[1])
    return Fused(np.where(present, mean, prediction), present, lost, configuration)
