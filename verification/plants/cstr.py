"""The reactor of paper 001 in closed loop, with noise by seed: 250 steps, as in its Section V.

What the paper leaves open, and what is done here:

- The step is h = 0.5 (theta/40). The noises stand in the right-hand sides, as printed, so a step moves the state by h w.
  With h = 1 the reactor goes out in 14 of the first 20 runs; with h = 0.25 a step moves the temperature no more than its
  measurement errs.
- Implicit Euler is solved by Newton's method to rounding.
- The set-points are the two that balance (Hicks and Ray): (0.0944, 0.7766) with u = 340 in the first half and
  (0.1367, 0.7293) with u = 390 in the second. The run starts on the second, so that both halves begin with a change.
- The controller is proportional and acts on the measured temperature: u = u_s + 5000 (y - T_s), limited to 0 ... 2000.
  In seeds 1 to 50 the concentration passes 0.8, where the reactor is all but out, in one run (with a gain of 1500: in ten).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from verification.reference.arrays import Array
from verification.reference.cstr.reactor import step
from verification.reference.cstr.tuning import Tuning

STEPS = 250
"""Steps of a run, as in the paper."""

PASSES = 60
"""Newton passes of a step of the plant; it is at rounding long before."""


@dataclass(frozen=True)
class SetPoint:
    """A balance of the right-hand sides, to four digits."""

    concentration: float
    temperature: float
    flow: float


HOT = SetPoint(0.0944, 0.7766, 340.0)
COOL = SetPoint(0.1367, 0.7293, 390.0)
GAIN = 5000.0
"""Flow per temperature of the controller."""


@dataclass(frozen=True)
class Run:
    """A closed-loop run; row t is time t."""

    x: Array  # (steps + 1, 2), the true states
    y: Array  # (steps + 1,), the measured temperatures
    u: Array  # (steps,), what acts from t to t + 1
    w: Array  # (steps, 2), the noises of the right-hand sides

    @property
    def recording(self) -> dict[str, Array]:
        """The inputs of the sheets, one row a frame: y_t, and u_{t-1} (in the first frame u_0, which is not used)."""
        return {"y": self.y, "u": np.append(self.u[:1], self.u)}


def simulate(
    seed: int, *, steps: int = STEPS, noise: float = 1.0, start: SetPoint = COOL, tuning: Tuning | None = None
) -> Run:
    """Run the reactor in closed loop from a state; ``noise`` scales all noises. The same seed gives the same noise."""
    tuning = tuning or Tuning()
    generator = np.random.default_rng([seed, 1])
    w = noise * generator.normal(size=(steps, 2)) * (tuning.sigma_w1, tuning.sigma_w2)
    v = noise * generator.normal(size=steps + 1) * tuning.sigma_y
    x = [np.array([start.concentration, start.temperature])]
    y, u = [x[0][1] + v[0]], []
    for t in range(steps):
        aim = HOT if t < steps // 2 else COOL
        u.append(float(np.clip(aim.flow + GAIN * (y[t] - aim.temperature), 0.0, tuning.u_max)))
        x.append(step(x[t], u[t], tuning, w[t], PASSES))
        y.append(x[t + 1][1] + v[t + 1])
    return Run(np.array(x), np.array(y), np.array(u), w)
