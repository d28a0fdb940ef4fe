"""What sheets are made of, for the documentation: every symbol with the cost of its examples, every library sheet."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from saoflow.blocks.library import SYMBOLS, AnySymbol
from saoflow.operations import COUNTED_KINDS
from saoflow.scheduler.budget import BudgetReport

EXAMPLE = """\
sheet: example
inputs:
  x: {{shape: []}}
  y: {{shape: []}}
  z: {{shape: []}}
  v: {{shape: [3]}}
  w: {{shape: [3]}}
  A: {{shape: [2, 2]}}
  B: {{shape: [2, 2]}}
  d: {{shape: [2]}}
  p: {{shape: [], type: boolean}}
  q: {{shape: [], type: boolean}}
blocks:
  D: {{diagonal: d}}
  result: {block}
outputs: [result]
"""
"""A sheet around one block; its wires are those that the examples of symbols may use."""


@dataclass(frozen=True, slots=True)
class Example:
    """A block as a sheet writes it, and what it costs."""

    text: str
    cost: str


@dataclass(frozen=True, slots=True)
class Member:
    """A port or parameter: its name and meaning."""

    name: str
    doc: str


@dataclass(frozen=True, slots=True)
class SymbolEntry:
    """All that the documentation says about a symbol."""

    name: str
    profile: str
    summary: str
    equation: str
    ports: tuple[Member, ...]
    parameters: tuple[Member, ...]
    examples: tuple[Example, ...]

    def text(self) -> Iterator[str]:
        """The entry in full."""
        yield f"{self.name}: {self.summary}"
        yield f"  {self.equation}"
        yield f"  profile {self.profile}"
        yield from _members("inputs", self.ports)
        yield from _members("parameters", self.parameters)
        yield "  examples, and what they cost in a frame:"
        width = max(len(example.text) for example in self.examples)
        yield from (f"    {example.text:<{width}}  {example.cost}" for example in self.examples)

    def to_dict(self) -> dict[str, object]:
        """The machine-readable form."""
        return {
            "name": self.name,
            "profile": self.profile,
            "summary": self.summary,
            "equation": self.equation,
            "ports": [{"name": p.name, "doc": p.doc} for p in self.ports],
            "parameters": [{"name": p.name, "doc": p.doc} for p in self.parameters],
            "examples": [{"text": e.text, "cost": e.cost} for e in self.examples],
        }


@dataclass(frozen=True, slots=True)
class LibrarySheet:
    """A composite of the library: a sheet that is used as if it were a symbol."""

    name: str
    doc: str
    equations: str
    profile: str
    inputs: tuple[Member, ...]
    parameters: tuple[Member, ...]
    outputs: tuple[Member, ...]

    def text(self) -> Iterator[str]:
        """The entry in full."""
        yield f"{self.name}: {self.doc}"
        yield from (f"  {line}" for line in self.equations.splitlines())
        yield f"  library sheet, profile {self.profile}"
        yield from _members("inputs", self.inputs)
        yield from _members("parameters", self.parameters)
        yield from _members("outputs", self.outputs)

    def to_dict(self) -> dict[str, object]:
        """The machine-readable form."""
        return {
            "name": self.name,
            "doc": self.doc,
            "equations": self.equations,
            "profile": self.profile,
            **{
                key: [{"name": m.name, "doc": m.doc} for m in members]
                for key, members in (
                    ("inputs", self.inputs),
                    ("parameters", self.parameters),
                    ("outputs", self.outputs),
                )
            },
        }


def _members(title: str, members: tuple[Member, ...]) -> Iterator[str]:
    if members:
        yield f"  {title}:"
        width = max(len(member.name) for member in members)
        yield from (f"    {member.name:<{width}}  {member.doc}".rstrip() for member in members)


def symbol_entries() -> list[SymbolEntry]:
    """Every symbol, in the order of the registry."""
    return [_entry(symbol) for symbol in SYMBOLS.values()]


def _entry(symbol: AnySymbol) -> SymbolEntry:
    last = len(symbol.ports) - 1
    ports = []
    for i, port in enumerate(symbol.ports):
        many = ", any number of them" if symbol.variadic and i == last else ""
        ports.append(Member(port.name, f"{port.doc}{many}{' (optional)' if port.optional else ''}"))
    parameters = []
    for p in symbol.parameters:
        words = f": {', '.join(p.words)} (default {p.words[0]})" if p.words else ""
        parameters.append(Member(p.name, p.doc + words))
    examples = tuple(Example(text, cost_text(example_report(text))) for text in symbol.examples)
    return SymbolEntry(
        symbol.name, symbol.profile, symbol.summary, symbol.equation, tuple(ports), tuple(parameters), examples
    )


def example_report(block: str) -> BudgetReport:
    """The operations of a frame of one block, counted as those of any sheet."""
    from saoflow.diagrams.reader import read_text
    from saoflow.diagrams.store import SheetStore
    from saoflow.pipeline import LoadedSheet

    sheet = read_text(EXAMPLE.format(block=block), "example")
    store = SheetStore()
    store.sources.add(sheet.file, sheet.lines)
    return LoadedSheet(sheet, store).budget()


def cost_text(report: BudgetReport) -> str:
    """``2 add, 1 lookup (11 points, 4 search steps)``; ``free`` for wiring."""
    parts = [f"{report.tree.kinds[kind]} {kind}" for kind in COUNTED_KINDS if report.tree.kinds[kind]]
    for table in report.tables:
        parts[-1] += f" ({table.points} points, {table.search_steps} search steps)"
    if report.state_slots:
        parts.append(f"{report.state_slots} state {'slot' if report.state_slots == 1 else 'slots'}")
    return ", ".join(parts) or "free"


def library_sheets() -> list[LibrarySheet]:
    """Every sheet of the library, by name. Raises DiagnosisError if one cannot be read."""
    from saoflow.diagrams.store import LIBRARY

    return [_library_sheet(path) for path in sorted(LIBRARY.glob("*.yaml"))]


def _library_sheet(path: Path) -> LibrarySheet:
    from saoflow.diagrams.reader import read_sheet

    sheet = read_sheet(path)
    return LibrarySheet(
        sheet.name.text,
        " ".join(sheet.doc.split()),
        sheet.equations.strip(),
        sheet.profile.text if sheet.profile is not None else "any",
        tuple(Member(i.name.text, i.doc) for i in sheet.inputs),
        tuple(Member(p.name.text, p.doc) for p in sheet.parameters),
        tuple(Member(o.name.text, o.doc) for o in sheet.outputs),
    )
