"""Independent checks of what the scheduler made: they share no code with it and trust nothing of it."""

from __future__ import annotations

from saoflow.diagnosis import Diagnosis, DiagnosisError
from saoflow.operations import Kind
from saoflow.scheduler.program import FrameProgram, ProgramBody
from saoflow.scheduler.schedule import Schedule


def validate_schedule(schedule: Schedule) -> None:
    """Every node once; every operand known when its node runs. Raises DiagnosisError E302."""
    seen: set[int] = set()
    stack = [schedule]
    while stack:
        here = stack.pop()
        if id(here) in seen:
            continue
        seen.add(id(here))
        stack.extend(child for child in here.children if child is not None)
        if sorted(here.order) != list(range(len(here.body.nodes))):
            _fail(here.body.structure.sheet, "the order does not hold every node exactly once")
        known = {port.wire for port in here.body.structure.inputs}
        for node in here.body.nodes:
            if node.symbol is not None and node.symbol.name == "delay":
                known.update(node.outputs)
        for i in here.order:
            node = here.body.nodes[i]
            delayed = node.symbol is not None and node.symbol.name == "delay"
            for wire in node.inputs:
                if wire is not None and not delayed and wire not in known:
                    _fail(here.body.structure.sheet, f"`{node.path}` runs before wire {wire} is known")
            known.update(node.outputs)


def validate_program(program: FrameProgram) -> None:
    """Each value once and before its use, booleans where booleans belong, state read and written once.

    Raises DiagnosisError E302.
    """
    for number, body in enumerate(program.procedures):
        _validate_body(program, body, number)
    for group in program.groups:
        _validate_body(program, group.body, len(program.procedures))
    reads = [op.detail for g in program.groups for op in g.body.operations if op.kind is Kind.READ]
    writes = [op.detail for g in program.groups for op in g.body.operations if op.kind is Kind.WRITE]
    if len(set(reads)) != len(reads) or sorted(writes) != list(range(len(program.states))):
        _fail(program.sheet, "a state slot is not read and written once a frame")


_LOGIC = (Kind.AND, Kind.OR, Kind.NOT)
_BOOLEAN_RESULT = (Kind.LESS, Kind.LESS_EQUAL, *_LOGIC)


def _validate_body(program: FrameProgram, body: ProgramBody, callable_below: int) -> None:
    known = set(body.parameters)
    for op in body.operations:
        for atom in op.reads:
            if isinstance(atom, int) and atom not in known:
                _fail(body.name, f"value {atom} is used before it is known ({op.kind.name})")
        if known.intersection(op.results):
            _fail(body.name, f"a value is computed twice ({op.kind.name})")
        known.update(op.results)
        _validate_kinds(body, op.kind, op.operands, op.results)
        if op.kind is Kind.CALL:
            if op.detail >= callable_below:
                _fail(body.name, "a procedure calls itself or a later one")
            called = program.procedures[op.detail]
            if len(op.operands) != len(called.parameters) or len(op.results) != len(called.results):
                _fail(body.name, f"a call of {called.name} has the wrong number of values")
            if op.guard is not None and not (body.booleans[op.guard] and len(op.otherwise) == len(op.results)):
                _fail(body.name, f"a guarded call of {called.name} does not say what its results are otherwise")
    for atom in body.results:
        if isinstance(atom, int) and atom not in known:
            _fail(body.name, f"result {atom} is never computed")


def _validate_kinds(body: ProgramBody, kind: Kind, operands: tuple[object, ...], results: tuple[int, ...]) -> None:
    def boolean(atom: object) -> bool:
        return body.booleans[atom] if isinstance(atom, int) else isinstance(getattr(atom, "value", None), bool)

    if kind in (Kind.CALL, Kind.READ, Kind.WRITE):
        return
    wanted = [kind in _LOGIC] * len(operands)
    if kind is Kind.SELECT:
        wanted = [True, boolean(operands[1]), boolean(operands[1])]
    if [boolean(atom) for atom in operands] != wanted:
        _fail(body.name, f"{kind.name} mixes booleans and reals")
    expected = kind in _BOOLEAN_RESULT or (kind is Kind.SELECT and wanted[1])
    if any(body.booleans[r] != expected for r in results):
        _fail(body.name, f"the result of {kind.name} has the wrong kind")


def _fail(where: str, what: str) -> None:
    raise DiagnosisError(
        [
            Diagnosis(
                "E302",
                f"the schedule of `{where}` fails its check: {what}",
                cause="this is a fault of saoflow, not of the sheet",
                remedy="please report it with the sheet",
            )
        ]
    )
