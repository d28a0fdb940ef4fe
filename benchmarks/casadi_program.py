"""A frame program as a CasADi SX function: every scalar operation mapped onto SX, nothing added, nothing left out.

SX has no select but ``if_else_zero``, twice, and no look-up table at all. So there are two mappings. In ``placed`` every
table is an SX operation that the program does not use otherwise (``sin``, ``cos``, ...), and the C that CasADi generates
gets the table functions of saoflow's backend ``c`` under those names: the same operations, and the same bits. In ``plain`` a table is the
function that it approximates, as in saoflow's exact mode; a table of data is a sum of steps.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import casadi as ca
import numpy as np

from saoflow.codegen.guided_tables import native_table_items
from saoflow.codegen.printer import print_file
from saoflow.codegen.tree import File
from saoflow.formula import Formula
from saoflow.operations import Atom, Kind, Literal, Table
from saoflow.scheduler.program import FrameProgram, Operation, ProgramBody

PLACES = (
    "sin", "cos", "tan", "asin", "acos", "atan", "sinh", "cosh", "tanh", "exp", "log", "erf", "log1p", "expm1", "ceil",
    "floor",
)  # fmt: skip
"""Operations of SX that stand for tables, under the names that the generated C has for them."""
OPERATIONS: dict[Kind, Callable[..., Any]] = {
    Kind.ADD: lambda a, b: a + b,
    Kind.SUBTRACT: lambda a, b: a - b,
    Kind.MULTIPLY: lambda a, b: a * b,
    Kind.RECIPROCAL: lambda a: 1.0 / a,
    Kind.MINIMUM: ca.fmin,
    Kind.MAXIMUM: ca.fmax,
    Kind.LESS: lambda a, b: a < b,
    Kind.LESS_EQUAL: lambda a, b: a <= b,
    Kind.AND: ca.logic_and,
    Kind.OR: ca.logic_or,
    Kind.NOT: ca.logic_not,
    Kind.SELECT: ca.if_else,
}
FORMULAS: dict[str, Callable[..., Any]] = {
    "add": lambda a, b: a + b,
    "subtract": lambda a, b: a - b,
    "multiply": lambda a, b: a * b,
    "divide": lambda a, b: a / b,
    "power": lambda a, b: a**b,
    "negate": lambda a: -a,
    **{name: getattr(ca, name) for name in ("sqrt", "sin", "cos", "tan", "exp", "log", "asin", "acos", "atan")},
}
Lookup = Callable[[int, Any], Any]


def function(program: FrameProgram, lookup: Lookup, shared: bool = False) -> ca.Function:
    """(state, inputs) to (next state, outputs), all flat columns. ``shared``: after CasADi's own ``cse``."""
    # Its simplification would put divisions in place of products with a reciprocal.
    ca.GlobalOptions.setSimplificationOnTheFly(False)
    try:
        state = ca.SX.sym("s", len(program.states))
        inputs = ca.SX.sym("u", sum(port.type.size for port in program.inputs))
        mapping = _Mapping(program, lookup, [state[i] for i in range(state.numel())])
        (group,) = program.groups
        given = [inputs[i] for i in range(inputs.numel())]
        results = mapping.body(group.body, given)
        outputs = ca.vertcat(*results)
        following = ca.vertcat(*mapping.written)
        if shared:
            following, outputs = ca.cse([following, outputs])
        return ca.Function("frame", [state, inputs], [following, outputs])
    finally:
        ca.GlobalOptions.setSimplificationOnTheFly(True)


