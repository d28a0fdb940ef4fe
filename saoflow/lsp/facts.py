"""What elaboration knows about the names of sheets: type, cost and path of the first instance, by the place of the name."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

from saoflow.diagnosis import Position
from saoflow.diagrams.netlist import Body
from saoflow.scheduler.counts import CountTree
from saoflow.wires import WireType

if TYPE_CHECKING:
    from saoflow.pipeline import LoadedSheet

Spot = tuple[str, int, int]
"""File, line, column."""


@dataclass(frozen=True, eq=False)
class Fact:
    """A wire of the first instance of its sheet."""

    path: str
    types: tuple[tuple[str, WireType], ...]
    """By output; "" for the only one of a symbol or an input."""


@dataclass(eq=False)
class Facts:
    """Facts by place. The cost of a frame is counted when it is first asked for."""

    loaded: LoadedSheet
    wires: dict[Spot, Fact]
    parameters: dict[str, str]
    """Values of the root's parameters."""

    def at(self, file: str, line: int, column: int) -> Fact | None:
        """The wire that is declared there."""
        return self.wires.get((str(Path(file).resolve()), line, column))

    def knows(self, path: Path) -> bool:
        """Whether a file takes part."""
        return str(path) in self._files

    @cached_property
    def _files(self) -> frozenset[str]:
        return frozenset(file for file, _, _ in self.wires)

    @cached_property
    def costs(self) -> CountTree:
        """Operations of every instance and block."""
        return self.loaded.budget().tree

    def cost(self, path: str) -> int | None:
        """Operations a frame of the instance at a path."""
        here = self.costs
        for part in path.split("."):
            if part not in here.parts:
                return 0
            here = here.parts[part]
        return here.total


def facts_of(loaded: LoadedSheet) -> Facts:
    """Gather the facts of an elaborated sheet."""
    wires: dict[Spot, Fact] = {}
    files: dict[str, str] = {}
    stack: list[tuple[Body, str]] = [(loaded.netlist.root, "")]
    seen: set[int] = set()
    while stack:
        body, prefix = stack.pop()
        if id(body) in seen:
            continue
        seen.add(id(body))
        for port in body.structure.inputs:
            _add(wires, files, port.position, prefix + port.name, [("", body.types[port.wire])])
        for node, child in zip(body.nodes, body.children, strict=True):
            if "#" in node.path.rpartition(".")[2] and node.declared is None:
                continue
            names = [p.name for p in node.child.outputs] if node.child is not None else [""]
            types = list(zip(names, (body.types[w] for w in node.outputs), strict=True))
            _add(wires, files, node.position, prefix + node.path, types)
            if child is not None:
                stack.append((child, f"{prefix}{node.path}."))
    return Facts(loaded, wires, dict(loaded.netlist.parameters))


def _add(
    wires: dict[Spot, Fact],
    files: dict[str, str],
    position: Position,
    path: str,
    types: list[tuple[str, WireType | None]],
) -> None:
    if position.file not in files:
        files[position.file] = str(Path(position.file).resolve())
    known = tuple((name, found) for name, found in types if found is not None)
    if known:
        wires.setdefault((files[position.file], position.line, position.column), Fact(path, known))
