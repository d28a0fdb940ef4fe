"""Reading what a sheet declares to the outside: parameters, inputs and outputs."""

from __future__ import annotations

from saoflow.diagnosis import Note
from saoflow.diagrams.expression import Array, Expression, Member, Name
from saoflow.diagrams.reader_values import ValueReader
from saoflow.diagrams.sheet import InputDeclaration, Named, OutputDeclaration, ParameterDeclaration
from saoflow.diagrams.yaml_text import Mapping, Node, Scalar, Sequence, short

_PARAMETER_KEYS = ("value", "inherited", "unit", "range", "doc", "source")
_INPUT_KEYS = ("shape", "unit", "type", "doc")
_OUTPUT_KEYS = ("from", "unit", "doc")


def _names(values: ValueReader, node: Sequence, what: str) -> list[Named]:
    """A list of names, each once."""
    found: dict[str, Named] = {}
    for item in node.items:
        name = values.name(item, what)
        if name is not None:
            _once(values, found, name, what)
    return list(found.values())


def _once(values: ValueReader, found: dict[str, Named], name: Named, what: str) -> bool:
    """Remember a name of a list; a second one of the same text is an error (E222)."""
    first = found.setdefault(name.text, name)
    if first is name:
        return True
    values.source.report(
        "E222",
        f"the name `{name.text}` is used twice",
        name.position,
        cause=f"the name of {what} must be its own",
        notes=(Note(f"the first `{name.text}` is here", first.position),),
        remedy="rename or remove one of them",
    )
    return False


def read_parameters(values: ValueReader, node: Node) -> tuple[ParameterDeclaration, ...]:
    """``parameters:``, entries or a list of names that must be given."""
    if type(node) is Sequence:
        names = _names(values, node, "a parameter")
        return tuple(ParameterDeclaration(name, None, False, None, "", "") for name in names)
    found = []
    for key, value in values.entries(node, "`parameters`", "write `name: value` entries"):
        name = values.name(key, "a parameter")
        parameter = _parameter(values, name or values.named(key), value)
        if name is not None:
            found.append(parameter)
    return tuple(found)


def _parameter(values: ValueReader, name: Named, node: Node) -> ParameterDeclaration:
    """``name: value``, or a mapping with a unit and where the value comes from."""
    value: Expression | None = None
    inherited = False
    unit = None
    limits: Expression | None = None
    texts = {"doc": "", "source": ""}
    what = f"the parameter `{short(name.text)}`"
    if type(node) is Mapping:
        for key, part in node.entries:
            match key.value:
                case "value":
                    inherited, value = _default(values, part, what)
                case "inherited":
                    word = values.choice(part, "`inherited`", ("true", "false"))
                    inherited = word is not None and word.text == "true"
                case "unit":
                    unit = values.unit(part)
                case "range":
                    limits = values.expression(part, f"the range of {what}")
                case "doc" | "source":
                    texts[key.value] = values.word(part, f"`{key.value}`") or ""
                case _:
                    values.unknown_key(key, what, _PARAMETER_KEYS)
        if inherited and value is not None:
            values.report(
                "E108",
                f"{what} has a value and is inherited",
                node.keys["inherited"],
                "an inherited parameter takes its value from the sheet that uses this one",
                "remove one of the two",
            )
    else:
        inherited, value = _default(values, node, what)
    return ParameterDeclaration(name, value, inherited, unit, texts["doc"], texts["source"], limits)


def _default(values: ValueReader, node: Node, what: str) -> tuple[bool, Expression | None]:
    """Whether the value is the word ``inherited``, and the default; nothing means that it must be given."""
    if type(node) is Scalar:
        if node.nothing:
            return False, None
        if node.value == "inherited":
            return True, None
    return False, values.expression(node, what)


