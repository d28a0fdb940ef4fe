"""What every compiler makes of a few operations on the way: negations, doublings, calls from one place.

``-1 * a`` is a change of sign, ``2 * a`` is ``a + a``, a negation that only sums read is folded into subtractions, and a
procedure called from one place is laid out there. All are exact, so the bits stay.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence, Set
from dataclasses import replace

from saoflow.operations import MINUS_ONE, Atom, Kind, Literal
from saoflow.scheduler.program import FrameProgram, Operation, ProgramBody

TWO = Literal(2.0)

BRANCHING = frozenset({Kind.MINIMUM, Kind.MAXIMUM, Kind.SELECT, Kind.LOOKUP})
"""Operations that GCC makes branches of."""

SIZES = {Kind.MINIMUM: 3, Kind.MAXIMUM: 3, Kind.SELECT: 3, Kind.LOOKUP: 10}
"""Of operations in GCC's measure of a function's size, where not 1."""


def call_counts(bodies: Sequence[ProgramBody], procedures: int) -> list[int]:
    """How often a frame runs each body: procedures first, then a body for each rate group, once each."""
    times = [0] * procedures + [1] * (len(bodies) - procedures)
    for i in range(len(bodies) - 1, -1, -1):
        for operation in bodies[i].operations:
            if operation.kind is Kind.CALL:
                times[operation.detail] += times[i]
    return times


def inlined(program: FrameProgram) -> tuple[ProgramBody, ...]:
    """The bodies of a program with some procedures laid out where they are called (and left, uncalled, in the list).

    GCC lays one out where the code does not grow by it: where its size, as often as it is called but once, is at most
    what its calls cost with their arguments.
    """
    sites = Counter(o.detail for body in program.bodies for o in body.operations if o.kind is Kind.CALL)
    bodies: list[ProgramBody] = []
    laid_out: set[int] = set()
    for i, body in enumerate(program.bodies):
        bodies.append(_inline(body, bodies, laid_out))
        calls = sites[i] if i < len(program.procedures) else 0
        if calls and _size(bodies[i], bodies) * (calls - 1) <= calls * _call_size(body):
            laid_out.add(i)
    return tuple(bodies)


def _call_size(body: ProgramBody) -> int:
    """A call in GCC's measure: two words for each real argument, one for a boolean, and what calls cost anyway."""
    return 8 + sum(1 if body.booleans[v] else 2 for v in body.parameters)


def _size(body: ProgramBody, bodies: Sequence[ProgramBody]) -> int:
    """A body in GCC's measure: one for an operation and for a result stored, more where it branches."""
    return len(body.results) + sum(_call_size(bodies[o.detail]) if o.kind is Kind.CALL else SIZES.get(o.kind, 1) for o in body.operations)


def _inline(body: ProgramBody, procedures: Sequence[ProgramBody], laid_out: Set[int]) -> ProgramBody:
    if not any(o.kind is Kind.CALL and o.detail in laid_out for o in body.operations):
        return body
    booleans = list(body.booleans)
    operations: list[Operation] = []
    names: dict[int, Atom] = {}

    def renamed(atoms: Sequence[Atom], table: dict[int, Atom]) -> tuple[Atom, ...]:
        return tuple(a if isinstance(a, Literal) else table.get(a, a) for a in atoms)

    for o in body.operations:
        operands = renamed(o.operands, names)
        if o.kind is not Kind.CALL or o.detail not in laid_out:
            operations.append(replace(o, operands=operands))
            continue
        inner = procedures[o.detail]
        table: dict[int, Atom] = dict(zip(inner.parameters, operands, strict=True))
        for i in inner.operations:
            fresh = tuple(range(len(booleans), len(booleans) + len(i.results)))
            booleans += [inner.booleans[r] for r in i.results]
            inner_operands = renamed(i.operands, table)
            table.update(zip(i.results, fresh, strict=True))
            operations.append(replace(i, results=fresh, operands=inner_operands, origin=o.origin))
        names.update(zip(o.results, renamed(inner.results, table), strict=True))
    results = renamed(body.results, names)
    return ProgramBody(body.name, body.parameters, tuple(operations), results, tuple(booleans), body.origins)


