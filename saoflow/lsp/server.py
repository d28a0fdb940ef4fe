"""The language server over stdin and stdout. Needs pygls (extra ``saoflow[lsp]``)."""

from __future__ import annotations

import threading
from collections.abc import Callable
from functools import wraps
from pathlib import Path
from typing import Any, TypeVar

from lsprotocol import types
from pygls.exceptions import JsonRpcInvalidParams
from pygls.lsp.server import LanguageServer
from pygls.uris import from_fs_path, to_fs_path
from pygls.workspace import PositionCodec

import saoflow
from saoflow.diagnosis import Diagnosis, Position
from saoflow.lsp import answers
from saoflow.lsp.completion import complete
from saoflow.lsp.places import Place
from saoflow.lsp.renaming import rename
from saoflow.lsp.workspace import Readable, Sheets

PAUSE = 0.25
"""Seconds of rest after a change, before sheets are checked."""

KINDS = {
    "key": types.CompletionItemKind.Keyword,
    "symbol": types.CompletionItemKind.Function,
    "sheet": types.CompletionItemKind.Class,
    "wire": types.CompletionItemKind.Variable,
    "output": types.CompletionItemKind.Property,
    "parameter": types.CompletionItemKind.Constant,
    "port": types.CompletionItemKind.Field,
    "unit": types.CompletionItemKind.Unit,
}

F = TypeVar("F", bound=Callable[..., Any])


class SheetServer(LanguageServer):
    """Open sheets, and the check that waits for a pause in typing."""

    def __init__(self) -> None:
        super().__init__("saoflow", saoflow.__version__, text_document_sync_kind=types.TextDocumentSyncKind.Full)
        self.sheets = Sheets()
        self.told: dict[Path, set[Path]] = {}
        """By checked sheet: the files that diagnoses were sent for."""
        self._waiting: threading.Timer | None = None
        self._changed: set[Path] = set()
        self._lock = threading.RLock()

    def changed(self, path: Path) -> None:
        """Check a sheet, and those open that use it, once the typing pauses."""
        with self._lock:
            self._changed.add(path)
            if self._waiting is not None:
                self._waiting.cancel()
            self._waiting = threading.Timer(PAUSE, self._check)
            self._waiting.daemon = True
            self._waiting.start()

    def _check(self) -> None:
        with self._lock:
            changed, self._changed = self._changed, set()
        names = {path.stem for path in changed}
        others = {p for p in list(self.sheets.texts) if (r := self.sheets.sheet(p)) is not None and r.uses & names}
        for path in sorted(changed | others):
            found = self.sheets.check(path)
            before = self.told.get(path, set())
            self.told[path] = set(found)
            for file in before - set(found):
                found[file] = ()
            for file, diagnoses in found.items():
                self._tell(file, diagnoses)

    def _tell(self, file: Path, diagnoses: tuple[Diagnosis, ...]) -> None:
        uri = from_fs_path(str(file))
        if uri is not None:
            sent = [_diagnostic(file, d) for d in diagnoses]
            self.text_document_publish_diagnostics(types.PublishDiagnosticsParams(uri=uri, diagnostics=sent))


server = SheetServer()


def _path(uri: str) -> Path:
    return Path(to_fs_path(uri) or "").resolve()


def _codec() -> PositionCodec:
    """Editors count in units of the encoding that was agreed on, UTF-16 if nothing was; saoflow counts characters."""
    return PositionCodec(server.workspace.position_encoding)


def _range(file: Path, at: Position) -> types.Range:
    number, start = at.line - 1, at.column - 1
    lines = server.sheets.lines(file)
    line = lines[number] if number < len(lines) else ""
    first, last = start, start + at.length
    if not line.isascii():
        units = _codec().client_num_units
        first = units(line[:start])
        last = first + units(line[start : start + at.length]) + max(0, start + at.length - len(line))
    return types.Range(types.Position(number, first), types.Position(number, last))


def _character(file: Path, position: types.Position) -> int:
    """The character that an editor's position is at, from 0."""
    lines = server.sheets.lines(file)
    line = lines[position.line] if position.line < len(lines) else ""
    if line.isascii():
        return position.character
    return _codec().position_from_client_units(lines, position).character


def _location(found: answers.Found) -> types.Location:
    return types.Location(uri=from_fs_path(str(found.file)) or "", range=_range(found.file, found.position))


def _diagnostic(file: Path, diagnosis: Diagnosis) -> types.Diagnostic:
    at = diagnosis.position or Position("", 1, 1)
    lines = [diagnosis.message, diagnosis.cause and f"cause: {diagnosis.cause}", diagnosis.remedy and f"remedy: {diagnosis.remedy}"]
    related = [
        types.DiagnosticRelatedInformation(_location(answers.Found(Path(n.position.file).resolve(), n.position)), n.text)
        for n in diagnosis.notes
        if n.position is not None
    ]
    severity = types.DiagnosticSeverity.Error if diagnosis.severity == "error" else types.DiagnosticSeverity.Warning
    return types.Diagnostic(
        range=_range(file, at),
        message="\n".join(filter(None, lines)),
        severity=severity,
        code=diagnosis.code,
        source="saoflow",
        related_information=related,
    )


