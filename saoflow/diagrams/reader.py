"""Reading a sheet: from a YAML file to :class:`~saoflow.diagrams.sheet.Sheet`, with every mistake that can be seen.

    sheet: NAME                      # required, first by custom
    doc: TEXT
    equations: TEXT                  # which equations of which paper
    profile: six | sao
    parameters: {NAME: EXPR | inherited | [list] | {value:, inherited:, unit:, doc:, source:}}
    inputs:     {NAME: {shape:, unit:, type: real | boolean, doc:}}, or a list of names
    blocks:     {NAME: {SYMBOL: wires, key: value..., doc:}}, see reader_blocks.py
    outputs:    a list of wires, or {NAME: wire | {from:, unit:, doc:}}      # required
    budget:     {operations: EXPR, add: EXPR, ..., period: EXPR}

Nothing is resolved here: whether a symbol or a wire exists, elaboration finds out.
"""

from __future__ import annotations

import gc
import os
import stat
from collections.abc import Iterator
from contextlib import contextmanager

from saoflow.diagnosis import Diagnosis, DiagnosisError, Note, Position, in_order
from saoflow.diagrams.expression import Array, Expression, Member, Name
from saoflow.diagrams.reader_blocks import read_blocks
from saoflow.diagrams.reader_values import ValueReader
from saoflow.diagrams.sheet import (
    BudgetDeclaration,
    InputDeclaration,
    Named,
    OutputDeclaration,
    ParameterDeclaration,
    Sheet,
)
from saoflow.diagrams.yaml_text import Mapping, Node, Scalar, Sequence, SourceText, compose, short

LARGEST_FILE = 64 * 2**20
"""Bytes that a sheet may have."""

PROFILES = ("six", "sao")
BUDGET_KINDS = (
    "add",
    "subtract",
    "multiply",
    "reciprocal",
    "minimum",
    "maximum",
    "compare",
    "logic",
    "select",
    "lookup",
)
_KEYS = ("sheet", "doc", "equations", "profile", "parameters", "inputs", "blocks", "outputs", "budget")
_PARAMETER_KEYS = ("value", "inherited", "unit", "doc", "source")
_INPUT_KEYS = ("shape", "unit", "type", "doc")
_OUTPUT_KEYS = ("from", "unit", "doc")


def read_sheet(path: str | os.PathLike[str]) -> Sheet:
    """Read the sheet in a file. Raises DiagnosisError with everything that is wrong (E1xx, E222)."""
    file = os.fspath(path)
    with _collector_paused():
        return _read(SourceText(file, _file_text(file)))


def read_text(text: str, file: str) -> Sheet:
    """Read a sheet from text; ``file`` is the name in messages. Raises DiagnosisError as :func:`read_sheet`."""
    with _collector_paused():
        return _read(SourceText(file, text.removeprefix("\ufeff")))


@contextmanager
def _collector_paused() -> Iterator[None]:
    """Reading makes many small objects and no cycles: searching them for cycles would triple the time."""
    enabled = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if enabled:
            gc.enable()


# ---------------------------------------------------------------- the file


def _file_text(file: str) -> str:
    """The text of a file. Raises DiagnosisError: E101 unreadable, E104 not text, E110 too large."""
    start = Position(file, 1, 1)

    def fail(code: str, message: str, cause: str, remedy: str, position: Position = start) -> DiagnosisError:
        return DiagnosisError([Diagnosis(code, message, position, cause=cause, remedy=remedy)])

    try:
        mode = os.stat(file).st_mode
        if stat.S_ISDIR(mode):
            raise fail("E101", "the file cannot be read", "it is a directory", "name a YAML file in it")
        if not stat.S_ISREG(mode):
            raise fail("E101", "the file cannot be read", "it is not a regular file", "name a YAML file")
        with open(file, "rb") as stream:
            data = stream.read(LARGEST_FILE + 1)
    except FileNotFoundError:
        raise fail("E101", "the file cannot be read", "it does not exist", "correct the path") from None
    except (OSError, ValueError) as error:
        reason = error.strerror if isinstance(error, OSError) and error.strerror else str(error)
        raise fail(
            "E101",
            "the file cannot be read",
            reason[:1].lower() + reason[1:],
            "correct the path or its permissions",
        ) from None
    if len(data) > LARGEST_FILE:
        raise fail(
            "E110",
            "the file is too large",
            f"it has more than {LARGEST_FILE // 2**20} MB",
            "split it into several sheets, or use `fold` and `map`",
        )
    if b"\0" in data:
        raise fail("E104", "the file is not text", "it holds bytes of value zero", "name a YAML file in UTF-8")
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        before = data[: error.start]
        line = before.count(b"\n") + 1
        column = len(before[before.rfind(b"\n") + 1 :].decode("utf-8-sig", "replace")) + 1
        raise fail(
            "E104",
            "the file is not text in UTF-8",
            f"the byte 0x{data[error.start]:02x} cannot stand here",
            "save it as UTF-8",
            Position(file, line, column),
        ) from None


