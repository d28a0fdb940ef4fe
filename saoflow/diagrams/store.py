"""Finding sheets by name: beside the sheet that uses them, in the library, among the shipped sheets."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import cached_property
from pathlib import Path

from saoflow.diagnosis import Diagnosis, DiagnosisError, did_you_mean
from saoflow.diagrams.netlist import SourceLines
from saoflow.diagrams.reader import read_sheet, read_text
from saoflow.diagrams.sheet import Sheet
from saoflow.diagrams.shipped import LIBRARY, SHIPPED, estimators, place_of, shipped_sheets, shown_path

__all__ = ["LIBRARY", "SHIPPED", "SheetStore"]


class SheetStore:
    """Reads each sheet once. Never looks outside the folder of the sheet named by the user and the shipped sheets."""

    def __init__(self, texts: Mapping[Path, str] | None = None) -> None:
        """``texts``: what stands in the place of files, by resolved path: an editor's open buffers."""
        self.texts = texts or {}
        self.sources = SourceLines()
        self._sheets: dict[Path, Sheet | DiagnosisError] = {}
        self._by_file: dict[str, Sheet] = {}

    @cached_property
    def shipped(self) -> dict[str, Path]:
        """The shipped sheets by name; the library first."""
        return shipped_sheets()

    def open(self, name: str) -> Sheet:
        """The sheet that a user names: a path, or the name of a shipped sheet. Raises DiagnosisError E602 and others."""
        path = place_of(name, self.shipped)
        if path is not None:
            return self._read(path)
        raise DiagnosisError(
            [
                Diagnosis(
                    "E602",
                    f"there is no sheet `{name}`",
                    cause="it is neither a path to a YAML file nor the name of a shipped sheet",
                    remedy=did_you_mean(name, self.shipped)
                    or f"shipped estimators: {', '.join(estimators())}; `saoflow symbols` lists the library",
                )
            ]
        )

    def names_beside(self, user: Sheet) -> list[str]:
        """The sheets that ``user`` may use, for did-you-mean."""
        folder = Path(user.file).parent
        beside = [p.stem for p in folder.glob("*.yaml")] if folder.is_dir() else []
        return sorted({*beside, *self.shipped})

    def find(self, name: str, user: Sheet) -> Sheet | None:
        """The sheet that ``user`` names, or None if there is none. Raises DiagnosisError if it cannot be read."""
        if not name.isidentifier():
            return None
        beside = Path(user.file).parent / f"{name}.yaml"
        if beside.is_file():
            return self._read(beside)
        if name in self.shipped:
            return self._read(self.shipped[name])
        return None

    def sheet_of(self, file: str) -> Sheet | None:
        """The sheet that was read from a file, by the file's name as positions have it."""
        return self._by_file.get(file)

    def _with_parameters_of(self, sheet: Sheet) -> Sheet:
        """The sheet with the parameters of another that it names, those that it declares itself in their place."""
        named = sheet.parameters_of
        if named is None:
            return sheet
        other = None if named.text == sheet.name.text else self.find(named.text, sheet)
        if other is None or other.parameters_of is not None:
            cause = f"there is no sheet of that name in the library or beside {sheet.file}"
            remedy = did_you_mean(named.text, self.names_beside(sheet)) or "name a sheet that declares parameters"
            if other is not None:
                cause, remedy = "it takes its own parameters from another sheet", "name the sheet that declares them"
            line = self.sources.line(named.position)
            message = f"cannot take the parameters of `{named.text}`"
            raise DiagnosisError([Diagnosis("E201", message, named.position, cause, remedy, source_line=line)])
        own = {p.name.text: p for p in sheet.parameters}
        taken = [own.pop(p.name.text, p) for p in other.parameters]
        return replace(sheet, parameters=(*taken, *own.values()))

    def _read(self, path: Path) -> Sheet:
        key = path.resolve()
        if key not in self._sheets:
            try:
                shown = shown_path(path)
                sheet = read_text(self.texts[key], str(shown)) if key in self.texts else read_sheet(shown)
                self.sources.add(sheet.file, sheet.lines)
                self._by_file[sheet.file] = self._sheets[key] = self._with_parameters_of(sheet)
            except DiagnosisError as error:
                self._sheets[key] = error
        found = self._sheets[key]
        if isinstance(found, DiagnosisError):
            raise found
        return found
