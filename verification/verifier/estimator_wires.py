"""Where the quantities of the reference stand in the sheets cmhe_fte and umhe_fte: paths of wires, in one place."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from verification.reference.arrays import Array
from verification.reference.estimator import State
from verification.reference.tuning import Tuning
from verification.verifier.case import Values

SENSORS = ("alpha", "vc")


def taps(window: str, count: int) -> tuple[str, ...]:
    """The remembered samples of a window (sheets `window` and `last`), oldest first."""
    return tuple(f"{window}.past[{i}].before" for i in range(count))


@dataclass(frozen=True)
class StateWires:
    """The outputs of the sheets' delays: what :class:`verification.reference.estimator.State` holds."""

    held: str
    started: str
    inhibit_count: str
    x_warm: str
    u_warm: str
    theta_past: tuple[str, ...]
    y_past: tuple[str, ...]
    mask_past: tuple[str, ...]
    residuals: tuple[tuple[str, ...], ...]
    """One tuple of taps for alpha, one for vc; `bads` and `faulty` likewise."""
    squares_held: tuple[tuple[str, ...], ...]
    bads: tuple[tuple[str, ...], ...]
    aparts: tuple[tuple[str, ...], ...]
    rms_before: tuple[str, ...]
    wind_held: tuple[str, ...]
    doubtful: tuple[str, ...]
    faulty: tuple[str, ...]

    @property
    def all(self) -> tuple[str, ...]:
        """Every wire."""
        single = (self.held, self.started, self.inhibit_count, self.x_warm, self.u_warm, *self.wind_held)
        windows = (self.theta_past, self.y_past, self.mask_past, self.rms_before, self.doubtful, self.faulty)
        of_sensors = (*self.residuals, *self.squares_held, *self.bads, *self.aparts)
        return (*single, *(wire for window in (*windows, *of_sensors) for wire in window))

    def state(self, values: Values) -> State:
        """The reference's state from one frame of wire values."""

        def stack(wires: tuple[str, ...]) -> Array:
            return np.array([values[wire] for wire in wires])

        def both(wires: tuple[tuple[str, ...], ...]) -> Array:
            return np.stack([stack(of_sensor) for of_sensor in wires], axis=1)

        return State(
            held=values[self.held],
            started=bool(values[self.started]),
            inhibit_count=round(float(values[self.inhibit_count])),
            x_warm=values[self.x_warm],
            u_warm=values[self.u_warm],
            theta_past=stack(self.theta_past),
            y_past=stack(self.y_past),
            mask_past=stack(self.mask_past),
            residuals=both(self.residuals),
            squares_held=both(self.squares_held),
            bads=both(self.bads).astype(bool),
            aparts=both(self.aparts).astype(bool),
            rms_before=stack(self.rms_before),
            wind_held=stack(self.wind_held),
            doubtful=stack(self.doubtful).astype(bool),
            faulty=stack(self.faulty).astype(bool),
        )


def state_wires(tuning: Tuning) -> StateWires:
    """Where cmhe_fte and umhe_fte remember: their Steps 0 to 2 are the same sheets."""
    past, evaluated = tuning.n_horizon - 1, tuning.n_eval - 1
    return StateWires(
        held="now.held.held",
        started="start.started_before",
        inhibit_count="start.count_before",
        x_warm="warm.x_before",
        u_warm="warm.u_before",
        theta_past=taps("Theta_window", past),
        y_past=taps("y_window", past),
        mask_past=taps("present_window", past),
        residuals=tuple(taps(f"{sensor}_check.J.past", evaluated) for sensor in SENSORS),
        bads=tuple(taps(f"{sensor}_check.decision.count.sum.past", evaluated) for sensor in SENSORS),
        squares_held=tuple(taps(f"{sensor}_check.sum_held.past", evaluated) for sensor in SENSORS),
        aparts=tuple(taps(f"{sensor}_wind.count.sum.past", evaluated) for sensor in SENSORS),
        rms_before=tuple(f"{sensor}_check.J_before" for sensor in SENSORS),
        wind_held=tuple(f"{sensor}_wind.before" for sensor in SENSORS),
        doubtful=tuple(f"{sensor}_check.doubtful_before" for sensor in SENSORS),
        faulty=tuple(f"{sensor}_check.decision.before" for sensor in SENSORS),
    )
