"""JSON Schema of campaign files, from the reader's own lists of words."""

from __future__ import annotations

from typing import Any

from saoflow.authoring.schema import DIALECT, NAME, Schema
from verification.campaigns.plan import BEYOND, CATEGORIES, INSIDE, LEVELS
from verification.campaigns.reader import MOST_SEED
from verification.campaigns.values import MOST
from verification.flights import AIRCRAFT, KINDS
from verification.flights.faults import SENSORS
from verification.recordings import shipped_recordings

_TEXT = {"type": ["string", "number", "boolean", "null"]}
_SENSORS = [f"{sensor}_{i}" for sensor in SENSORS for i in (1, 2, 3)]


def campaign_schema() -> Schema:
    """The schema of a campaign; what `saoflow campaign` reads, it accepts."""
    return {
        "$schema": DIALECT,
        "title": "saoflow campaign",
        "type": "object",
        "required": ["campaign", "sheets", "flights", "runs"],
        "additionalProperties": False,
        "properties": {
            "campaign": {"description": "the name of the campaign", "type": "string", **NAME},
            "doc": _TEXT,
            "seed": _whole(0, MOST_SEED, "of everything that is drawn"),
            "sheets": {"description": "shipped names or paths; with parameters: {sheet:, set:}", "anyOf": [
                {"type": "string"},
                {"type": "array", "minItems": 1, "items": {"anyOf": [{"type": "string"}, _variant()]}}]},
            "flights": {"description": "sets of flights by name", "type": "object", "minProperties": 1,
                        "propertyNames": NAME, "additionalProperties": {"anyOf": [_drawn(), _recorded()]}},
            "runs": {"description": "sets of runs by name", "type": "object", "minProperties": 1,
                     "propertyNames": NAME, "additionalProperties": _runs()},
        },
    }  # fmt: skip


def _variant() -> Schema:
    settings = {"type": ["object", "null"], "additionalProperties": {"type": ["string", "number"]}}
    return _object({"sheet": {"type": "string"}, "set": settings}, ["sheet"])


def _drawn() -> Schema:
    return _object({
        "drawn": _whole(1, 100_000, "how many flights"),
        "seed": _whole(0, MOST_SEED, "of the flights"),
        "wind": {"description": "inside or beyond the assumed bounds", "enum": [INSIDE, BEYOND]},
        "duration": _interval(20, 3600, "s"),
        "aircraft": _words(list(AIRCRAFT)),
        "cas": _interval(160, 400, "kt"),
        "altitude": _interval(1000, 41000, "ft"),
    }, ["drawn"])  # fmt: skip


def _recorded() -> Schema:
    doc = f"shipped names or paths; shipped are {', '.join(shipped_recordings())}"
    names = {"description": doc, "anyOf": [{"type": "string"}, {"type": "array", "minItems": 1, "items": {"type": "string"}}]}
    part = {"description": "length of the parts that fly, s", "type": "number", "minimum": 5, "maximum": 3600}
    return _object({"recorded": names, "part": part}, ["recorded"])


def _runs() -> Schema:
    weights = _object({name: _whole(0, MOST, "share") for name in CATEGORIES}, [])
    found = _object({
        "flights": {"description": "a set of flights", "type": "string"},
        "count": _whole(1, MOST, "how many runs"),
        "categories": {"description": "shares of Table I: which sensors are hit", **weights},
        "sensors": {"description": "the sensors that are hit", **_words(_SENSORS)},
        "kinds": {"description": "kinds of faults", **_words(list(KINDS))},
        "onset": _interval(0, 3600, "s"),
        "ranges": {"description": "in place of Table II", **_ranges()},
    }, ["flights", "count"])  # fmt: skip
    found["not"] = {"required": ["categories", "sensors"]}
    return found


def _ranges() -> Schema:
    kinds: dict[str, dict[str, dict[str, Any]]] = {}
    for level in LEVELS:
        kinds.setdefault(level.kind, {}).setdefault(level.sensor, {})[level.field] = _interval(1e-3, 600, "")
    return _object({k: _object({s: _object(f, []) for s, f in by.items()}, []) for k, by in kinds.items()}, [])


def _object(properties: Schema, required: list[str]) -> Schema:
    return {"type": "object", "required": required, "additionalProperties": False, "properties": properties}


def _whole(low: int, high: int, doc: str) -> Schema:
    return {"description": doc, "type": "integer", "minimum": low, "maximum": high}


def _interval(low: float, high: float, unit: str) -> Schema:
    number = {"type": "number", "minimum": low, "maximum": high}
    doc = f"[from, to] {unit}".rstrip()
    return {"description": doc, "anyOf": [number, {"type": "array", "minItems": 2, "maxItems": 2, "items": number}]}


def _words(known: list[str]) -> Schema:
    return {"anyOf": [{"enum": known}, {"type": "array", "minItems": 1, "uniqueItems": True, "items": {"enum": known}}]}
