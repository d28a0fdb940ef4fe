"""JSON Schema of sheets, so that editors complete and check them: made from the symbols, the library and the reader's own keys.

A schema cannot know which key comes first, nor any wire: what `saoflow check` accepts it accepts, not the reverse. Schemas of
other files join through the entry-point group ``saoflow.schemas``: functions without arguments that give one.
"""

from __future__ import annotations

import json
from collections.abc import Callable
from typing import Any

from saoflow.blocks.library import SYMBOLS, AnySymbol
from saoflow.blocks.symbol import Parameter
from saoflow.diagnosis import did_you_mean, refusal
from saoflow.diagrams.rates import SLOWEST
from saoflow.diagrams.reader import BUDGET_KINDS, PROFILES

Schema = dict[str, Any]
"""A JSON Schema, which is JSON by nature."""

GROUP = "saoflow.schemas"
DIALECT = "https://json-schema.org/draft/2020-12/schema"
NAME = {"pattern": r"^[^0-9\s!-/:-@\[-^`{-~][^\s!-/:-@\[-^`{-~]*$"}
"""A name: letters, digits and underscores, no digit first."""
_ANY_DOC = {"description": "text; nothing reads it but people", "type": ["string", "number", "boolean", "null"]}


def schema_names() -> tuple[str, ...]:
    """What there are schemas of."""
    return ("sheet", *sorted(name for name in _joined() if name != "sheet"))


def schema(name: str) -> Schema:
    """The schema of a kind of file. Raises DiagnosisError E603 for an unknown kind."""
    if name == "sheet":
        return sheet_schema()
    joined = _joined()
    if name not in joined:
        known = schema_names()
        remedy = did_you_mean(name, known) or "write saoflow schema sheet"
        raise refusal("E603", f"there is no schema of `{name}`", cause=f"there are: {', '.join(known)}", remedy=remedy)
    return joined[name]()()


def schema_text(name: str) -> str:
    """The schema as a file has it."""
    return json.dumps(schema(name), indent=1, ensure_ascii=False) + "\n"


def _joined() -> dict[str, Callable[[], Callable[[], Schema]]]:
    from importlib.metadata import entry_points

    return {entry.name: entry.load for entry in entry_points(group=GROUP)}


def sheet_schema() -> Schema:
    """The schema of a sheet."""
    return {
        "$schema": DIALECT,
        "title": "saoflow sheet",
        "type": "object",
        "required": ["sheet", "outputs"],
        "additionalProperties": False,
        "properties": {
            "sheet": {"description": "the name of the sheet, as its file has it", "type": "string", **NAME},
            "doc": _ANY_DOC,
            "equations": {**_ANY_DOC, "description": "which equations of which paper"},
            "profile": {"description": "the symbols that the sheet may use", "enum": list(PROFILES)},
            "parameters_of": {"description": "a sheet whose parameters this one has too", "type": "string", **NAME},
            "parameters": _named("numbers known before the first frame", "parameter"),
            "inputs": _named("the inputs, in their order", "input"),
            "blocks": {"description": "name: {symbol: wires, key: value}", "type": ["object", "null"],
                       "propertyNames": NAME, "additionalProperties": {"$ref": "#/$defs/block"}},
            "outputs": {"description": "what comes out: wires, or name: wire", "anyOf": [
                {"type": "array", "minItems": 1, "items": {"$ref": "#/$defs/expression"}},
                {"type": "object", "minProperties": 1, "propertyNames": NAME,
                 "additionalProperties": {"$ref": "#/$defs/output"}}]},
            "budget": {"description": "what a frame may cost", "type": "object", "additionalProperties": False,
                       "properties": {
                           "operations": _expression("all operations of a frame"),
                           **{kind: _expression(f"operations of kind {kind}") for kind in BUDGET_KINDS},
                           "period": _expression("how long a frame lasts, s")}},
        },
        "$defs": _definitions(),
    }  # fmt: skip


def _named(doc: str, what: str) -> Schema:
    """``{name: {...}}``, a list of names, or nothing."""
    return {
        "description": doc,
        "anyOf": [
            {"type": "object", "propertyNames": NAME, "additionalProperties": {"$ref": f"#/$defs/{what}"}},
            {"type": "array", "items": {"type": "string", **NAME}, "uniqueItems": True},
            {"type": "null"},
        ],
    }


def _expression(doc: str) -> Schema:
    return {"description": doc, "$ref": "#/$defs/expression"}


