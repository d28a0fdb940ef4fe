"""A small tree of C: what the generator builds and the printer prints. No text is pasted anywhere else."""

from __future__ import annotations

from dataclasses import dataclass, field

# -- expressions


@dataclass(frozen=True, slots=True)
class Variable:
    """A name."""

    name: str


@dataclass(frozen=True, slots=True)
class Real:
    """A real literal, printed exactly."""

    value: float
    bits: int


@dataclass(frozen=True, slots=True)
class Integer:
    """A whole number."""

    value: int
    unsigned: bool = False


@dataclass(frozen=True, slots=True)
class Binary:
    """``left operator right``."""

    operator: str
    left: Expression
    right: Expression


@dataclass(frozen=True, slots=True)
class Not:
    """``!operand``."""

    operand: Expression


@dataclass(frozen=True, slots=True)
class Conditional:
    """``condition ? then : other``."""

    condition: Expression
    then: Expression
    other: Expression


@dataclass(frozen=True, slots=True)
class Call:
    """``function(arguments)``."""

    function: str
    arguments: tuple[Expression, ...]


@dataclass(frozen=True, slots=True)
class Element:
    """``base[index]``."""

    base: Expression
    index: Expression


@dataclass(frozen=True, slots=True)
class Field:
    """``pointer->name``."""

    pointer: str
    name: str


@dataclass(frozen=True, slots=True)
class AddressOf:
    """``&operand``."""

    operand: Expression


@dataclass(frozen=True, slots=True)
class Member:
    """``base.name``: a field of a struct that is at hand."""

    base: Expression
    name: str


@dataclass(frozen=True, slots=True)
class Cast:
    """``(type)operand``."""

    type: str
    operand: Expression


@dataclass(frozen=True, slots=True)
class Text:
    """A string literal of printable ASCII."""

    value: str


@dataclass(frozen=True, slots=True)
class Compound:
    """``(type){value, ...}``."""

    type: str
    values: tuple[Expression, ...]


Expression = (
    Variable
    | Real
    | Integer
    | Binary
    | Not
    | Conditional
    | Call
    | Element
    | Field
    | AddressOf
    | Member
    | Cast
    | Compound
    | Text
)

# -- statements


@dataclass(frozen=True, slots=True)
class Trace:
    """Where a statement comes from: the wire, its sheet path, and the line of YAML."""

    path: str
    file: str
    line: int


@dataclass(frozen=True, slots=True)
class Declare:
    """``type name = value;`` (no value: uninitialised)."""

    type: str
    name: str
    value: Expression | None
    trace: Trace | None = None


@dataclass(frozen=True, slots=True)
class DeclareArray:
    """``type name[size];``."""

    type: str
    name: str
    size: int
    trace: Trace | None = None


@dataclass(frozen=True, slots=True)
class Assign:
    """``target = value;``."""

    target: Expression
    value: Expression
    trace: Trace | None = None


@dataclass(frozen=True, slots=True)
class Do:
    """``call;``."""

    call: Call
    trace: Trace | None = None


@dataclass(frozen=True, slots=True)
class Repeat:
    """``for (type name = 0; name < count; ++name) body``. In code that flies the count is a constant."""

    name: str
    count: int | Expression
    body: tuple[Statement, ...]
    type: str = "unsigned int"


@dataclass(frozen=True, slots=True)
class When:
    """``if (condition) body``."""

    condition: Expression
    body: tuple[Statement, ...]


@dataclass(frozen=True, slots=True)
class Return:
    """``return value;``."""

    value: Expression


Statement = Declare | DeclareArray | Assign | Do | Repeat | When | Return

# -- files


@dataclass(frozen=True, slots=True)
class Parameter:
    """A parameter of a function."""

    type: str
    name: str


@dataclass(frozen=True, slots=True)
class Function:
    """A function; without a body, its prototype."""

    type: str
    name: str
    parameters: tuple[Parameter, ...]
    body: tuple[Statement, ...] | None
    static: bool
    comment: str = ""


@dataclass(frozen=True, slots=True)
class StructField:
    """A field: ``type name[size]; /* comment */`` (size 0: no array)."""

    type: str
    name: str
    size: int
    comment: str


@dataclass(frozen=True, slots=True)
class Struct:
    """``typedef struct { ... } name;``."""

    name: str
    fields: tuple[StructField, ...]
    comment: str


@dataclass(frozen=True, slots=True)
class ConstantArray:
    """``static const type name[size] = { ... };``."""

    type: str
    name: str
    values: tuple[Real | Integer, ...]
    comment: str


@dataclass(frozen=True, slots=True)
class Define:
    """``#define name value``."""

    name: str
    value: str
    comment: str = ""


@dataclass(frozen=True, slots=True)
class Include:
    """``#include "file"``."""

    file: str


@dataclass(frozen=True, slots=True)
class Directive:
    """A line for the preprocessor: ``#text``."""

    text: str


@dataclass(frozen=True, slots=True)
class TypeAlias:
    """``typedef type name;``, with an attribute of gcc and clang if one is named."""

    name: str
    type: str
    attribute: str = ""


Item = Function | Struct | ConstantArray | Define | Include | Directive | TypeAlias


@dataclass(frozen=True, slots=True)
class File:
    """A C file: a comment at its head, then its items; a header is guarded."""

    name: str
    comment: str
    items: tuple[Item, ...] = field(default=())
    guard: str = ""
