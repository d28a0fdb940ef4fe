"""The sheets that an editor works on: open buffers before files, what was last readable, and what is wrong."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from functools import cached_property, lru_cache
from pathlib import Path

from saoflow.diagnosis import Diagnosis, DiagnosisError
from saoflow.diagrams.reader import file_text, read_partly
from saoflow.diagrams.sheet import BlockDeclaration, IterationDeclaration, Sheet
from saoflow.diagrams.store import SheetStore
from saoflow.lsp.facts import Facts, facts_of
from saoflow.lsp.places import Place, places
from saoflow.pipeline import LoadedSheet

MOST_FILES = 400
"""Sheets of a folder that are looked through for uses."""


@lru_cache(maxsize=16)
def _lines(text: str) -> tuple[str, ...]:
    return tuple(text.splitlines())


@dataclass(eq=False)
class Readable:
    """A sheet as far as it can be read, and its names. ``diagnoses`` are the reader's."""

    sheet: Sheet
    diagnoses: tuple[Diagnosis, ...] = ()

    @cached_property
    def places(self) -> tuple[Place, ...]:
        """Every name with its place."""
        return tuple(places(self.sheet))

    @cached_property
    def uses(self) -> frozenset[str]:
        """The sheets that it names."""
        return frozenset(p.name for p in self.places if p.kind == "sheet" and not p.defines)

    @property
    def stands_alone(self) -> bool:
        """Whether it can run by itself: every parameter has a value."""
        return all(p.value is not None and not p.inherited for p in self.sheet.parameters)


@dataclass(eq=False)
class Sheets:
    """Open buffers and the files around them."""

    texts: dict[Path, str] = field(default_factory=dict)
    _read: dict[Path, tuple[object, Readable | None, tuple[Diagnosis, ...]]] = field(default_factory=dict)
    facts: dict[Path, Facts] = field(default_factory=dict)
    """What elaboration last found, by the file of the root."""

    def open(self, path: Path, text: str) -> None:
        """A buffer is opened or changed."""
        self.texts[path] = text

    def close(self, path: Path) -> None:
        """A buffer is closed: its file counts again."""
        self.texts.pop(path, None)

    def lines(self, path: Path) -> tuple[str, ...]:
        """The text as it now is, line by line; none where it cannot be read."""
        try:
            return _lines(self.texts[path] if path in self.texts else file_text(str(path)))
        except DiagnosisError:
            return ()

    def sheet(self, path: Path) -> Readable | None:
        """The sheet as it now is; while it cannot be read at all, as it last could."""
        return self._entry(path)[1]

    def _entry(self, path: Path) -> tuple[object, Readable | None, tuple[Diagnosis, ...]]:
        version: object = self.texts.get(path)
        if version is None:
            try:
                version = path.stat().st_mtime_ns
            except OSError:
                return (None, None, ())
        known = self._read.get(path)
        if known is not None and known[0] == version:
            return known
        try:
            text = self.texts[path] if path in self.texts else file_text(str(path))
            sheet, found = read_partly(text, str(path))
        except DiagnosisError as error:
            sheet, found = None, tuple(error.diagnoses)
        last = known[1] if known is not None else None
        self._read[path] = (version, Readable(sheet, found) if sheet is not None else last, found)
        return self._read[path]

    def around(self, path: Path) -> Iterator[tuple[Path, Readable]]:
        """The sheets of the folder of a sheet, open or not."""
        files = sorted({*path.parent.glob("*.yaml"), *(p for p in self.texts if p.parent == path.parent)})
        for file in files[:MOST_FILES]:
            found = self.sheet(file)
            if found is not None:
                yield file, found

    def find(self, name: str, user: Path) -> tuple[Path, Readable] | None:
        """The sheet that another one names: beside it, else among the shipped."""
        beside = user.parent / f"{name}.yaml"
        for path in (beside, SheetStore().shipped.get(name)):
            found = self.sheet(path) if path is not None else None
            if found is not None and path is not None:
                return path, found
        return None

    def roots(self, path: Path) -> list[Path]:
        """The sheets whose elaboration says what is wrong with this one: itself, or those that use it."""
        here = self.sheet(path)
        if here is None:
            return []
        if here.stands_alone:
            return [path]
        users = dict(self.around(path))
        reached, waiting = {here.sheet.name.text}, [here.sheet.name.text]
        roots = []
        while waiting:
            name = waiting.pop()
            for file, found in users.items():
                other = found.sheet.name.text
                if name in found.uses and other not in reached:
                    reached.add(other)
                    waiting.append(other)
                    if found.stands_alone:
                        roots.append(file)
        return sorted(roots, key=lambda file: (file not in self.texts, file))[:3]

    def check(self, path: Path) -> dict[Path, tuple[Diagnosis, ...]]:
        """Everything that is wrong, by file, found by reading this sheet and elaborating it or its users."""
        entry = self._entry(path)
        found: dict[Path, dict[Diagnosis, None]] = {path: dict.fromkeys(entry[2])}
        if not entry[2] and entry[1] is not None:
            for root in self.roots(path):
                for diagnosis in self._elaborate(root):
                    file = Path(diagnosis.position.file).resolve() if diagnosis.position else path
                    found.setdefault(file, {})[diagnosis] = None
        return {file: tuple(diagnoses) for file, diagnoses in found.items()}

    def _elaborate(self, root: Path) -> tuple[Diagnosis, ...]:
        store = SheetStore(dict(self.texts))
        try:
            loaded = LoadedSheet(store.open(str(root)), store)
            loaded.check()
            facts = facts_of(loaded)
            _ = facts.costs  # now, not when somebody hovers
            self.facts[root] = facts
            return ()
        except DiagnosisError as error:
            return tuple(error.diagnoses)

    def known(self, path: Path) -> Facts | None:
        """What elaboration last found about a sheet."""
        roots: Iterable[Path] = (path, *self.facts)
        return next((self.facts[r] for r in roots if r in self.facts and self.facts[r].knows(path)), None)

    def declarations(self, readable: Readable) -> dict[str, BlockDeclaration | IterationDeclaration]:
        """The blocks of a sheet by name."""
        return {block.name.text: block for block in readable.sheet.blocks}
