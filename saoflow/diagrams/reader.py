"""Reading a sheet: from a YAML file to :class:`~saoflow.diagrams.sheet.Sheet`, with every mistake that can be seen.

    sheet: NAME                      # required, first by custom
    doc: TEXT
    equations: TEXT                  # which equations of which paper
    profile: six | sao
    parameters_of: SHEET     whose parameters this sheet has too, but for those that it declares itself
    parameters: {NAME: EXPR | inherited | [list] | {value:, inherited:, unit:, range:, doc:, source:}}
    inputs:     {NAME: {shape:, unit:, type: real | boolean, doc:}}, or a list of names
    blocks:     {NAME: {SYMBOL: wires, key: value..., doc:}}, see reader_blocks.py
    outputs:    a list of wires, or {NAME: wire | {from:, unit:, doc:}}      # required
    budget:     {operations: EXPR, add: EXPR, ..., period: EXPR}

Nothing is resolved here: whether a symbol or a wire exists, elaboration finds out.
"""

from __future__ import annotations

import codecs
import os
import stat

from saoflow.collector import collector_paused
from saoflow.diagnosis import Diagnosis, DiagnosisError, Position, in_order
from saoflow.diagrams.expression import Array, Expression
from saoflow.diagrams.reader_blocks import read_blocks
from saoflow.diagrams.reader_ports import read_inputs, read_outputs, read_parameters
from saoflow.diagrams.reader_values import ValueReader
from saoflow.diagrams.sheet import (
    BudgetDeclaration,
    InputDeclaration,
    Named,
    OutputDeclaration,
    ParameterDeclaration,
    Sheet,
)
from saoflow.diagrams.yaml_text import Mapping, Node, Scalar, SourceText, compose

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
_KEYS = ("sheet", "doc", "equations", "profile", "parameters_of", "parameters", "inputs", "blocks", "outputs", "budget")


def read_sheet(path: str | os.PathLike[str]) -> Sheet:
    """Read the sheet in a file. Raises DiagnosisError with everything that is wrong (E1xx, E222)."""
    file = os.fspath(path)
    with collector_paused():
        return _read(SourceText(file, file_text(file)))


def read_text(text: str, file: str) -> Sheet:
    """Read a sheet from text; ``file`` is the name in messages. Raises DiagnosisError as :func:`read_sheet`."""
    with collector_paused():
        return _read(SourceText(file, text.removeprefix("\ufeff")))


def read_partly(text: str, file: str) -> tuple[Sheet | None, tuple[Diagnosis, ...]]:
    """As much of a sheet as can be read from text that is being written, and what is wrong with it."""
    source = SourceText(file, text.removeprefix("\ufeff"))
    with collector_paused():
        sheet = _readable(source)
    return sheet, tuple(in_order(dict.fromkeys(source.found)))


# ---------------------------------------------------------------- the file


def file_text(file: str) -> str:
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
    if data.startswith((b"\xff\xfe", b"\xfe\xff")):
        raise fail("E104", "the file is not text in UTF-8", "its first bytes mark it as UTF-16", "save it as UTF-8")
    if b"\0" in data:
        raise fail("E104", "the file is not text", "it holds bytes of value zero", "name a YAML file in UTF-8")
    data = data.removeprefix(codecs.BOM_UTF8)
    try:
        return data.decode("utf-8")
    except UnicodeDecodeError as error:
        before = data[: error.start]
        line = before.count(b"\n") + 1
        column = len(before[before.rfind(b"\n") + 1 :].decode("utf-8", "replace")) + 1
        raise fail(
            "E104",
            "the file is not text in UTF-8",
            f"the byte 0x{data[error.start]:02x} cannot stand here",
            "save it as UTF-8",
            Position(file, line, column),
        ) from None


# ---------------------------------------------------------------- the sheet


def _read(source: SourceText) -> Sheet:
    sheet = _readable(source)
    if sheet is None or source.found:
        raise DiagnosisError(in_order(dict.fromkeys(source.found)))
    return sheet


def _readable(source: SourceText) -> Sheet | None:
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
            root, "a sheet", "a mapping", "start with `sheet: NAME`, then `inputs:`, `blocks:`, `outputs:`"
        )
    return sheet


def _sheet(values: ValueReader, root: Mapping) -> Sheet | None:
    parts = dict.fromkeys(_KEYS[:3], "")
    name: Named | None = None
    profile: Named | None = None
    parameters_of: Named | None = None
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
            case "parameters_of":
                parameters_of = values.name(node, "a sheet")
            case "parameters":
                parameters = read_parameters(values, node)
            case "inputs":
                inputs = read_inputs(values, node)
            case "blocks":
                block_node = node
            case "outputs":
                outputs = read_outputs(values, key, node)
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
        parameters_of,
    )


def _budget(values: ValueReader, top: Scalar, node: Node) -> BudgetDeclaration:
    limits: list[tuple[Named, Expression]] = []
    period: Expression | None = None
    for key, part in values.entries(node, "`budget`", "write `operations: N`, `multiply: N`, `period: 0.048`"):
        if key.value not in ("operations", "period", *BUDGET_KINDS):
            values.unknown_key(key, "the budget", ("operations", *BUDGET_KINDS, "period"))
            continue
        limit = values.expression(part, f"`{key.value}`")
        if isinstance(limit, Array):
            values.wrong_kind(part, f"`{key.value}`", "a number", "write a number or an expression")
        elif key.value == "period":
            period = limit
        elif limit is not None:
            limits.append((values.named(key), limit))
    return BudgetDeclaration(tuple(limits), period, values.source.position(top))
