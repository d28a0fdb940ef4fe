"""Printing Python from a frame program: one function per body, from mangled names alone, for scalars or for arrays.

Values that are used once are written into the expression that uses them; that changes neither order nor bits, as every
operation is pure.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass

from saoflow.operations import Atom, Kind, Literal
from saoflow.scheduler.program import FrameProgram, Operation, ProgramBody

DEEPEST = 30
"""Expressions inside each other in one statement."""


@dataclass(frozen=True, slots=True)
class Dialect:
    """How each operation is written; ``{0}`` is the first operand."""

    templates: dict[Kind, str]
    twice: frozenset[Kind]
    """Kinds whose template repeats an operand: those operands must be names."""


SCALAR = Dialect(
    {
        Kind.ADD: "({0}+{1})",
        Kind.SUBTRACT: "({0}-{1})",
        Kind.MULTIPLY: "({0}*{1})",
        Kind.RECIPROCAL: "(1.0/{0} if {0} else rz({0}))",
        Kind.MINIMUM: "({0} if {0}<{1} else {1})",
        Kind.MAXIMUM: "({0} if {0}>{1} else {1})",
        Kind.LESS: "({0}<{1})",
        Kind.LESS_EQUAL: "({0}<={1})",
        Kind.AND: "({0} and {1})",
        Kind.OR: "({0} or {1})",
        Kind.NOT: "(not {0})",
        Kind.SELECT: "({1} if {0} else {2})",
    },
    frozenset({Kind.RECIPROCAL, Kind.MINIMUM, Kind.MAXIMUM}),
)
"""Python floats: IEEE-754 binary64. ``rz`` is the reciprocal of a zero."""

ARRAY = Dialect(
    {
        Kind.ADD: "({0}+{1})",
        Kind.SUBTRACT: "({0}-{1})",
        Kind.MULTIPLY: "({0}*{1})",
        Kind.RECIPROCAL: "(one/{0})",
        Kind.MINIMUM: "where({0}<{1},{0},{1})",
        Kind.MAXIMUM: "where({0}>{1},{0},{1})",
        Kind.LESS: "({0}<{1})",
        Kind.LESS_EQUAL: "({0}<={1})",
        Kind.AND: "({0}&{1})",
        Kind.OR: "({0}|{1})",
        Kind.NOT: "(~{0})",
        Kind.SELECT: "where({0},{1},{2})",
    },
    frozenset({Kind.MINIMUM, Kind.MAXIMUM}),
)
"""numpy arrays of one real type, one element per flight."""


@dataclass(frozen=True, slots=True)
class PythonSource:
    """The text of all functions, and the literals that it names ``k0``, ``k1``, ..."""

    text: str
    literals: tuple[Literal, ...]


def print_python(program: FrameProgram, dialect: Dialect) -> PythonSource:
    """Functions ``p0``, ``p1``, ... of the procedures, and ``frame0``, ... of the rate groups.

    A frame function takes the tuple of input elements and the sequence of state slots, and returns the tuple of results
    and the tuple of new state slots.
    """
    printer = _Printer(dialect)
    parts = [printer.procedure(f"p{i}", body) for i, body in enumerate(program.procedures)]
    parts += [printer.frame(f"frame{i}", group.body, len(program.states)) for i, group in enumerate(program.groups)]
    return PythonSource("\n".join(parts) + "\n", tuple(printer.literals))


class _Printer:
    def __init__(self, dialect: Dialect) -> None:
        self.dialect = dialect
        self.literals: dict[Literal, str] = {}

    def procedure(self, name: str, body: ProgramBody) -> str:
        lines = [f"def {name}({', '.join(f'v{v}' for v in body.parameters)}):"]
        written = _BodyText(self, body, lines)
        lines.append(f" return {_tuple(written.atom(a) for a in body.results)}")
        return "\n".join(lines)

    def frame(self, name: str, body: ProgramBody, slots: int) -> str:
        lines = [f"def {name}(i, s):"]
        if body.parameters:
            lines.append(f" {_tuple(f'v{v}' for v in body.parameters)} = i")
        if slots:
            lines.append(f" {_tuple(f's{n}' for n in range(slots))} = s")
        written = _BodyText(self, body, lines)
        new = {op.detail: written.atom(op.operands[0]) for op in body.operations if op.kind is Kind.WRITE}
        state = _tuple(new.get(n, f"s{n}") for n in range(slots))
        lines.append(f" return {_tuple(written.atom(a) for a in body.results)}, {state}")
        return "\n".join(lines)

    def literal(self, literal: Literal) -> str:
        """The name of a literal."""
        return self.literals.setdefault(literal, f"k{len(self.literals)}")


class _BodyText:
    """The statements of one body."""

    def __init__(self, printer: _Printer, body: ProgramBody, lines: list[str]) -> None:
        self.printer = printer
        self.names: dict[int, tuple[str, int]] = {}
        """By value: its text and the depth of its expression (0: a name)."""
        uses = _uses(body, printer.dialect)
        for op in body.operations:
            self._write(op, uses, lines)

    def atom(self, atom: Atom) -> str:
        """The text of an operand."""
        if isinstance(atom, Literal):
            return self.printer.literal(atom)
        return self.names[atom][0] if atom in self.names else f"v{atom}"

    def _depth(self, atom: Atom) -> int:
        return 0 if isinstance(atom, Literal) else self.names.get(atom, ("", 0))[1]

    def _write(self, op: Operation, uses: Counter[int], lines: list[str]) -> None:
        if op.kind is Kind.WRITE:
            return
        if op.kind is Kind.READ:
            self.names[op.results[0]] = (f"s{op.detail}", 0)
            return
        operands = [self.atom(a) for a in op.operands]
        if op.kind is Kind.CALL:
            if op.results:
                held = "" if op.guard is None else f" if on({self.atom(op.guard)}) else {_tuple(map(self.atom, op.otherwise))}"
                lines.append(f" {_tuple(f'v{r}' for r in op.results)} = p{op.detail}({', '.join(operands)}){held}")
            return
        if op.kind is Kind.LOOKUP:
            text = f"t{op.detail}({', '.join(operands)})"
        else:
            text = self.printer.dialect.templates[op.kind].format(*operands)
        (result,) = op.results
        depth = 1 + max((self._depth(a) for a in op.operands), default=0)
        if uses[result] == 1 and depth < DEEPEST:
            self.names[result] = (text, depth)
        else:
            lines.append(f" v{result} = {text}")


def _uses(body: ProgramBody, dialect: Dialect) -> Counter[int]:
    """How often each value is written out; an operand that a template repeats, and one of a call or result, counts double."""
    uses: Counter[int] = Counter()
    for op in body.operations:
        weight = 2 if op.kind in dialect.twice or op.kind in (Kind.CALL, Kind.WRITE) else 1
        for atom in op.reads:
            if isinstance(atom, int):
                uses[atom] += weight
    for atom in body.results:
        if isinstance(atom, int):
            uses[atom] += 2
    return uses


def _tuple(items: Iterable[str]) -> str:
    parts = list(items)
    return f"({', '.join(parts)}{',' if len(parts) == 1 else ''})"