def branches(operations: Sequence[Operation], conditional_moves: bool) -> list[bool]:
    """By operation: whether a compiler branches there.

    Where moves can be conditional, a limit and a selection between values that are there anyway need no branch; of a value
    limited by two constants the first is known to hold where the second is reached past it, so that branch stays.
    """
    if not conditional_moves:
        return [o.kind in BRANCHING for o in operations]
    uses: Counter[Atom] = Counter(a for o in operations for a in o.reads)
    maker = {r: k for k, o in enumerate(operations) for r in o.results}
    found = [o.kind is Kind.LOOKUP for o in operations]
    for k, o in enumerate(operations):
        if o.kind is Kind.SELECT:
            found[k] = any(
                isinstance(a, int) and uses[a] == 1 and a in maker and _computed(operations[maker[a]])
                for a in o.operands[1:]
            )
        elif o.kind in (Kind.MINIMUM, Kind.MAXIMUM) and any(isinstance(a, Literal) for a in o.operands):
            for a in o.operands:
                first = maker.get(a) if isinstance(a, int) else None
                if first is not None and operations[first].kind in (Kind.MINIMUM, Kind.MAXIMUM):
                    found[first] |= any(isinstance(b, Literal) for b in operations[first].operands)
    return found


def _computed(o: Operation) -> bool:
    """Whether a compiler moves an operation to the one side of a branch that needs it."""
    return o.kind not in (Kind.READ, Kind.CALL, Kind.SELECT, Kind.MINIMUM, Kind.MAXIMUM, Kind.LOOKUP)


def blocks(body: ProgramBody, conditional_moves: bool) -> list[int]:
    """By operation: how many operations before it branch."""
    found: list[int] = []
    count = 0
    for branch in branches(body.operations, conditional_moves):
        found.append(count)
        count += branch
    return found


def shared(body: ProgramBody) -> ProgramBody:
    """The body with operations left out that repeat an earlier one: the same kind on the same operands."""
    names: dict[Atom, Atom] = {}
    made: dict[tuple[Kind, int, tuple[Atom, ...]], tuple[int, ...]] = {}
    operations: list[Operation] = []
    for o in body.operations:
        operands = tuple(names.get(a, a) for a in o.operands)
        key = (o.kind, o.detail, operands)
        if o.kind in (Kind.ADD, Kind.MULTIPLY):
            key = (o.kind, o.detail, tuple(sorted(operands, key=repr)))
        if o.kind not in (Kind.READ, Kind.WRITE, Kind.CALL):
            first = made.setdefault(key, o.results)
            if first is not o.results:
                names.update(zip(o.results, first, strict=True))
                continue
        operations.append(o if operands == o.operands else replace(o, operands=operands))
    return replace(body, operations=tuple(operations), results=tuple(names.get(r, r) for r in body.results))


def folded_negations(body: ProgramBody) -> frozenset[int]:
    """Results of ``-1 * a`` that only sums and differences of two reals read: each is folded into its readers."""
    readers: dict[int, list[Kind]] = {}
    for o in body.operations:
        for a in o.operands:
            if isinstance(a, int):
                readers.setdefault(a, []).append(o.kind)
    kept = set(body.results)
    sums = (Kind.ADD, Kind.SUBTRACT)
    return frozenset(
        o.results[0]
        for o in body.operations
        if is_negation(o) and o.results[0] not in kept and all(k in sums for k in readers.get(o.results[0], ()))
    )


def chained_products(body: ProgramBody) -> dict[int, Operation]:
    """Sums and differences by result that take up a product which nothing else reads: ``c + a * b`` in one instruction."""
    uses: Counter[Atom] = Counter(a for o in body.operations for a in o.operands)
    uses.update(body.results)
    products = {
        o.results[0]: o
        for o in body.operations
        if o.kind is Kind.MULTIPLY and uses[o.results[0]] == 1 and not is_negation(o) and not is_doubling(o)
    }
    found: dict[int, Operation] = {}
    for o in body.operations:
        if o.kind in (Kind.ADD, Kind.SUBTRACT):
            for a in reversed(o.operands):
                if isinstance(a, int) and a in products:
                    found[o.results[0]] = products[a]
                    break
    return found


def flags(body: ProgramBody) -> frozenset[Atom]:
    """Results of comparisons that selections alone read, as their conditions: branched on, never a value."""
    found: set[Atom] = {r for o in body.operations if o.kind in (Kind.LESS, Kind.LESS_EQUAL) for r in o.results}
    for o in body.operations:
        found.difference_update(o.operands if o.kind is not Kind.SELECT else ())
    return frozenset(found.difference(body.results))


def is_negation(operation: Operation) -> bool:
    """Whether an operation is ``-1 * a``."""
    return operation.kind is Kind.MULTIPLY and MINUS_ONE in operation.operands


def is_doubling(operation: Operation) -> bool:
    """Whether an operation is ``2 * a``."""
    return operation.kind is Kind.MULTIPLY and TWO in operation.operands
