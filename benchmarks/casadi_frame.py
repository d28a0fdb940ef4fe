"""The same frame in CasADi SX: every operation of the frame program as an SX expression, tables as their functions.

CasADi flattens it, shares common subexpressions, and evaluates it by its virtual machine or by the C that it generates.
"""

from __future__ import annotations

import ctypes
import math
import subprocess
from pathlib import Path
from typing import Any

import numpy as np

from saoflow.formula import Formula
from saoflow.operations import Atom, Kind, Literal, Table
from saoflow.scheduler.program import FrameProgram, ProgramBody

LOOP = """
typedef long long int casadi_int;
int frame(const double **arg, double **res, casadi_int *iw, double *w, int mem);
void frames(long count, double *state, const double *input, long inputs, double *output, long outputs, casadi_int *iw,
            double *w, double *next, long slots)
{
    for (long k = 0; k < count; ++k) {
        const double *arg[64] = {input + k * inputs, state};
        double *res[64] = {output + k * outputs, next};
        (void)frame(arg, res, iw, w, 0);
        for (long i = 0; i < slots; ++i) {
            state[i] = next[i];
        }
    }
}
"""


def casadi_function(program: FrameProgram) -> Any:
    """``frame(inputs, state) -> (outputs, new state)``, all flat vectors."""
    import casadi

    (group,) = program.groups
    inputs = casadi.SX.sym("i", len(group.body.parameters))
    state = casadi.SX.sym("s", len(program.states))
    slots = [state[i] for i in range(len(program.states))]
    given = [inputs[i] for i in range(len(group.body.parameters))]
    results = _run(program, group.body, given, slots)
    return casadi.Function("frame", [inputs, state], [casadi.vertcat(*results), casadi.vertcat(*slots)])


def _run(program: FrameProgram, body: ProgramBody, given: list[Any], slots: list[Any]) -> list[Any]:
    """The results of a body; ``slots`` become the new state."""
    import casadi

    values: dict[int, Any] = dict(zip(body.parameters, given, strict=True))
    before = list(slots)

    def value(atom: Atom) -> Any:
        return casadi.SX(float(atom.value)) if isinstance(atom, Literal) else values[atom]

    for op in body.operations:
        a = [value(atom) for atom in op.operands]
        if op.kind is Kind.WRITE:
            slots[op.detail] = a[0]
        elif op.kind is Kind.CALL:
            found = _run(program, program.procedures[op.detail], a, [])
            values.update(zip(op.results, found, strict=True))
        elif op.kind is Kind.READ:
            values[op.results[0]] = before[op.detail]
        elif op.kind is Kind.LOOKUP:
            values[op.results[0]] = _table(program.tables[op.detail], a[0])
        else:
            values[op.results[0]] = _operation(op.kind, a)
    return [value(atom) for atom in body.results]


def _operation(kind: Kind, a: list[Any]) -> Any:
    import casadi

    match kind:
        case Kind.ADD:
            return a[0] + a[1]
        case Kind.SUBTRACT:
            return a[0] - a[1]
        case Kind.MULTIPLY:
            return a[0] * a[1]
        case Kind.RECIPROCAL:
            return 1 / a[0]
        case Kind.MINIMUM:
            return casadi.fmin(a[0], a[1])
        case Kind.MAXIMUM:
            return casadi.fmax(a[0], a[1])
        case Kind.LESS:
            return a[0] < a[1]
        case Kind.LESS_EQUAL:
            return a[0] <= a[1]
        case Kind.AND:
            return casadi.logic_and(a[0], a[1])
        case Kind.OR:
            return casadi.logic_or(a[0], a[1])
        case Kind.NOT:
            return casadi.logic_not(a[0])
        case _:
            return casadi.if_else(a[0], a[1], a[2])


def _table(table: Table, u: Any) -> Any:
    import casadi

    (x,) = table.breakpoints
    u = casadi.fmin(casadi.fmax(u, float(x[0])), float(x[-1]))
    if table.function is not None:
        return _formula(table.function, u)
    assert not table.linear
    return casadi.pw_const(u, casadi.DM(x[1:]), casadi.DM(table.values))


def _formula(node: Formula, x: Any) -> Any:
    import casadi

    a = [_formula(operand, x) for operand in node.operands]
    match node.operator:
        case "x":
            return x
        case "constant":
            return casadi.SX(node.value)
        case "negate":
            return -a[0]
        case "add":
            return a[0] + a[1]
        case "subtract":
            return a[0] - a[1]
        case "multiply":
            return a[0] * a[1]
        case "divide":
            return a[0] / a[1]
        case "power":
            return a[0] ** a[1]
        case _:
            return getattr(casadi, node.operator)(a[0])


class CasadiFrames:
    """Frames by CasADi's C (compiled with ``command``), the loop over frames in C too."""

    def __init__(self, function: Any, program: FrameProgram, folder: Path, command: list[str]) -> None:
        folder.mkdir(parents=True, exist_ok=True)
        generator = folder / "frame.c"
        if not generator.exists():
            function.generate("frame.c", {"with_header": False})
            Path("frame.c").rename(generator)
            (folder / "loop.c").write_text(LOOP, encoding="ascii")
        target = folder / ("_".join(command).replace("/", "_") + ".so")
        subprocess.run(
            [*command, "-shared", "-fPIC", "-w", str(generator), str(folder / "loop.c"), "-o", str(target), "-lm"],
            check=True,
        )
        self.frames = ctypes.CDLL(str(target.resolve())).frames
        self.function = function
        self.program = program

    def run(self, rows: np.ndarray) -> np.ndarray:
        """Rows of inputs (frames, elements) from the initial state; returns (frames, outputs)."""
        state = np.array([float(slot.initial) for slot in self.program.states])
        outputs = self.function.size1_out(0)
        out = np.empty((len(rows), outputs))
        scratch = [
            np.zeros(max(1, int(n)) + 64, dtype=kind)
            for n, kind in ((self.function.sz_iw(), np.int64), (self.function.sz_w(), float))
        ]
        following = np.empty_like(state)
        pointer = [ctypes.c_void_p(a.ctypes.data) for a in (state, rows, out, *scratch, following)]
        long = ctypes.c_long
        self.frames(
            long(len(rows)),
            pointer[0],
            pointer[1],
            long(rows.shape[1]),
            pointer[2],
            long(outputs),
            pointer[3],
            pointer[4],
            pointer[5],
            long(len(state)),
        )
        return out


def run_machine(function: Any, program: FrameProgram, rows: np.ndarray) -> np.ndarray:
    """The same by CasADi's virtual machine, called on buffers."""
    state = np.array([float(slot.initial) for slot in program.states])
    following = np.empty_like(state)
    given = np.empty(rows.shape[1])
    result = np.empty(function.size1_out(0))
    buffer, trigger = function.buffer()
    for place, array in enumerate((given, state)):
        buffer.set_arg(place, memoryview(array))
    for place, array in enumerate((result, following)):
        buffer.set_res(place, memoryview(array))
    out = np.empty((len(rows), len(result)))
    for k, row in enumerate(rows):
        given[:] = row
        trigger()
        out[k] = result
        state[:] = following
    return out


def largest_difference(a: np.ndarray, b: np.ndarray) -> float:
    """Relative to 1 + size: tables are within their error of their functions."""
    return float(np.max(np.abs(a - b) / (1.0 + np.abs(b)))) if a.size else math.nan
