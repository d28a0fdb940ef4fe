"""Operation counts, derived from the frame program: by kind, and by sub-sheet."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from saoflow.operations import COUNTED_KINDS, Kind
from saoflow.scheduler.program import FrameProgram, ProgramBody


@dataclass(slots=True)
class CountTree:
    """The operations of one path (a sheet instance or a block) and of everything below it."""

    name: str
    kinds: Counter[str] = field(default_factory=Counter)
    parts: dict[str, CountTree] = field(default_factory=dict)

    @property
    def total(self) -> int:
        """All operations."""
        return sum(self.kinds.values())

    def add(self, path: tuple[str, ...], kinds: Counter[str]) -> None:
        """Count operations at a path below this one."""
        here = self
        here.kinds.update(kinds)
        for part in path:
            here = here.parts.setdefault(part, CountTree(part))
            here.kinds.update(kinds)

    def graft(self, path: tuple[str, ...], tree: CountTree) -> None:
        """Count a whole tree at a path below this one."""
        for step in [()] + [path[: i + 1] for i in range(len(path))]:
            here = self
            for part in step:
                here = here.parts.setdefault(part, CountTree(part))
            here.kinds.update(tree.kinds)
        target = self
        for part in path:
            target = target.parts[part]
        _merge(target, tree)

    def to_dict(self) -> dict[str, object]:
        """The machine-readable form."""
        return {
            "name": self.name,
            "operations": self.total,
            "kinds": {kind: self.kinds[kind] for kind in COUNTED_KINDS if self.kinds[kind]},
            "parts": [part.to_dict() for part in self.parts.values()],
        }


def _merge(target: CountTree, tree: CountTree) -> None:
    """Add the parts of a tree; the target's own kinds are counted already."""
    for name, part in tree.parts.items():
        below = target.parts.setdefault(name, CountTree(name))
        below.kinds.update(part.kinds)
        _merge(below, part)


def count(program: FrameProgram) -> CountTree:
    """The operations of one frame, as a tree of instance paths."""
    trees: list[CountTree] = []
    for body in program.procedures:
        trees.append(_count_body(body, trees))
    root = CountTree(program.sheet)
    for group in program.groups:
        tree = _count_body(group.body, trees)
        root.kinds.update(tree.kinds)
        _merge(root, tree)
    return root


def frame_loads(program: FrameProgram) -> dict[str, list[int]]:
    """``operations`` and each kind in every frame of the hyperperiod; a frame is one number where all are alike."""
    trees: list[CountTree] = []
    for body in program.procedures:
        trees.append(_count_body(body, trees))
    rates = {rate.path: rate for rate in program.rates}
    loads: dict[str, np.ndarray] = {"operations": np.zeros(program.hyperperiod, dtype=np.int64)}
    for group in program.groups:
        for op in group.body.operations:
            kinds = trees[op.detail].kinds if op.kind is Kind.CALL else Counter({op.kind.counted_as: 1})
            rate = None if op.guard is None else rates[group.body.origins[op.origin].path]
            runs = slice(None) if rate is None else slice(rate.offset, None, rate.every)
            for kind, n in kinds.items():
                if kind:
                    loads.setdefault(kind, np.zeros(program.hyperperiod, dtype=np.int64))[runs] += n
                    loads["operations"][runs] += n
    return {kind: load.tolist() for kind, load in loads.items()}


def count_procedures(procedures: Sequence[ProgramBody]) -> list[int]:
    """The operations of each procedure with all that it calls; each calls earlier ones only."""
    totals: list[int] = []
    for body in procedures:
        totals.append(
            sum(totals[op.detail] if op.kind is Kind.CALL else bool(op.kind.counted_as) for op in body.operations)
        )
    return totals


def _count_body(body: ProgramBody, procedures: list[CountTree]) -> CountTree:
    tree = CountTree(body.name)
    by_origin: dict[int, Counter[str]] = {}
    for op in body.operations:
        if op.kind is Kind.CALL:
            tree.graft(split_path(body.origins[op.origin].path), procedures[op.detail])
        elif op.kind.counted_as:
            by_origin.setdefault(op.origin, Counter())[op.kind.counted_as] += 1
    for origin, kinds in by_origin.items():
        tree.add(split_path(body.origins[origin].path), kinds)
    return tree


def split_path(path: str) -> tuple[str, ...]:
    """``step3.ip[2].K#1`` as its parts; wiring that a block needed belongs to the block."""
    return tuple(part.split("#")[0] for part in path.split("."))
