"""What is flown: the condition and the fault of Fig. 4 of paper 004."""

from __future__ import annotations

from dataclasses import dataclass, field

from verification.flights import Fault, Recording, load_recording, sensors


@dataclass(frozen=True)
class Scenario:
    """A shipped flight, the seed of its sensor noise, and a fault.

    The defaults are the paper's Fig. 4: 350 kt, 5000 ft, calm; all three airspeed sensors run away at -15 kt/s.
    ``duration`` [s]: a little longer than the 370 frames (17.76 s) after the onset that the paper shows, and not so
    long that the readings leave the range of an air data computer (20 kt, after 22 s).
    """

    flight: str = "a320_calm_350kt_5000ft"
    seed: int = 1
    fault: Fault = field(default_factory=lambda: Fault("runaway", "vc", (1, 2, 3), rate=-15.0, onset=20.0))
    duration: float = 41.9

    def record(self) -> Recording:
        """The readings of the sensors, with the truth beside them.

        Raises DiagnosisError E713 for a negative seed.
        """
        truth = load_recording(self.flight).part(0.0, self.duration)
        return sensors(truth, self.seed, faults=[self.fault])

    @property
    def onset_frame(self) -> int:
        """The first faulty frame."""
        return self.fault.onset_frame(0.048)


WITHIN = 6.0
"""CMHE-FTE is to confirm the fault within so many seconds of its onset (the paper: about 4 s)."""

FRAMES_SHOWN = 370
"""UMHE-FTE is not to confirm it within so many frames: as many as the paper shows, 17.76 s."""
