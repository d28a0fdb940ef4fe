"""The stages of a sheet as text: what ``saoflow show --stage`` prints."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Iterator
from typing import TYPE_CHECKING

from saoflow.diagnosis import Position
from saoflow.diagrams.netlist import POISON, Body, Node, Structure
from saoflow.operations import Atom, Kind, Literal

if TYPE_CHECKING:
    from saoflow.pipeline import LoadedSheet
    from saoflow.scheduler.program import FrameProgram, Operation, ProgramBody
    from saoflow.scheduler.schedule import Schedule


def stage_text(sheet: LoadedSheet, stage: str) -> str:
    """The text of a stage: ``sheet``, ``netlist``, ``schedule``, ``program`` or ``python``. Raises DiagnosisError."""
    makers: dict[str, Callable[[LoadedSheet], Iterable[str]]] = {
        "sheet": _sheet,
        "netlist": lambda s: _bodies(s.netlist.root),
        "schedule": lambda s: _schedules(s.schedule),
        "program": lambda s: _program(s.frame_program),
        "python": _python,
    }
    return "\n".join(makers[stage](sheet))


# -- sheet


def _sheet(loaded: LoadedSheet) -> Iterator[str]:
    """The text as it was read, with line numbers, and the numbers of its parameters."""
    sheet = loaded.sheet
    yield f"# {sheet.file}"
    lines = sheet.lines if not sheet.lines or sheet.lines[-1] else sheet.lines[:-1]
    width = len(str(len(lines)))
    yield from (f"{number:>{width}} | {line}".rstrip() for number, line in enumerate(lines, start=1))
    values = loaded.netlist.parameters
    if values:
        yield ""
        yield "# parameters"
        longest = max(len(name) for name, _ in values)
        yield from (f"{name:<{longest}} = {value}" for name, value in values)


# -- netlist and schedule


def _bodies(root: Body) -> Iterator[str]:
    """Every body once: its ports, its nodes with operands, and the type of every wire."""
    seen: dict[int, str] = {}
    queue = [root]
    while queue:
        body = queue.pop(0)
        if id(body) in seen:
            continue
        seen[id(body)] = body.structure.sheet
        yield from _body(body, range(len(body.nodes)))
        queue.extend(child for child in body.children if child is not None and id(child) not in seen)


def _schedules(root: Schedule) -> Iterator[str]:
    """Every body once, its nodes in the order in which they run."""
    seen: set[int] = set()
    queue = [root]
    while queue:
        schedule = queue.pop(0)
        if id(schedule) in seen:
            continue
        seen.add(id(schedule))
        yield from _body(schedule.body, schedule.order)
        queue.extend(child for child in schedule.children if child is not None and id(child) not in seen)


def _body(body: Body, order: Iterable[int]) -> Iterator[str]:
    structure = body.structure
    names = _wires(structure)
    yield f"sheet {structure.sheet} ({structure.file})"
    for port in structure.inputs:
        yield f"  input  {port.name}: {body.type_of(port.wire)}"
    for i in order:
        yield f"  {_node(body, i, names)}"
    for out in structure.outputs:
        yield f"  output {out.name} = {names[out.wire]}: {body.type_of(out.wire)}"
    yield ""


def _node(body: Body, i: int, names: dict[int, str]) -> str:
    node, child = body.nodes[i], body.children[i]
    what = child.structure.sheet if child is not None else node.symbol.name if node.symbol is not None else "?"
    operands = ", ".join("-" if w is None or w == POISON else names[w] for w in node.inputs)
    results = ", ".join(f"{names[w]}: {body.type_of(w)}" for w in node.outputs)
    return f"{results} = {what}({operands})  # line {node.position.line}"


def _wires(structure: Structure) -> dict[int, str]:
    names = {port.wire: port.name for port in structure.inputs}
    for node in structure.nodes:
        for number, wire in enumerate(node.outputs):
            names[wire] = node.path if node.child is None else _port_path(node, number)
    return names


def _port_path(node: Node, number: int) -> str:
    assert node.child is not None
    return f"{node.path}.{node.child.outputs[number].name}"


# -- frame program


def _program(program: FrameProgram) -> Iterator[str]:
    """The frame program in single assignment: a value, its operation, the wire and the line that it comes from."""
    yield f"frame program of {program.sheet}, reals of {program.real} bits"
    for port in program.inputs:
        yield f"  input  {port.name}: {port.type} = {_atoms(port.tensor.atoms)}"
    for number, table in enumerate(program.tables):
        kind = "linear" if table.linear else "hold"
        yield f"  table  t{number}: {table.name}, {' x '.join(map(str, table.values.shape))} points, {kind}"
    for number, slot in enumerate(program.states):
        place = f"element {slot.element}, age {slot.age}"
        yield f"  state  s{number}: {slot.path}, {place}, starts at {_atom(Literal(slot.initial))}"
    for number, body in enumerate(program.procedures):
        yield ""
        yield f"procedure p{number} {body.name}({', '.join(f'v{v}' for v in body.parameters)})"
        yield from _operations(body)
        yield f"  return {_atoms(body.results)}"
    for group in program.groups:
        yield ""
        yield f"frame, every {group.every} from {group.offset}"
        yield from _operations(group.body)
    yield ""
    for port in (*program.outputs, *program.probes):
        yield f"  output {port.name}: {port.type} = {_atoms(port.tensor.atoms)}"


def _operations(body: ProgramBody) -> Iterator[str]:
    texts = [_operation(op) for op in body.operations]
    width = min(60, max(map(len, texts), default=0))
    for op, text in zip(body.operations, texts, strict=True):
        origin = body.origins[op.origin] if op.origin >= 0 else None
        place = "" if origin is None else f"  # {origin.path}, {_place(origin.position)}"
        yield f"  {text:<{width}}{place}".rstrip()


def _operation(op: Operation) -> str:
    operands = [_atom(a) for a in op.operands]
    results = ", ".join(f"v{r}" for r in op.results)
    if op.kind is Kind.READ:
        return f"{results} = read s{op.detail}"
    if op.kind is Kind.WRITE:
        return f"write s{op.detail} = {operands[0]}"
    if op.kind is Kind.CALL:
        held = "" if op.guard is None else f" if v{op.guard} else {', '.join(map(_atom, op.otherwise))}"
        return f"{results} = call p{op.detail}({', '.join(operands)}){held}"
    if op.kind is Kind.LOOKUP:
        return f"{results} = lookup t{op.detail}({', '.join(operands)})"
    if op.kind in (Kind.LESS, Kind.LESS_EQUAL):
        return f"{results} = compare {operands[0]} {op.kind.detail} {operands[1]}"
    name = op.kind.detail if op.kind.counted_as == "logic" else op.kind.counted_as
    return f"{results} = {name} {' '.join(operands)}"


def _place(position: Position) -> str:
    return f"{os.path.basename(position.file)}:{position.line}"


def _atom(atom: Atom) -> str:
    if isinstance(atom, Literal):
        return ("true" if atom.value else "false") if isinstance(atom.value, bool) else repr(float(atom.value))
    return f"v{atom}"


def _atoms(atoms: Iterable[Atom]) -> str:
    listed = [_atom(a) for a in atoms]
    return listed[0] if len(listed) == 1 else f"[{', '.join(listed)}]"


def _python(loaded: LoadedSheet) -> Iterator[str]:
    """What the interpreter runs for one flight, with the numbers of its literals."""
    from saoflow.scheduler.python_printer import SCALAR, print_python

    source = print_python(loaded.frame_program, SCALAR)
    yield from (f"k{i} = {_atom(literal)}" for i, literal in enumerate(source.literals))
    yield source.text.rstrip("\n")
