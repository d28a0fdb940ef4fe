"""The faults of a set of runs, as a campaign file says them."""

from __future__ import annotations

from dataclasses import replace

from saoflow.yaml_document import Document, Mapping, Node, Scalar
from verification.campaigns import values
from verification.campaigns.plan import CATEGORIES, LEVELS, FaultMix, Level, Range
from verification.flights import KINDS
from verification.flights.faults import SENSORS

FAULT_KEYS = ("categories", "sensors", "kinds", "onset", "ranges")
_ALL_SENSORS = tuple(f"{sensor}_{i}" for sensor in SENSORS for i in (1, 2, 3))
_HIGHEST = {"alpha": 90.0, "vc": 600.0}
"""Largest amplitude [deg, kt] and rate [deg/s, kt/s] that a campaign may ask for."""
LEFT_AFTER_ONSET = 5.0
"""[s] that a fault must last at least."""


def read_faults(document: Document, node: Mapping, shortest: float) -> FaultMix | None:
    """None for fault-free runs, and after a diagnosis. ``shortest`` [s]: of the flights."""
    parts = {key.value: (key, value) for key, value in node.entries if key.value in FAULT_KEYS}
    if not parts:
        return None
    weights: tuple[int, int, int, int] | None = None
    sensors: tuple[str, ...] = ()
    if "categories" in parts and "sensors" in parts:
        document.report(
            "E801",
            "`categories` and `sensors` are both given",
            parts["sensors"][0],
            "categories draw the faulty sensors, `sensors` names them",
            "remove one of the two",
        )
    elif "categories" in parts:
        weights = _weights(document, parts["categories"][1])
    elif "sensors" in parts:
        sensors = values.words(document, parts["sensors"][1], "`sensors`", _ALL_SENSORS) or ()
    else:
        first = next(iter(parts.values()))[0]
        document.report(
            "E107",
            f"`{first.value}` without `categories` or `sensors`",
            first,
            "nothing says which sensors are hit, so these runs are fault-free",
            "add `categories: {I: 47, II: 22, III: 25, IV: 15}`, or remove it",
        )
    mix = FaultMix(weights, sensors)
    if "kinds" in parts:
        mix = replace(mix, kinds=values.words(document, parts["kinds"][1], "`kinds`", KINDS) or KINDS)
    if "onset" in parts:
        last = max(shortest - LEFT_AFTER_ONSET, 0.0)
        mix = replace(mix, onset=values.interval(document, parts["onset"][1], "`onset`", 0.0, last, "s") or mix.onset)
    elif mix.onset.high > shortest - LEFT_AFTER_ONSET:
        mix = replace(mix, onset=Range(shortest / 4.0, shortest / 2.0))
    if "ranges" in parts:
        mix = replace(mix, levels=_levels(document, parts["ranges"][1]))
    return mix if weights or sensors else None


def _weights(document: Document, node: Node) -> tuple[int, int, int, int] | None:
    found = dict.fromkeys(CATEGORIES, 0)
    for key, value in document.entries(node, "`categories`", "write {I: 47, II: 22, III: 25, IV: 15}"):
        if key.value in found:
            found[key.value] = values.whole(document, value, f"`{key.value}`", 0) or 0
        else:
            document.unknown_key(key, "`categories`", CATEGORIES)
    if not any(found.values()):
        document.report(
            "E801", "no category has a share", node, "all are 0 or left out", "write {I: 47, II: 22, III: 25, IV: 15}"
        )
        return None
    return found["I"], found["II"], found["III"], found["IV"]


def _levels(document: Document, node: Node) -> tuple[Level, ...]:
    """Table II with the ranges that are given in place of its own."""
    found = {(level.kind, level.sensor, level.field): level for level in LEVELS}
    for kind, by_sensor in document.entries(node, "`ranges`", "write {bias: {alpha: {amplitude: [0.5, 25]}}}"):
        if kind.value not in KINDS:
            document.unknown_key(kind, "`ranges`", KINDS)
            continue
        for sensor, by_field in document.entries(by_sensor, f"`{kind.value}`", "write {alpha: {amplitude: [0.5, 25]}}"):
            if sensor.value not in SENSORS:
                document.unknown_key(sensor, f"`{kind.value}`", SENSORS)
                continue
            known = tuple(f for k, s, f in found if (k, s) == (kind.value, sensor.value))
            for field, value in document.entries(by_field, f"`{sensor.value}`", "write {amplitude: [0.5, 25]}"):
                if field.value not in known:
                    document.unknown_key(field, f"a {kind.value} of {sensor.value}", known)
                    continue
                level = _level(document, kind, sensor, field, value)
                if level is not None:
                    found[kind.value, sensor.value, field.value] = level
    return tuple(found.values())


def _level(document: Document, kind: Scalar, sensor: Scalar, field: Scalar, node: Node) -> Level | None:
    if kind.value == "non_return_to_zero":
        highest, unit = 10.0, ""
    elif field.value == "frequency":
        highest, unit = 10.0, "Hz"
    else:
        highest = _HIGHEST[sensor.value]
        unit = {"alpha": "deg", "vc": "kt"}[sensor.value] + ("/s" if field.value == "rate" else "")
    interval = values.interval(document, node, f"`{field.value}`", 1e-3, highest, unit)
    return None if interval is None else Level(kind.value, sensor.value, field.value, interval.low, interval.high)
