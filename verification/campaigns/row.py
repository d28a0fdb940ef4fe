"""What is kept of one run: a row of the result."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields

from verification.campaigns.cases import Case
from verification.flights.faults import SENSORS

NEVER = -1
"""Frame of what did not happen."""
NAN = math.nan


@dataclass(frozen=True, slots=True)
class Row:
    """One run. Frames count from 0; NaN: does not apply.

    ``alpha_faulty``, ``vc_faulty``: sensors hit, as digits ("13"); ``*_confirmed_i``: first frame in which sensor i was
    confirmed faulty; ``*_onset``: first faulty frame. ``*_detectable``: a fault whose residual must exceed the
    threshold (`detectable`). Errors: absolute, estimate minus truth, after the start-up; ``vc_*`` over the frames in
    configurations I and II, ``vc_*_lost`` over those in III and IV. ``*_rms``: largest residual rms after the start-up.
    """

    run: int
    sheet: str
    runs: str
    flight: str
    aircraft: str
    start: int
    frames: int
    period: float
    seed: int
    category: str
    failure: str = ""
    """Why there is no result; empty: there is one."""
    wind_x: float = NAN  # [kt]
    wind_z: float = NAN  # [kt]
    wind_rate: float = NAN  # [kt/s]
    wind_inside: bool = False
    alpha_kind: str = ""
    alpha_faulty: str = ""
    alpha_amplitude: float = NAN  # [deg], [1]
    alpha_rate: float = NAN  # [deg/s]
    alpha_frequency: float = NAN  # [Hz]
    alpha_onset: int = NEVER
    alpha_detectable: bool = False
    alpha_confirmed_1: int = NEVER
    alpha_confirmed_2: int = NEVER
    alpha_confirmed_3: int = NEVER
    vc_kind: str = ""
    vc_faulty: str = ""
    vc_amplitude: float = NAN  # [kt], [1]
    vc_rate: float = NAN  # [kt/s]
    vc_frequency: float = NAN  # [Hz]
    vc_onset: int = NEVER
    vc_detectable: bool = False
    vc_confirmed_1: int = NEVER
    vc_confirmed_2: int = NEVER
    vc_confirmed_3: int = NEVER
    alpha_error_max: float = NAN  # [deg]
    alpha_error_mean: float = NAN  # [deg]
    vc_error_max: float = NAN  # [kt]
    vc_error_mean: float = NAN  # [kt]
    vc_error_max_lost: float = NAN  # [kt]
    vc_error_mean_lost: float = NAN  # [kt]
    alpha_rms: float = NAN  # [deg]
    vc_rms: float = NAN  # [kt]

    def confirmed(self, sensor: str) -> tuple[int, int, int]:
        """Frames in which the three sensors of a kind were confirmed."""
        if sensor == "alpha":
            return self.alpha_confirmed_1, self.alpha_confirmed_2, self.alpha_confirmed_3
        return self.vc_confirmed_1, self.vc_confirmed_2, self.vc_confirmed_3

    def hit(self, sensor: str) -> tuple[int, ...]:
        """Numbers of the faulty sensors of a kind."""
        return tuple(int(digit) for digit in (self.alpha_faulty if sensor == "alpha" else self.vc_faulty))

    def onset(self, sensor: str) -> int:
        """First faulty frame of a kind of sensor."""
        return self.alpha_onset if sensor == "alpha" else self.vc_onset

    def detected_at(self, sensor: str) -> int:
        """The frame in which the last of the faulty sensors was confirmed, after its onset; else NEVER."""
        confirmed, onset = self.confirmed(sensor), self.onset(sensor)
        frames = [confirmed[i - 1] for i in self.hit(sensor)]
        return max(frames) if frames and all(frame >= onset for frame in frames) else NEVER

    def delay(self, sensor: str) -> float:
        """From onset to detection [s]; NaN: there is no fault of this kind, or it was not detected."""
        frame = self.detected_at(sensor)
        return (frame - self.onset(sensor)) * self.period if frame != NEVER else NAN

    def missed(self, sensor: str) -> bool:
        """At least one faulty sensor of the kind was not detected."""
        return bool(self.hit(sensor)) and self.detected_at(sensor) == NEVER

    def wrong(self, sensor: str) -> bool:
        """A healthy sensor of the kind was confirmed, or a faulty one before its fault."""
        hit, onset = self.hit(sensor), self.onset(sensor)
        return any(
            frame != NEVER and (i not in hit or frame < onset)
            for i, frame in enumerate(self.confirmed(sensor), start=1)
        )


COLUMNS: tuple[tuple[str, str], ...] = tuple((f.name, str(f.type)) for f in fields(Row))
"""Name and type ("int", "float", "bool", "str") of every column of a result."""


def fault_columns(case: Case, period: float) -> dict[str, object]:
    """The columns of a row that say what the faults are."""
    found: dict[str, object] = {}
    for fault in case.faults:
        assert fault.sensor in SENSORS
        columns = {
            "kind": fault.kind,
            "faulty": "".join(map(str, fault.which)),
            "amplitude": NAN if fault.amplitude is None else fault.amplitude,
            "rate": NAN if fault.rate is None else fault.rate,
            "frequency": NAN if fault.frequency is None else fault.frequency,
            "onset": fault.onset_frame(period),
        }
        found |= {f"{fault.sensor}_{name}": value for name, value in columns.items()}
    return found
