"""Printing the tree of C as text, and noting on which line each trace lands."""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction

from saoflow.codegen.tree import (
    AddressOf,
    Assign,
    Binary,
    Call,
    Cast,
    Compound,
    Conditional,
    ConstantArray,
    Declare,
    DeclareArray,
    Define,
    Directive,
    Do,
    Element,
    Expression,
    Field,
    File,
    Function,
    Include,
    Integer,
    Item,
    Member,
    Not,
    Real,
    Repeat,
    Return,
    Statement,
    Struct,
    Text,
    Trace,
    TypeAlias,
    Variable,
    When,
)


@dataclass(frozen=True, slots=True)
class Printed:
    """The text of a file, and the trace of each line that has one (1-based)."""

    name: str
    text: str
    traces: tuple[tuple[int, Trace], ...]


def print_file(file: File, traced: bool = True) -> Printed:
    """The text of a C file. ``traced``: with the sheet's line beside each statement."""
    out = _Lines(traced)
    out.comment(file.comment)
    if file.guard:
        out.line(f"#ifndef {file.guard}")
        out.line(f"#define {file.guard}")
        _plus_plus(file, out, begin=True)
    for item in file.items:
        _item(item, out)
    if file.guard:
        _plus_plus(file, out, begin=False)
        out.line("")
        out.line("#endif")
    return Printed(file.name, "\n".join(out.lines) + "\n", tuple(out.traces))


def _plus_plus(file: File, out: _Lines, begin: bool) -> None:
    """What lets a C++ program use the header of the C code."""
    out.line("")
    out.line("#ifdef __cplusplus")
    if begin:
        fields = [field for item in file.items if isinstance(item, Struct) for field in item.fields]
        if any(field.type == "_Bool" for field in fields):
            out.line("#ifndef _Bool")
            out.line("#define _Bool bool  /* the same type, by its name in C++ */")
            out.line("#endif")
        out.line('extern "C" {')
    else:
        out.line("}")
    out.line("#endif")


class _Lines:
    def __init__(self, traced: bool = True) -> None:
        self.traced = traced
        self.lines: list[str] = []
        self.traces: list[tuple[int, Trace]] = []

    def line(self, text: str, trace: Trace | None = None) -> None:
        if trace is not None and self.traced:
            text = f"{text}  /* {safe(trace.path)}, {safe(trace.file)}:{trace.line} */"
            self.traces.append((len(self.lines) + 1, trace))
        self.lines.append(text)

    def comment(self, text: str) -> None:
        if text:
            body = [safe(line) for line in text.split("\n")]
            if len(body) == 1:
                self.line(f"/* {body[0]} */")
            else:
                self.line("/*")
                for line in body:
                    self.line(f" * {line}".rstrip())
                self.line(" */")


def safe(text: str) -> str:
    """Text that cannot end a comment, continue a line, or make a trigraph; printable ASCII only."""
    plain = "".join(c if " " <= c <= "~" else "?" for c in text)
    return plain.replace("*/", "* /").replace("/*", "/ *").replace("\\", "/").replace("??", "? ?").replace("//", "/ /")


def _item(item: Item, out: _Lines) -> None:
    if not isinstance(item, Define | Include | Directive):
        out.line("")
    match item:
        case Include():
            out.line(f"#include {item.file}" if item.file.startswith("<") else f'#include "{item.file}"')
        case TypeAlias():
            attribute = f" __attribute__(({item.attribute}))" if item.attribute else ""
            out.line(f"typedef {item.type} {item.name}{attribute};")
        case Directive():
            out.line(f"#{item.text}")
        case Define():
            comment = f"  /* {safe(item.comment)} */" if item.comment else ""
            out.line(f"#define {item.name} {item.value}{comment}")
        case ConstantArray():
            out.comment(item.comment)
            out.line(f"static const {item.type} {item.name}[{len(item.values)}] = {{")
            for start in range(0, len(item.values), 4):
                out.line("    " + ", ".join(expression(v) for v in item.values[start : start + 4]) + ",")
            out.line("};")
        case Struct():
            out.comment(item.comment)
            out.line("typedef struct {")
            for f in item.fields:
                size = f"[{f.size}]" if f.size else ""
                comment = f"  /* {safe(f.comment)} */" if f.comment else ""
                out.line(f"    {f.type} {f.name}{size};{comment}")
            out.line(f"}} {item.name};")
        case Function():
            _function(item, out)