def read_inputs(values: ValueReader, node: Node) -> tuple[InputDeclaration, ...]:
    """``inputs:``, entries or a list of names."""
    if type(node) is Sequence:
        return tuple(InputDeclaration(n, None, False, None, "") for n in _names(values, node, "an input"))
    found = []
    for key, value in values.entries(node, "`inputs`", "write `name: {shape: [n], unit: kt}` entries"):
        name = values.name(key, "an input")
        declared = _input(values, name or values.named(key), value)
        if name is not None:
            found.append(declared)
    return tuple(found)


def _input(values: ValueReader, name: Named, node: Node) -> InputDeclaration:
    shape: tuple[Expression, ...] | None = None
    unit = None
    boolean, doc = False, ""
    what = f"the input `{short(name.text)}`"
    for key, part in values.entries(node, what, "write {shape: [n], unit: kt}"):
        match key.value:
            case "shape":
                size = values.expression(part, f"the shape of {what}")
                if size is not None:
                    shape = size.items if isinstance(size, Array) else (size,)
            case "unit":
                unit = values.unit(part)
            case "type":
                word = values.choice(part, "type", ("real", "boolean"))
                boolean = word is not None and word.text == "boolean"
            case "doc":
                doc = values.word(part, "`doc`") or ""
            case _:
                values.unknown_key(key, what, _INPUT_KEYS)
    return InputDeclaration(name, shape, boolean, unit, doc)


def read_outputs(values: ValueReader, top: Scalar, node: Node) -> tuple[OutputDeclaration, ...]:
    """``outputs:``, a list of wires or entries; ``top`` is the key itself."""
    found: list[OutputDeclaration] = []
    empty = (type(node) is Scalar and node.nothing) or (type(node) is not Scalar and not _count(node))
    if empty:
        values.report("E107", "the sheet has no output", top, "nothing would come out of it", "list at least one wire")
    elif type(node) is Sequence:
        names: dict[str, Named] = {}
        for item in node.items:
            wire = values.expression(item, "an output")
            if wire is None:
                continue
            name = _output_name(values, item, wire)
            if name is not None and _once(values, names, name, "an output"):
                found.append(OutputDeclaration(name, wire, None, ""))
    else:
        remedy = "write a list of wires, or `name: wire` entries"
        for key, value in values.entries(node, "`outputs`", remedy):
            output = _output(values, key, value)
            if output is not None:
                found.append(output)
    return tuple(found)


def _count(node: Sequence | Mapping) -> int:
    return len(node.items if type(node) is Sequence else node.keys if type(node) is Mapping else ())


def _output_name(values: ValueReader, node: Node, wire: Expression) -> Named | None:
    """The name that an output in a list gets from its wire: ``P`` for ``P`` and for ``stages.P``."""
    if isinstance(wire, Name):
        return Named(wire.text, wire.position)
    if isinstance(wire, Member) and wire.name != "T":
        return Named(wire.name, wire.position)
    values.report(
        "E108",
        "an output in a list must be a name",
        node,
        "its name is that of its wire, and this is an expression",
        "write `outputs: {name: expression, ...}`, or make it a block",
    )
    return None


def _output(values: ValueReader, key: Scalar, node: Node) -> OutputDeclaration | None:
    """``name: wire`` or ``name: {from: wire, unit:, doc:}``; without a wire it is the one of the same name."""
    name = values.name(key, "an output")
    own = name or values.named(key)
    wire: Expression | None = Name(own.text, own.position)
    unit, doc = None, ""
    what = f"the output `{short(own.text)}`"
    if type(node) is Mapping:
        for part_key, part in node.entries:
            match part_key.value:
                case "from":
                    wire = values.expression(part, what)
                case "unit":
                    unit = values.unit(part)
                case "doc":
                    doc = values.word(part, "`doc`") or ""
                case _:
                    values.unknown_key(part_key, what, _OUTPUT_KEYS)
    elif not (type(node) is Scalar and node.nothing):
        wire = values.expression(node, what)
    return None if name is None or wire is None else OutputDeclaration(name, wire, unit, doc)
