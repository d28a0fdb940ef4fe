"""selfcheck.c: frames of inputs as exact literals, and what the interpreter made of them, compared bit by bit."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from saoflow.codegen.interface import Interface
from saoflow.codegen.tree import (
    AddressOf,
    Assign,
    Binary,
    Call,
    Cast,
    Conditional,
    ConstantArray,
    Declare,
    DeclareArray,
    Do,
    Element,
    Expression,
    File,
    Function,
    Include,
    Integer,
    Item,
    Member,
    Parameter,
    Real,
    Repeat,
    Return,
    Statement,
    Text,
    Variable,
    When,
)
from saoflow.scheduler.program import FrameProgram, ProgramPort

FRAMES = 300
MOST_LITERALS = 60_000
"""Fewer frames are recorded of a sheet with many inputs and outputs."""

_ODD = (math.nan, math.inf, -math.inf, 0.0, -0.0, 5e-324, -1e-310, 1e300)


def frame_count(program: FrameProgram) -> int:
    """How many frames are recorded."""
    ports = (*program.inputs, *program.outputs)
    return max(2, min(FRAMES, MOST_LITERALS // max(1, sum(port.type.size for port in ports))))


def exercise(program: FrameProgram) -> dict[str, np.ndarray]:
    """Inputs that reach a sheet's corners: slow drifts of many sizes, steps, and now and then an odd number."""
    rng = np.random.default_rng(20)
    frames = frame_count(program)
    inputs: dict[str, np.ndarray] = {}
    for port in program.inputs:
        shape = (frames, *port.type.shape)
        if port.type.boolean:
            inputs[port.name] = (rng.random(shape) < 0.5).astype(np.float64)
            continue
        drift = np.cumsum(rng.normal(size=shape), axis=0) / math.sqrt(frames)
        values = drift * 10.0 ** rng.uniform(-3, 3, size=(1, *port.type.shape))
        # Odd numbers in the second half alone: some of them stay in a sheet's memory for ever.
        hit = (rng.random(shape) < 0.01) & (np.arange(frames) >= frames // 2).reshape(-1, *([1] * len(port.type.shape)))
        values[hit] = rng.choice(_ODD, size=int(hit.sum()))
        inputs[port.name] = values
    return inputs


def self_check_file(
    program: FrameProgram, face: Interface, inputs: Mapping[str, np.ndarray], outputs: Mapping[str, np.ndarray]
) -> File:
    """The program: prints what differs, or that nothing does; its exit code says it, too."""
    given, expected = _rows(program.inputs, inputs), _rows(program.outputs, outputs)
    frames, n, m = len(expected), given.shape[1], expected.shape[1]
    kind, bits = face.real_type, program.real
    items: list[Item] = [Include("<stdio.h>"), Include(f"{face.prefix}.h")]
    if n:
        items.append(_array(kind, bits, "given", given, f"Inputs, {n} a frame."))
    if m:
        items.append(_array(kind, bits, "expected", expected, f"What the interpreter made of them, {m} a frame."))
    k, i = Variable("k"), Variable("i")
    wrong = Variable("wrong")
    place = Binary("+", Binary("*", k, Integer(m, True)), i)
    cast = [Cast("double", e) for e in (Element(Variable("got"), i), Element(Variable("expected"), place))]
    told = Do(Call("(void)printf", (Text("frame %u, element %u: %a instead of %a\n"), k, i, *cast)))
    differs = When(
        Call("differ", (AddressOf(Element(Variable("got"), i)), AddressOf(Element(Variable("expected"), place)))),
        (When(Binary("<", wrong, Integer(10, True)), (told,)), Assign(wrong, Binary("+", wrong, Integer(1, True)))),
    )
    frame: list[Statement] = [
        *_moves(program.inputs, face.inputs, "input", Variable("given"), Binary("*", k, Integer(n, True))),
        Do(Call(face.step, tuple(AddressOf(Variable(name)) for name in ("state", "input", "output")))),
        *_moves(program.outputs, face.outputs, "output", Variable("got"), None),
        *((Repeat("i", m, (differs,)),) if m else ()),
    ]
    summary = f"{frames} frames of {face.prefix}: %u of {frames * m} outputs differ\n"
    body: list[Statement] = [
        Declare(f"static {face.state_struct}", "state", None),
        Declare(f"static {face.input_struct}", "input", None),
        Declare(f"static {face.output_struct}", "output", None),
        *((DeclareArray(f"static {kind}", "got", m),) if m else ()),
        Declare("unsigned int", "wrong", Integer(0, True)),
        Do(Call(face.init, (AddressOf(Variable("state")),))),
        Repeat("k", frames, tuple(frame)),
        Do(Call("(void)printf", (Text(summary), wrong))),
        Return(Conditional(Binary("==", wrong, Integer(0, True)), Integer(0), Integer(1))),
    ]
    items += [*([_differ(kind, bits)] if m else []), Function("int", "main", (), tuple(body), False)]
    head = f"Compares {face.prefix}_step with the interpreter, bit by bit. Exit code 0: every bit agrees."
    return File("selfcheck.c", head, tuple(items))


def _rows(ports: tuple[ProgramPort, ...], arrays: Mapping[str, np.ndarray]) -> np.ndarray:
    """(frames, elements) in the order of the ports."""
    parts = [np.asarray(arrays[port.name], dtype=np.float64).reshape(-1, port.type.size) for port in ports]
    frames = len(next(iter(arrays.values()))) if arrays else 0
    return np.concatenate(parts, axis=1) if parts else np.zeros((frames, 0))


def _array(kind: str, bits: int, name: str, rows: np.ndarray, comment: str) -> ConstantArray:
    if bits == 32:
        with np.errstate(all="ignore"):
            rows = rows.astype(np.float32)
    return ConstantArray(kind, name, tuple(Real(float(v), bits) for v in rows.ravel()), comment)


def _moves(
    ports: tuple[ProgramPort, ...], names: tuple[str, ...], struct: str, row: Expression, first: Expression | None
) -> list[Statement]:
    """Between the fields of a struct and a row of numbers: from the row if it begins at ``first``, else into it."""
    statements: list[Statement] = []
    start = 0
    for port, name in zip(ports, names, strict=True):
        field: Expression = Member(Variable(struct), name)
        place: Expression = Integer(start, True)
        if port.type.shape:
            field, place = Element(field, Variable("j")), Binary("+", Integer(start, True), Variable("j"))
        if first is not None:
            value: Expression = Element(row, Binary("+", first, place))
            move = Assign(field, Binary(">", value, Integer(0)) if port.type.boolean else value)
        else:
            one = Conditional(field, Integer(1), Integer(0)) if port.type.boolean else field
            move = Assign(Element(row, place), one)
        statements.append(Repeat("j", port.type.size, (move,)) if port.type.shape else move)
        start += port.type.size
    return statements


def _differ(kind: str, bits: int) -> Function:
    """Whether two reals differ in a bit; any NaN equals any NaN."""
    a, b, i = Variable("a"), Variable("b"), Variable("i")
    p, q = Variable("p"), Variable("q")
    different = Variable("different")
    zero = Real(0.0, bits)

    def number(x: Variable) -> Expression:
        value = Element(x, Integer(0, True))
        return Binary("||", Binary("<=", value, zero), Binary(">", value, zero))

    body: tuple[Statement, ...] = (
        Declare("const unsigned char *", "p", Cast("const unsigned char *", a)),
        Declare("const unsigned char *", "q", Cast("const unsigned char *", b)),
        Declare("int", "different", Integer(0)),
        Repeat("i", bits // 8, (When(Binary("!=", Element(p, i), Element(q, i)), (Assign(different, Integer(1)),)),)),
        Return(Binary("&&", different, Binary("||", number(a), number(b)))),
    )
    parameters = (Parameter(f"const {kind} *", "a"), Parameter(f"const {kind} *", "b"))
    return Function("int", "differ", parameters, body, True)