def _at(params: Any) -> tuple[Path, Readable | None, Place | None]:
    path = _path(params.text_document.uri)
    readable = server.sheets.sheet(path)
    place = None
    if readable is not None:
        place = answers.place_at(readable, params.position.line + 1, _character(path, params.position) + 1)
    return path, readable, place


def _only_sheets(function: F) -> F:
    """An answer about nothing is None, not an error."""

    @wraps(function)
    def wrapped(ls: SheetServer, params: Any) -> Any:
        path, _, place = _at(params)
        return None if place is None else function(ls, params, path, place)

    return wrapped  # type: ignore[return-value]


@server.feature(types.TEXT_DOCUMENT_DID_OPEN)
def opened(ls: SheetServer, params: types.DidOpenTextDocumentParams) -> None:
    """A sheet is opened."""
    path = _path(params.text_document.uri)
    ls.sheets.open(path, params.text_document.text)
    ls.changed(path)


@server.feature(types.TEXT_DOCUMENT_DID_CHANGE)
def changed(ls: SheetServer, params: types.DidChangeTextDocumentParams) -> None:
    """Something was typed."""
    path = _path(params.text_document.uri)
    ls.sheets.open(path, ls.workspace.get_text_document(params.text_document.uri).source)
    ls.changed(path)


@server.feature(types.TEXT_DOCUMENT_DID_SAVE)
def saved(ls: SheetServer, params: types.DidSaveTextDocumentParams) -> None:
    """A sheet was saved: what uses it is checked again."""
    ls.changed(_path(params.text_document.uri))


@server.feature(types.TEXT_DOCUMENT_DID_CLOSE)
def closed(ls: SheetServer, params: types.DidCloseTextDocumentParams) -> None:
    """A sheet is closed: its diagnoses go."""
    path = _path(params.text_document.uri)
    ls.sheets.close(path)
    for file in ls.told.pop(path, {path}):
        ls._tell(file, ())


@server.feature(types.TEXT_DOCUMENT_HOVER)
@_only_sheets
def hovered(ls: SheetServer, params: types.HoverParams, path: Path, place: Place) -> types.Hover | None:
    """Meaning, shape, unit, cost."""
    text = answers.hover(ls.sheets, path, place)
    if not text:
        return None
    return types.Hover(types.MarkupContent(types.MarkupKind.Markdown, text), _range(path, place.position))


@server.feature(types.TEXT_DOCUMENT_DEFINITION)
@_only_sheets
def defined(ls: SheetServer, params: types.DefinitionParams, path: Path, place: Place) -> types.Location | None:
    """Where the name is defined, across files."""
    found = answers.definition(ls.sheets, path, place)
    return None if found is None else _location(found)


@server.feature(types.TEXT_DOCUMENT_REFERENCES)
@_only_sheets
def referred(ls: SheetServer, params: types.ReferenceParams, path: Path, place: Place) -> list[types.Location]:
    """Where the name is used, across the files of the folder."""
    return [_location(found) for found in answers.references(ls.sheets, path, place)]


@server.feature(types.TEXT_DOCUMENT_COMPLETION, types.CompletionOptions(trigger_characters=[".", "{", "[", ",", " "]))
def completed(ls: SheetServer, params: types.CompletionParams) -> types.CompletionList:
    """What may be written next."""
    path = _path(params.text_document.uri)
    choices = complete(ls.sheets, path, ls.sheets.lines(path), params.position.line, _character(path, params.position))
    return types.CompletionList(
        is_incomplete=False,
        items=[types.CompletionItem(label=c.text, kind=KINDS[c.kind], detail=c.detail or None) for c in choices],
    )


@server.feature(types.TEXT_DOCUMENT_RENAME)
@_only_sheets
def renamed(ls: SheetServer, params: types.RenameParams, path: Path, place: Place) -> types.WorkspaceEdit:
    """A new name for a wire, port or parameter, everywhere."""
    found = rename(ls.sheets, path, place, params.new_name)
    if isinstance(found, str):
        raise JsonRpcInvalidParams(found)
    changes: dict[str, list[types.TextEdit]] = {}
    for one in found:
        edit = types.TextEdit(_range(one.file, one.position), params.new_name)
        changes.setdefault(from_fs_path(str(one.file)) or "", []).append(edit)
    return types.WorkspaceEdit(changes=changes)


@server.feature(types.TEXT_DOCUMENT_DOCUMENT_SYMBOL)
def outlined(ls: SheetServer, params: types.DocumentSymbolParams) -> list[types.DocumentSymbol]:
    """Inputs, blocks and outputs."""
    path = _path(params.text_document.uri)
    readable = ls.sheets.sheet(path)
    if readable is None:
        return []
    sheet, kind = readable.sheet, types.SymbolKind
    named = [
        *((i.name, kind.Interface, "input") for i in sheet.inputs),
        *((b.name, kind.Variable, b.doc) for b in sheet.blocks),
        *((p.name, kind.Constant, p.doc) for p in sheet.parameters),
    ]
    return [
        types.DocumentSymbol(n.text, k, _range(path, n.position), _range(path, n.position), detail=d or None)
        for n, k, d in named
    ]
