"""Faults and gaps as text, for the command line.

vc:runaway:-15:onset=20                        three airspeed sensors run away at -15 kt/s from 20 s on
alpha:oscillation:2:frequency=0.7:sensors=1,2
vc:jamming:0:sensors=3                         stuck at its own value
vg,theta:frames=10:onset=30                    missing samples (nan)
alpha_2:frames=5:value=inf
"""

from __future__ import annotations

from saoflow.diagnosis import DiagnosisError, did_you_mean, refusal
from verification.flights.faults import KINDS, SENSORS, Fault, Missing

FAULT_SYNTAX = "SENSOR:KIND[:VALUE][:onset=S][:sensors=1,2,3][:frequency=HZ], as vc:runaway:-15:onset=20"
MISSING_SYNTAX = "INPUT[,INPUT...]:frames=N[:onset=S][:value=nan|inf|-inf], as vg,theta:frames=10:onset=30"
_FAULT_KEYS = ("onset", "sensors", "amplitude", "rate", "frequency")
_MISSING_KEYS = ("onset", "frames", "value")


def parse_fault(text: str) -> Fault:
    """The fault that ``text`` describes: deg, kt, deg/s, kt/s, Hz, s.

    VALUE is the rate of a runaway and the amplitude of any other kind. Raises DiagnosisError E712 (not
    understood) and E711 (understood, but makes no sense).
    """
    head, _, rest = text.partition(":")
    sensor = head.strip()
    parts = [part.strip() for part in rest.split(":")] if rest else []
    if not sensor or not parts or not parts[0]:
        raise _not_understood(text, "it names no sensor and kind", FAULT_SYNTAX)
    kind = parts[0].replace("-", "_").lower()
    if sensor not in SENSORS:
        near = did_you_mean(sensor, SENSORS)
        raise _not_understood(text, f"`{sensor}` is none of {', '.join(SENSORS)}", FAULT_SYNTAX, near)
    if kind not in KINDS:
        near = did_you_mean(kind, KINDS)
        raise _not_understood(text, f"`{parts[0]}` is none of {', '.join(KINDS)}", FAULT_SYNTAX, near)
    first_is_value = len(parts) > 1 and "=" not in parts[1]
    pairs = _pairs(text, parts[2:] if first_is_value else parts[1:], _FAULT_KEYS, FAULT_SYNTAX)
    if first_is_value:
        name = "rate" if kind == "runaway" else "amplitude"
        if name in pairs:
            raise _not_understood(text, f"the {name} is given twice", FAULT_SYNTAX)
        pairs[name] = parts[1]
    numbers = {key: _number(text, value, FAULT_SYNTAX) for key, value in pairs.items() if key != "sensors"}
    which = _sensor_numbers(text, pairs["sensors"]) if "sensors" in pairs else (1, 2, 3)
    return Fault(kind, sensor, which, **numbers)


def parse_missing(text: str) -> Missing:
    """The missing samples that ``text`` describes. Raises DiagnosisError E712 (not understood), E714 (no sense)."""
    head, *parts = (part.strip() for part in text.split(":"))
    pairs = _pairs(text, parts, _MISSING_KEYS, MISSING_SYNTAX)
    if "frames" not in pairs:
        raise _not_understood(text, "it does not say how many frames", MISSING_SYNTAX)
    frames = _number(text, pairs["frames"], MISSING_SYNTAX)
    if not frames.is_integer():
        raise _not_understood(text, f"`{pairs['frames']}` is not a whole number", MISSING_SYNTAX)
    onset = _number(text, pairs.get("onset", "20"), MISSING_SYNTAX)
    inputs = tuple(name.strip() for name in head.split(","))
    return Missing(inputs, onset, int(frames), pairs.get("value", "nan"))


def _pairs(text: str, parts: list[str], keys: tuple[str, ...], syntax: str) -> dict[str, str]:
    found: dict[str, str] = {}
    for part in parts:
        key, equals, value = (piece.strip() for piece in part.partition("="))
        if not equals or not value:
            raise _not_understood(text, f"`{part}` is not NAME=VALUE", syntax)
        if key not in keys:
            near = did_you_mean(key, keys)
            raise _not_understood(text, f"`{key}` is none of {', '.join(keys)}", syntax, near)
        if key in found:
            raise _not_understood(text, f"{key} is given twice", syntax)
        found[key] = value
    return found


def _number(text: str, value: str, syntax: str) -> float:
    try:
        return float(value)
    except ValueError:
        raise _not_understood(text, f"`{value}` is not a number", syntax) from None


def _sensor_numbers(text: str, value: str) -> tuple[int, ...]:
    numbers = [piece.strip() for piece in value.split(",")]
    for number in numbers:
        if number not in ("1", "2", "3"):
            raise _not_understood(text, f"sensor `{number}` is none of 1, 2, 3", FAULT_SYNTAX)
    return tuple(int(number) for number in numbers)


def _not_understood(text: str, cause: str, syntax: str, near: str = "") -> DiagnosisError:
    return refusal("E712", f"`{text}` is not understood", cause=cause, remedy=near or f"write {syntax}")