def _definitions() -> Schema:
    texts = {"doc": _ANY_DOC}
    return {
        "expression": {"description": "a number, a name, or arithmetic", "type": ["string", "number", "boolean"]},
        "value": {"anyOf": [{"$ref": "#/$defs/expression"}, {"type": "array", "items": {"$ref": "#/$defs/value"}}]},
        "unit": {"description": "kt, m/s^2, rad/deg, 1 for none; or a list, one for each element", "anyOf": [
            {"type": ["string", "number"]}, {"type": "array", "items": {"$ref": "#/$defs/unit"}}]},
        "wires": {"description": "a wire, a list of them, or port: wire", "anyOf": [
            {"$ref": "#/$defs/value"}, {"type": "null"},
            {"type": "object", "propertyNames": NAME, "additionalProperties": {"$ref": "#/$defs/value"}}]},
        "ports": {"description": "port: wire", "type": ["object", "null"], "propertyNames": NAME,
                  "additionalProperties": {"$ref": "#/$defs/value"}},
        "parameter": {"anyOf": [{"$ref": "#/$defs/value"}, {"type": "null"}, {
            "type": "object", "additionalProperties": False, "properties": {
                "value": {"$ref": "#/$defs/value"},
                "inherited": {"description": "taken from the sheet that uses this one", "enum": [True, False, "true", "false"]},
                "unit": {"$ref": "#/$defs/unit"},
                "range": {"description": "[least, most] of every element", "$ref": "#/$defs/value"},
                **texts,
                "source": {**_ANY_DOC, "description": "where the number comes from"}}}]},
        "input": {"type": ["object", "null"], "additionalProperties": False, "properties": {
            "shape": {"description": "[] a scalar, [3] a vector, [8, 4] a matrix; left out: whatever is connected",
                      "$ref": "#/$defs/value"},
            "unit": {"$ref": "#/$defs/unit"}, "type": {"enum": ["real", "boolean"]}, **texts}},
        "output": {"anyOf": [{"$ref": "#/$defs/value"}, {"type": "null"}, {
            "type": "object", "additionalProperties": False, "properties": {
                "from": {"description": "the wire; left out: the one of the same name", "$ref": "#/$defs/value"},
                "unit": {"$ref": "#/$defs/unit"}, **texts}}]},
        "block": _block(),
        "iteration": _iteration(),
        **{f"symbol {name}": _symbol(symbol) for name, symbol in SYMBOLS.items()},
    }  # fmt: skip


def _rate() -> Schema:
    return {
        "every": {"description": f"runs in every n-th frame, 1 to {SLOWEST}", "$ref": "#/$defs/expression"},
        "offset": {"description": "in which of the n frames, from 0; auto balances them", "$ref": "#/$defs/expression"},
        "transition": {
            "description": "hold: a run's results show from its own frame on; delay: from the next one on",
            "enum": ["hold", "delay"],
        },
        "held": {"description": "what outputs are before the first run", "$ref": "#/$defs/expression"},
    }


def _block() -> Schema:
    """A block: the keys of its symbol if it has one; of a sheet, whatever the sheet takes."""
    from saoflow.symbol_catalogue import library_sheets

    known = {name: {"description": f"{s.summary}: {s.equation}"} for name, s in SYMBOLS.items()}
    library = {sheet.name: {"description": sheet.doc, "$ref": "#/$defs/wires"} for sheet in library_sheets()}
    rate = {key: {"description": value["description"]} for key, value in _rate().items()}
    return {
        "type": "object",
        "minProperties": 1,
        "propertyNames": NAME,
        "properties": {
            **known, **library, **rate,
            "fold": {"description": "a sheet, count times in a row: each takes the previous one's outputs"},
            "map": {"description": "a sheet, count times, independent of each other"},
            "doc": _ANY_DOC,
        },
        "additionalProperties": {"$ref": "#/$defs/wires"},
        "anyOf": [{"minProperties": 2}, {"not": {"required": ["doc"]}}],
        "dependentRequired": {"every": ["transition"], "offset": ["every"]},
        "allOf": [
            *({"if": {"required": [name]}, "then": {"$ref": f"#/$defs/symbol {name}"}} for name in SYMBOLS),
            {"if": {"required": ["every"]}, "then": {"properties": _rate()}},
            *({"if": {"required": [name]}, "then": {"$ref": "#/$defs/iteration"}} for name in ("fold", "map")),
        ],
    }  # fmt: skip


def _iteration() -> Schema:
    ports = {"$ref": "#/$defs/ports"}
    return {
        "required": ["count"],
        "properties": {
            "fold": {"type": "string", **NAME},
            "map": {"type": "string", **NAME},
            "count": {"description": "how many instances", "$ref": "#/$defs/expression"},
            "order": {"description": "of a fold: from the first or from the last slice", "enum": ["forward", "reverse"]},
            "carry": {"description": "of a fold: what the first instance gets, then each the previous one's output", **ports},
            "each": {"description": "of the i-th instance the i-th slice", **ports},
            "in": {"description": "the same wire for all instances", **ports},
            "every": False,
            "offset": False,
        },
    }


def _symbol(symbol: AnySymbol) -> Schema:
    """The keys of a block of one symbol, and how many operands it takes."""
    least = sum(not port.optional for port in symbol.ports)
    wires: Schema = {"type": "array", "minItems": least, "items": {"$ref": "#/$defs/value"}}
    if not symbol.variadic:
        wires["maxItems"] = len(symbol.ports)
    ports = {port.name: {"description": port.doc, "$ref": "#/$defs/value"} for port in symbol.ports}
    operands: list[Schema] = [
        wires,
        {"$ref": "#/$defs/expression"},
        {"type": "object", "properties": ports, "additionalProperties": False},
    ]
    if symbol.name == "constant":
        operands = [{"$ref": "#/$defs/value"}]
    if any(p.optional for p in symbol.ports) or not symbol.ports or least > 1 or symbol.parameters:
        operands.append({"type": "null"})  # all by name
    return {
        "properties": {
            symbol.name: {"anyOf": operands},
            **ports,
            **{parameter.name: _parameter(parameter) for parameter in symbol.parameters},
            **_rate(),
            "doc": _ANY_DOC,
        },
        "additionalProperties": False,
    }


def _parameter(parameter: Parameter) -> Schema:
    doc = {"description": parameter.doc}
    if parameter.kind == "word":
        return {**doc, "enum": list(parameter.words)}
    if parameter.kind == "flag":
        return {**doc, "enum": [True, False, *parameter.words]}
    if parameter.kind == "unit":
        return {**doc, "$ref": "#/$defs/unit"}
    return {**doc, "$ref": "#/$defs/expression" if parameter.kind in ("count", "formula") else "#/$defs/value"}
