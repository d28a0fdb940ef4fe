"""Flights through the estimators of paper 004 for its figures: many readings at once, whole outputs, any parameters."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

import saoflow
from verification.flights import Fault, Recording, load_recording, sensors
from verification.reference.arrays import Array
from verification.results.fig4 import FAULT, FLIGHT, NOT_WITHIN

CALM, WIND = FLIGHT, "a320_wind_350kt_5000ft"
"""Both at 350 kt and 5000 ft, as the paper's runs of VI-A."""

SLOW = "a320_slow_190kt_3000ft"

SHEETS = ("cmhe_fte", "umhe_fte", "ekf_fte")
NAMES = {"cmhe_fte": "CMHE-FTE", "umhe_fte": "UMHE-FTE", "ekf_fte": "EKF-FTE"}

DEGREES = 180.0 / np.pi
SETTLED = 60
"""Frames after which residuals are looked at: those without decisions, and the evaluation window."""

WX_MAX = 60.0
"""[kt]: the bound of the horizontal wind."""

THRESHOLDS = {"alpha": 2.9, "vc": 12.0}
"""[deg], [kt]: paper 004, VI-B."""


def there_is(sheet: str) -> bool:
    """Whether a sheet of that name is shipped."""
    try:
        saoflow.load(sheet)
    except saoflow.DiagnosisError as problem:
        if all(d.code == "E602" for d in problem.diagnoses):
            return False
        raise
    return True


def run(sheet: str, flights: Sequence[Recording], parameters: Mapping[str, object] | None = None) -> dict[str, Array]:
    """All outputs of flights of one length, (flights, frames, ...), by native code where there is a C compiler."""
    loaded = saoflow.load(sheet, parameters=dict(parameters or {}))
    columns = [flight.inputs() for flight in flights]
    inputs = {name: np.stack([c[name] for c in columns]) for name in columns[0]}
    try:
        simulator = loaded.simulator(backend="c")
    except saoflow.DiagnosisError:
        simulator = loaded.simulator()
    return simulator.run(inputs)


@dataclass(frozen=True)
class Robustness:
    """A fault-free wind scenario through one sheet: largest rms of any residual over all noise seeds."""

    scenario: str
    sheet: str
    alpha: float
    """[deg]"""
    vc: float
    """[kt]"""


BOUND = 15.0
"""Scenario 3: the wind flight, -30 to 40 kt, with |W_x| assumed to stay below this [kt]."""


def robustness(sheets: Sequence[str], seeds: Sequence[int], duration: float) -> tuple[Robustness, ...]:
    """Fig. 3: every scenario through every sheet with the figure's p_w and q_w."""
    scenarios: tuple[tuple[str, str, dict[str, float]], ...] = (
        ("1: calm", CALM, {}),
        ("2: inside the bounds", WIND, {}),
        ("3: beyond the bounds", WIND, {"wx_max": BOUND}),
    )
    found = []
    for scenario, flight, bounds in scenarios:
        truth = load_recording(flight).part(0.0, duration)
        readings = [sensors(truth, seed) for seed in seeds]
        for sheet in sheets:
            given = {"p_w": 0.01, "q_w": 0.1, **(bounds if sheet == "cmhe_fte" else {})}
            out = run(sheet, readings, given)
            rms = [float(out[f"{s}_rms"][:, SETTLED:].max()) for s in ("alpha", "vc")]
            found.append(Robustness(scenario, sheet, rms[0] * DEGREES, rms[1]))
    return tuple(found)


@dataclass(frozen=True, eq=False)
class Runaway:
    """Fig. 4's fault through one sheet, (seeds, frames from the start of the recording)."""

    sheet: str
    onset: int
    period: float
    vc_true: Array  # (frames,)
    readings: Array  # (seeds, frames, 3)
    out: Mapping[str, Array]

    @property
    def delays(self) -> tuple[int | None, ...]:
        """By seed: frames from the onset until all three sensors are condemned; None: never."""
        every = self.out["vc_faulty"].min(axis=2) > 0.5
        return tuple(int(np.argmax(row)) - self.onset if row.any() else None for row in every)

    @property
    def at_bound(self) -> tuple[int | None, ...]:
        """By seed: frames from the onset until the wind estimate is within 2 % of 60 kt; None: never."""
        near = self.out["wx_hat"] > 0.98 * WX_MAX
        return tuple(int(np.argmax(row)) - self.onset if row.any() else None for row in near)

    @property
    def vc_error(self) -> Array:
        """(seeds, frames) [kt]."""
        error: Array = self.out["vc_hat"] - self.vc_true
        return error


