"""The one exception of flights, sensors and recordings.

Every refusal of this package is a :class:`FlightError` with a stable code, so that a caller can tell them
apart and a user can look them up. All codes are listed here and nowhere else.
"""

from __future__ import annotations

from collections.abc import Iterable
from difflib import get_close_matches

CODES: dict[str, str] = {
    "E701": "no flight of that name",
    "E702": "no aircraft of that name",
    "E703": "jsbsim is missing or of another version",
    "E704": "the aircraft left the range that the autopilot can hold",
    "E705": "a flight plan makes no sense",
    "E711": "a fault makes no sense",
    "E712": "a fault's text cannot be read",
    "E713": "the sensor noise makes no sense",
    "E714": "missing samples make no sense",
    "E721": "no shipped recording of that name",
    "E722": "a recording has no such column",
    "E723": "a recording file cannot be read",
    "E724": "a recording file cannot be written",
    "E725": "a recording makes no sense",
}


class FlightError(Exception):
    """Bad input to flights, sensors or recordings.

    Attributes: ``code`` (a key of :data:`CODES`), ``message`` (what is wrong, one line), ``cause`` and
    ``remedy`` (one line each), ``hint`` (a did-you-mean, or empty).
    """

    def __init__(self, code: str, message: str, *, cause: str, remedy: str, hint: str = "") -> None:
        assert code in CODES, code
        self.code = code
        self.message = message
        self.cause = cause
        self.remedy = remedy
        self.hint = hint
        super().__init__(message)

    def __str__(self) -> str:
        """The diagnosis as saoflow prints it: headline, cause, remedy, did-you-mean."""
        lines = [f"error[{self.code}]: {self.message}", f"    = cause: {self.cause}"]
        lines.append(f"    = remedy: {self.remedy}")
        if self.hint:
            lines.append(f"    = {self.hint}")
        return "\n".join(lines)

    def to_dict(self) -> dict[str, str]:
        """The machine-readable form (``--json``)."""
        return {
            "code": self.code,
            "severity": "error",
            "message": self.message,
            "cause": self.cause,
            "remedy": self.remedy,
            "hint": self.hint,
        }


def did_you_mean(word: str, known: Iterable[str]) -> str:
    """``did you mean 'x'?`` for the known word nearest to ``word``, or an empty string."""
    names = {name.lower(): name for name in known}
    near = get_close_matches(word.lower(), list(names), n=1, cutoff=0.5)
    return f"did you mean '{names[near[0]]}'?" if near else ""