class _Mapping:
    """Procedures are laid out in place at every call, as SX does with functions."""

    def __init__(self, program: FrameProgram, lookup: Lookup, state: list[Any]) -> None:
        self.program = program
        self.lookup = lookup
        self.state = state
        self.written = list(state)

    def body(self, body: ProgramBody, given: Sequence[Any]) -> list[Any]:
        """The results of a body."""
        values: dict[int, Any] = dict(zip(body.parameters, given, strict=True))
        for op in body.operations:
            operands = [_atom(a, values) for a in op.operands]
            if op.kind is Kind.CALL:
                values.update(zip(op.results, self.body(self.program.procedures[op.detail], operands), strict=True))
            elif op.kind is Kind.WRITE:
                self.written[op.detail] = operands[0]
            else:
                values[op.results[0]] = self._value(op, operands)
        return [_atom(a, values) for a in body.results]

    def _value(self, op: Operation, operands: list[Any]) -> Any:
        if op.kind is Kind.READ:
            return self.state[op.detail]
        if op.kind is Kind.LOOKUP:
            (u,) = operands  # tables of two inputs: the flagship has none
            return self.lookup(op.detail, u)
        return OPERATIONS[op.kind](*operands)


def _atom(atom: Atom, values: dict[int, Any]) -> Any:
    return ca.SX(float(atom.value)) if isinstance(atom, Literal) else values[atom]


def placed(number: int, u: Any) -> Any:
    """The operation that stands for a table."""
    return getattr(ca, PLACES[number])(u)


def plain(program: FrameProgram) -> Lookup:
    """Functions in place of tables, their input limited as the tables limit it."""

    def lookup(number: int, u: Any) -> Any:
        table = program.tables[number]
        (x,) = table.breakpoints
        limited = ca.fmin(ca.fmax(u, float(x[0])), float(x[-1]))
        return _steps(table, u) if table.function is None else _formula(table.function, limited)

    return lookup


def _formula(formula: Formula, x: Any) -> Any:
    if formula.operator == "x":
        return x
    if formula.value is not None:
        return ca.SX(formula.value)
    return FORMULAS[formula.operator](*(_formula(operand, x) for operand in formula.operands))


def _steps(table: Table, u: Any) -> Any:
    assert not table.linear
    (x,) = table.breakpoints
    total = ca.SX(float(table.values[0]))
    for point, step in zip(x[1:], np.diff(table.values), strict=True):
        if step:
            total = total + (float(point) <= u) * float(step)
    return total


LOOP = """
void casadi_run(const double *in, double *out, double *state, double *other, long frames) {
  const double *arg[2]; double *res[2]; double *from = state, *to = other;
  for (long t = 0; t < frames; ++t) {
    arg[0] = from; arg[1] = in + t * N_IN; res[0] = to; res[1] = out + t * N_OUT;
    casadi_f0(arg, res, 0, 0, 0);
    double *swap = from; from = to; to = swap;
  }
}
"""


def generated(frame: ca.Function, program: FrameProgram, tables: bool, favoured: bool = True) -> str:
    """CasADi's C for a function, with a loop over frames; with ``tables``, of ``placed`` operations.

    ``favoured``: its helpers become static, and its least and greatest become the comparison that it writes for
    compilers older than C99, which is also what saoflow means. Else they stay what CasADi makes them: exported
    functions that call fmin and fmax of the library.
    """
    writer = ca.CodeGenerator("frame_c", {"with_header": False})
    writer.add(frame)
    text = writer.dump()
    if favoured:
        text = text.replace("\ncasadi_real casadi_f", "\nstatic casadi_real casadi_f")
    head = "#include <math.h>\n"
    if tables:
        for number, table in enumerate(program.tables):
            name = f"table{number}"
            head += print_file(File("t.c", "", native_table_items(name, table, program.real, 0)), traced=False).text
            head += f"#define {PLACES[number]} {name}\n"
    if favoured:
        head += "#define fmin(x, y) ((x) < (y) ? (x) : (y))\n#define fmax(x, y) ((x) > (y) ? (x) : (y))\n"
    sizes = f"#define N_IN {frame.numel_in(1)}\n#define N_OUT {frame.numel_out(1)}\n"
    return head + text + sizes + LOOP