def _function(function: Function, out: _Lines) -> None:
    out.comment(function.comment)
    parameters = ", ".join(_declared(p.type, p.name) for p in function.parameters) or "void"
    head = f"{'static ' if function.static else ''}{function.type} {function.name}({parameters})"
    if function.body is None:
        out.line(f"{head};")
        return
    out.line(head)
    out.line("{")
    for statement in function.body:
        _statement(statement, out, 1)
    out.line("}")


def _declared(type_name: str, name: str) -> str:
    return f"{type_name}{name}" if type_name.endswith("*") else f"{type_name} {name}"


def _statement(statement: Statement, out: _Lines, level: int) -> None:
    pad = "    " * level
    match statement:
        case Declare(value=None):
            out.line(f"{pad}{_declared(statement.type, statement.name)};", statement.trace)
        case Declare():
            assert statement.value is not None
            out.line(
                f"{pad}{_declared(statement.type, statement.name)} = {expression(statement.value)};", statement.trace
            )
        case DeclareArray():
            out.line(f"{pad}{statement.type} {statement.name}[{statement.size}];", statement.trace)
        case Assign():
            out.line(f"{pad}{expression(statement.target)} = {expression(statement.value)};", statement.trace)
        case Do():
            out.line(f"{pad}{expression(statement.call)};", statement.trace)
        case Return():
            out.line(f"{pad}return {expression(statement.value)};")
        case Repeat():
            n = statement.name
            if isinstance(statement.count, int):
                out.line(f"{pad}for ({statement.type} {n} = 0u; {n} < {statement.count}u; ++{n}) {{")
            else:
                out.line(f"{pad}for ({statement.type} {n} = 0; {n} < {expression(statement.count)}; ++{n}) {{")
            for inner in statement.body:
                _statement(inner, out, level + 1)
            out.line(f"{pad}}}")
        case When():
            out.line(f"{pad}if ({expression(statement.condition)}) {{")
            for inner in statement.body:
                _statement(inner, out, level + 1)
            out.line(f"{pad}}}")


def expression(node: Expression) -> str:
    """The text of an expression; operands of operators are bracketed unless they are simple."""
    match node:
        case Variable():
            return node.name
        case Real():
            return real(node.value, node.bits)
        case Integer():
            return f"{node.value}u" if node.unsigned else str(node.value)
        case Binary():
            return f"{_operand(node.left)} {node.operator} {_operand(node.right)}"
        case Not():
            return f"!{_operand(node.operand)}"
        case Conditional():
            return f"{_operand(node.condition)} ? {_operand(node.then)} : {_operand(node.other)}"
        case Call():
            return f"{node.function}({', '.join(expression(a) for a in node.arguments)})"
        case Element():
            return f"{_operand(node.base)}[{expression(node.index)}]"
        case Field():
            return f"{node.pointer}->{node.name}"
        case AddressOf():
            return f"&{_operand(node.operand)}"
        case Member():
            return f"{_operand(node.base)}.{node.name}"
        case Text():
            lines = [safe(line).replace('"', "'") for line in node.value.split("\n")]
            return '"' + "\\n".join(lines) + '"'
        case Compound():
            return f"({node.type}){{{', '.join(expression(v) for v in node.values)}}}"
        case Cast():
            return f"({node.type}){_operand(node.operand)}"


def _operand(node: Expression) -> str:
    text = expression(node)
    simple = isinstance(node, Variable | Integer | Call | Element | Field | Member) or (
        isinstance(node, Real) and not text.startswith("-")
    )
    return text if simple else f"({text})"


def real(value: float, bits: int) -> str:
    """A literal of exactly this value: hexadecimal, or decimal where a short decimal is exact."""
    suffix = "f" if bits == 32 else ""
    if math.isnan(value) or math.isinf(value):
        zero = f"0.0{suffix}"
        if math.isnan(value):
            return f"({zero} / {zero})"
        return f"({'-' if value < 0 else ''}1.0{suffix} / {zero})"
    short = f"{value:.6g}"
    if "e" not in short and float(short) == value and abs(value) < 1e6 and Fraction(short) == Fraction(value):
        return (short if "." in short else f"{short}.0") + suffix
    mantissa, _, exponent = value.hex().partition("p")
    sign, digits = ("-", mantissa[1:]) if mantissa.startswith("-") else ("", mantissa)
    digits = digits.rstrip("0") if "." in digits else digits
    digits = digits.rstrip(".")
    return f"{sign}{digits}p{exponent}{suffix}"