def runaway(
    sheet: str, seeds: Sequence[int], duration: float = 45.0, fault: Fault = FAULT, flight: str = CALM
) -> Runaway:
    """Three airspeed sensors run away together."""
    truth = load_recording(flight).part(0.0, duration)
    readings = [sensors(truth, seed, faults=[fault]) for seed in seeds]
    vc = np.stack([r.inputs()["vc"] for r in readings])
    return Runaway(sheet, fault.onset_frame(truth.period), truth.period, truth["vc_true"], vc, run(sheet, readings))


@dataclass(frozen=True)
class Scenario:
    """Where the runaways of Fig. 5 begin."""

    name: str
    flight: str
    onset: float
    """[s]"""


SCENARIOS = (
    Scenario("1: calm", CALM, 20.0),
    Scenario("2: 40 kt tail wind", WIND, 52.0),
    Scenario("2: 30 kt head wind", WIND, 20.0),
)


@dataclass(frozen=True)
class Rate:
    """Fig. 5: one rate of the runaway, one estimator: rms of the airspeed residuals, the mean of 370 frames [kt]."""

    scenario: str
    sheet: str
    q_w: float
    rate: float
    """[kt/s], downwards."""
    rms: float


def rates(
    scenario: Scenario, sheets: Sequence[str], weights: Sequence[float], tried: Sequence[float]
) -> tuple[Rate, ...]:
    """Fig. 5: the residual in the 370 frames after three airspeed sensors begin to run away, at every rate; seed 1."""
    truth = load_recording(scenario.flight)
    first = replace(FAULT, onset=scenario.onset).onset_frame(truth.period)
    truth = truth.part(0.0, (first + NOT_WITHIN + 1) * truth.period)
    readings = [sensors(truth, 1, faults=[replace(FAULT, rate=-rate, onset=scenario.onset)]) for rate in tried]
    found = []
    for sheet in sheets:
        for q_w in weights:
            out = run(sheet, readings, {"q_w": q_w, "p_w": 0.01})
            rms = out["vc_rms"][:, first : first + NOT_WITHIN].mean(axis=(1, 2))
            found += [
                Rate(scenario.name, sheet, q_w, rate, float(value)) for rate, value in zip(tried, rms, strict=True)
            ]
    return tuple(found)


@dataclass(frozen=True)
class Jamming:
    """Fig. 6(a): two AOA and two airspeed sensors jammed near their true values."""

    flight: str
    amplitude: tuple[float, float]
    """Away from the true values at the onset [deg], [kt]: below the thresholds."""
    alpha: tuple[float | None, float | None, float | None]
    """Delay of each sensor's isolation [s]; the third is healthy."""
    vc: tuple[float | None, float | None, float | None]

    def verdict(self, sensor: str) -> str:
        """ "right": both jammed ones found and the healthy one kept; "wrong": the healthy one condemned; "missed"."""
        first, second, healthy = self.alpha if sensor == "alpha" else self.vc
        if healthy is not None:
            return "wrong"
        return "missed" if first is None or second is None else "right"

    def delay(self, sensor: str) -> float:
        """The later of the two; NaN unless right."""
        first, second, _ = self.alpha if sensor == "alpha" else self.vc
        return (
            max(first, second)
            if self.verdict(sensor) == "right" and first is not None and second is not None
            else np.nan
        )


def jamming(
    flights: Sequence[str], amplitudes: Sequence[tuple[float, float]], onset: float = 6.0, seed: int = 1
) -> tuple[Jamming, ...]:
    """Fig. 6(a) on flights that manoeuvre, at every amplitude."""
    found = []
    for flight in flights:
        truth = load_recording(flight)
        readings = [jammed(truth, amplitude, onset, seed) for amplitude in amplitudes]
        out = run("cmhe_fte", readings)
        for i, amplitude in enumerate(amplitudes):
            delays = [_delays(out[f"{s}_faulty"][i], onset, truth.period) for s in ("alpha", "vc")]
            found.append(Jamming(flight, amplitude, *delays))
    return tuple(found)


def jammed(truth: Recording, amplitude: tuple[float, float], onset: float = 6.0, seed: int = 1) -> Recording:
    """Readings of a flight with sensors 1 and 2 of both kinds jammed, so far beside their readings at the onset."""
    pairs = zip(("alpha", "vc"), amplitude, strict=True)
    return sensors(truth, seed, faults=[Fault("jamming", s, (1, 2), amplitude=a, onset=onset) for s, a in pairs])


def _delays(faulty: Array, onset: float, period: float) -> tuple[float | None, float | None, float | None]:
    one, two, three = (
        float(np.argmax(column) * period - onset) if column.any() else None for column in (faulty > 0.5).T
    )
    return one, two, three