# ---------------------------------------------------------------- the sheet


def _read(source: SourceText) -> Sheet:
    root = compose(source)
    sheet = None
    if root is None or (type(root) is Scalar and root.nothing):
        if not source.found:
            source.report(
                "E103",
                "the file is empty",
                Position(source.file, 1, 1),
                cause="it holds no key at all",
                remedy="a sheet starts with `sheet: NAME` and has `outputs:`",
            )
    elif type(root) is Mapping:
        sheet = _sheet(ValueReader(source), root)
    else:
        ValueReader(source).wrong_kind(
            root, "a sheet", "start with `sheet: NAME`, then `inputs:`, `blocks:`, `outputs:`"
        )
    if sheet is None or source.found:
        raise DiagnosisError(in_order(source.found))
    return sheet


def _sheet(values: ValueReader, root: Mapping) -> Sheet | None:
    parts = dict.fromkeys(_KEYS[:3], "")
    name: Named | None = None
    profile: Named | None = None
    parameters: tuple[ParameterDeclaration, ...] = ()
    inputs: tuple[InputDeclaration, ...] = ()
    outputs: tuple[OutputDeclaration, ...] = ()
    budget: BudgetDeclaration | None = None
    block_node: Node | None = None
    for key, node in root.entries:
        match key.value:
            case "sheet":
                name = values.name(node, "a sheet")
            case "doc" | "equations":
                parts[key.value] = values.word(node, f"`{key.value}`") or ""
            case "profile":
                profile = values.choice(node, "profile", PROFILES)
            case "parameters":
                parameters = _parameters(values, node)
            case "inputs":
                inputs = _inputs(values, node)
            case "blocks":
                block_node = node
            case "outputs":
                outputs = _outputs(values, key, node)
            case "budget":
                budget = _budget(values, key, node)
            case _:
                values.unknown_key(key, "a sheet", _KEYS)
    for required, remedy in (("sheet", "add `sheet: NAME`"), ("outputs", "add `outputs: [wire, ...]`")):
        if required not in root.keys:
            values.source.report(
                "E107",
                f"the key `{required}` is missing",
                Position(values.source.file, root.line + 1, root.column + 1),
                cause=f"every sheet has the key `{required}`",
                remedy=remedy,
            )
    blocks = read_blocks(values, block_node) if block_node is not None else ()
    if name is None:
        return None
    return Sheet(
        name,
        values.source.file,
        parts["doc"],
        parts["equations"],
        profile,
        parameters,
        inputs,
        blocks,
        outputs,
        budget,
        values.source.lines,
    )


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


# ---------------------------------------------------------------- parameters and ports


def _parameters(values: ValueReader, node: Node) -> tuple[ParameterDeclaration, ...]:
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
    return ParameterDeclaration(name, value, inherited, unit, texts["doc"], texts["source"])


def _default(values: ValueReader, node: Node, what: str) -> tuple[bool, Expression | None]:
    """Whether the value is the word ``inherited``, and the default; nothing means that it must be given."""
    if type(node) is Scalar:
        if node.nothing:
            return False, None
        if node.value == "inherited":
            return True, None
    return False, values.expression(node, what)


def _inputs(values: ValueReader, node: Node) -> tuple[InputDeclaration, ...]:
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


def _outputs(values: ValueReader, top: Scalar, node: Node) -> tuple[OutputDeclaration, ...]:
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


def _budget(values: ValueReader, top: Scalar, node: Node) -> BudgetDeclaration:
    limits: list[tuple[Named, Expression]] = []
    period: Expression | None = None
    for key, part in values.entries(node, "`budget`", "write `operations: N`, `multiply: N`, `period: 0.048`"):
        if key.value not in ("operations", "period", *BUDGET_KINDS):
            values.unknown_key(key, "the budget", ("operations", *BUDGET_KINDS, "period"))
            continue
        limit = values.expression(part, f"`{key.value}`")
        if isinstance(limit, Array):
            values.wrong_kind(part, f"`{key.value}`", "write a number or an expression")
        elif key.value == "period":
            period = limit
        elif limit is not None:
            limits.append((values.named(key), limit))
    return BudgetDeclaration(tuple(limits), period, values.source.position(top))
