"""A session of a real client with a real server process, over its standard input and output."""

from __future__ import annotations

import asyncio
import sys
from collections.abc import Awaitable, Callable, Coroutine
from pathlib import Path
from typing import Any, TypeVar

import pytest

import saoflow
from saoflow.diagrams.store import SHIPPED

pytest.importorskip("pygls", reason="the language server of saoflow[lsp] is not installed")

from lsprotocol import types
from pygls.exceptions import JsonRpcException
from pygls.lsp.client import LanguageClient

T = TypeVar("T")

LAG = """\
sheet: lag
doc: A first-order lag.
parameters:
  k: {value: 0.25, doc: how fast, source: chosen}
inputs: {u: {unit: kt, doc: what is smoothed}}
blocks:
  new: {mul: [u, k]}
  old: {mul: [before, 1 - k]}
  smooth: {add: [new, old]}
  before: {delay: smooth, initial: 240, unit: kt}
outputs: [smooth]
"""
TOP = """\
sheet: top
inputs: {vc: {shape: [2], unit: kt}}
blocks:
  first: {lag: ["vc[0]"]}
  second: {lag: {u: "vc[1]"}, k: 0.5}
  mean: {add: [first.smooth, second.smooth]}
outputs: [mean]
"""


class Session:
    """A client with one folder."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.client = LanguageClient("test", "1")
        self.diagnostics: dict[str, list[types.Diagnostic]] = {}
        self.news = asyncio.Event()
        self.versions: dict[str, int] = {}

        @self.client.feature(types.TEXT_DOCUMENT_PUBLISH_DIAGNOSTICS)
        def published(params: types.PublishDiagnosticsParams) -> None:
            self.diagnostics[params.uri.rsplit("/", 1)[1]] = list(params.diagnostics)
            self.news.set()

    def uri(self, name: str) -> str:
        return (self.folder / name).as_uri()

    def open(self, name: str) -> None:
        text = (self.folder / name).read_text()
        item = types.TextDocumentItem(self.uri(name), "yaml", 1, text)
        self.versions[name] = 1
        self.client.text_document_did_open(types.DidOpenTextDocumentParams(item))

    def type(self, name: str, text: str) -> None:
        self.versions[name] += 1
        document = types.VersionedTextDocumentIdentifier(version=self.versions[name], uri=self.uri(name))
        change = types.TextDocumentContentChangeWholeDocument(text)
        self.client.text_document_did_change(types.DidChangeTextDocumentParams(document, [change]))

    async def told(self, name: str, expected: Callable[[list[types.Diagnostic]], bool]) -> list[types.Diagnostic]:
        """Wait until the diagnoses of a file are as expected."""
        for _ in range(200):
            if name in self.diagnostics and expected(self.diagnostics[name]):
                return self.diagnostics[name]
            self.news.clear()
            try:
                await asyncio.wait_for(self.news.wait(), 0.3)
            except TimeoutError:
                continue
        raise AssertionError(self.diagnostics.get(name))

    def at(self, name: str, text: str, word: str, offset: int = 0) -> dict[str, Any]:
        """The place of a word: the first letter of its first use in a line that contains a text."""
        lines = text.splitlines()
        line = next(i for i, content in enumerate(lines) if word in content)
        place = types.Position(line, lines[line].index(word) + offset)
        return {"text_document": types.TextDocumentIdentifier(self.uri(name)), "position": place}

    async def hover(self, name: str, text: str, word: str, offset: int = 0) -> str:
        answer = await self.client.text_document_hover_async(types.HoverParams(**self.at(name, text, word, offset)))
        assert answer is not None and isinstance(answer.contents, types.MarkupContent)
        return answer.contents.value

    async def choices(self, name: str, text: str, word: str, offset: int = 0) -> set[str]:
        answer = await self.client.text_document_completion_async(
            types.CompletionParams(**self.at(name, text, word, offset))
        )
        assert isinstance(answer, types.CompletionList)
        return {item.label for item in answer.items}


def session(
    folder: Path, talk: Callable[[Session], Awaitable[T]], encodings: list[types.PositionEncodingKind | str] | None = None
) -> T:
    general = types.GeneralClientCapabilities(position_encodings=encodings)
    async def whole() -> T:
        here = Session(folder)
        await here.client.start_io(sys.executable, "-m", "saoflow", "lsp")
        try:
            await here.client.initialize_async(
                types.InitializeParams(types.ClientCapabilities(general=general), root_uri=folder.as_uri(), process_id=None)
            )
            here.client.initialized(types.InitializedParams())
            return await talk(here)
        finally:
            await here.client.shutdown_async(None)
            here.client.exit(None)
            await asyncio.wait_for(here.client.stop(), 10)

    run: Coroutine[Any, Any, T] = whole()
    return asyncio.run(asyncio.wait_for(run, 120))


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "lag.yaml").write_text(LAG)
    (tmp_path / "top.yaml").write_text(TOP)
    return tmp_path


def test_a_mistake_is_told_as_it_is_typed_and_goes_when_it_is_mended(folder: Path) -> None:
    async def talk(here: Session) -> None:
        here.open("top.yaml")
        await here.told("top.yaml", lambda found: found == [])
        here.type("top.yaml", TOP.replace("first.smooth, second", "first.smoth, secnd"))
        found = await here.told("top.yaml", lambda found: len(found) == 2)
        assert {d.code for d in found} == {"E202", "E203"}
        wrong = next(d for d in found if "secnd" in d.message)
        assert (wrong.range.start.line, wrong.range.end.character - wrong.range.start.character) == (5, 5)
        assert "did you mean `second`?" in wrong.message
        # A buffer that is no YAML at all, and two mistakes at once
        here.type("top.yaml", TOP.replace("outputs: [mean]", "outputs: [mean"))
        await here.told("top.yaml", lambda found: [d.code for d in found] == ["E102"])
        here.type("top.yaml", TOP)
        await here.told("top.yaml", lambda found: found == [])

    session(folder, talk)


def test_a_change_in_a_sub_sheet_is_told_where_it_is_used(folder: Path) -> None:
    async def talk(here: Session) -> None:
        here.open("top.yaml")
        here.open("lag.yaml")
        await here.told("top.yaml", lambda found: found == [])
        here.type("lag.yaml", LAG.replace("outputs: [smooth]", "outputs: {y: smooth}"))  # not saved
        found = await here.told("top.yaml", lambda found: len(found) == 2)
        assert {d.code for d in found} == {"E203"}
        here.type("lag.yaml", LAG)
        await here.told("top.yaml", lambda found: found == [])

    session(folder, talk)


def test_hover_definition_references_completion(folder: Path) -> None:
    async def talk(here: Session) -> None:
        here.open("top.yaml")
        here.open("lag.yaml")
        await here.told("top.yaml", lambda found: found == [])
        assert "real [2] kt" in await here.hover("top.yaml", TOP, "vc:")
        shown = await here.hover("top.yaml", TOP, "mean: {add")
        assert "real scalar" in shown and "1 operation a frame" in shown and "sum of the operands" in shown
        assert "A first-order lag." in await here.hover("top.yaml", TOP, "lag: [")
        assert "how fast" in await here.hover("top.yaml", TOP, "k: 0.5")
        assert "what is smoothed" in await here.hover("top.yaml", TOP, "u: \"vc")
        assert "product of the operands" in await here.hover("lag.yaml", LAG, "mul: [u")
        found = await here.client.text_document_definition_async(
            types.DefinitionParams(**here.at("top.yaml", TOP, "second.smooth", 8))
        )
        assert isinstance(found, types.Location) and found.uri == here.uri("lag.yaml") and found.range.start.line == 10
        found = await here.client.text_document_definition_async(
            types.DefinitionParams(**here.at("top.yaml", TOP, "first.smooth"))
        )
        assert isinstance(found, types.Location) and found.uri == here.uri("top.yaml") and found.range.start.line == 3
        uses = await here.client.text_document_references_async(
            types.ReferenceParams(types.ReferenceContext(True), **here.at("lag.yaml", LAG, "u: {unit"))
        )
        assert uses is not None
        assert {(u.uri, u.range.start.line) for u in uses} == {
            (here.uri("lag.yaml"), 4),
            (here.uri("lag.yaml"), 6),
            (here.uri("top.yaml"), 4),
        }
        half = TOP.replace("mean: {add: [first.smooth, second.smooth]}", "mean: {add: [first.")
        here.type("top.yaml", half)
        assert await here.choices("top.yaml", half, "first.", 6) == {"smooth", "T"}
        half = TOP.replace("{lag: {u: \"vc[1]\"}, k: 0.5}", "{la")
        here.type("top.yaml", half)
        assert {"lag", "add", "lookup", "fold"} <= await here.choices("top.yaml", half, "{la", 3)
        half = TOP.replace("k: 0.5}", "}")
        here.type("top.yaml", half)
        assert {"u", "k", "every"} <= await here.choices("top.yaml", half, ", }", 2)
        assert {"kt", "m", "s"} <= await here.choices("top.yaml", half, "unit: kt", 6)
        assert {"vc", "first", "second", "mean"} <= await here.choices("top.yaml", half, "[first.", 1)
        assert {"blocks", "outputs"} <= await here.choices("top.yaml", half, "outputs", 3)

    session(folder, talk)


def test_renaming_a_wire_changes_every_place_and_no_meaning(folder: Path) -> None:
    async def talk(here: Session) -> types.WorkspaceEdit:
        here.open("lag.yaml")
        await here.told("lag.yaml", lambda found: found == [])
        for new in ("old", "two words", "fold"):
            with pytest.raises(JsonRpcException):
                await here.client.text_document_rename_async(
                    types.RenameParams(new_name=new, **here.at("lag.yaml", LAG, "smooth: {add"))
                )
        edit = await here.client.text_document_rename_async(
            types.RenameParams(new_name="filtered", **here.at("lag.yaml", LAG, "smooth: {add"))
        )
        assert edit is not None
        return edit

    edit = session(folder, talk)
    expected = saoflow.load(str(folder / "top.yaml")).simulator().run({"vc": [[250.0, 260.0]] * 5})["mean"]
    assert edit.changes is not None and len(edit.changes) == 2
    for uri, edits in edit.changes.items():
        path = Path(uri.removeprefix("file://"))
        lines = path.read_text().splitlines(keepends=True)
        for one in sorted(edits, key=lambda e: (-e.range.start.line, -e.range.start.character)):
            at = one.range.start.line
            lines[at] = lines[at][: one.range.start.character] + one.new_text + lines[at][one.range.end.character :]
        path.write_text("".join(lines))
    assert "smooth:" not in (folder / "lag.yaml").read_text() and "first.filtered" in (folder / "top.yaml").read_text()
    found = saoflow.load(str(folder / "top.yaml")).simulator().run({"vc": [[250.0, 260.0]] * 5})["mean"]
    assert (found == expected).all()


def test_odd_requests_do_not_end_it(folder: Path) -> None:
    (folder / "empty.yaml").write_text("")
    (folder / "binary.yaml").write_bytes(b"\0\1\2")

    async def talk(here: Session) -> None:
        here.open("empty.yaml")
        await here.told("empty.yaml", lambda found: [d.code for d in found] == ["E103"])
        nowhere = types.TextDocumentIdentifier(here.uri("none.yaml"))
        far = types.Position(9999, 9999)
        assert await here.client.text_document_hover_async(types.HoverParams(nowhere, far)) is None
        assert await here.client.text_document_definition_async(types.DefinitionParams(nowhere, far)) is None
        document = types.TextDocumentIdentifier(here.uri("binary.yaml"))
        assert await here.client.text_document_hover_async(types.HoverParams(document, types.Position(0, 0))) is None
        here.open("top.yaml")
        await here.told("top.yaml", lambda found: found == [])

    session(folder, talk)


def test_a_sheet_that_needs_its_user_is_checked_through_it() -> None:
    folder = SHIPPED / "cmhe_fte"
    text = (folder / "stage.yaml").read_text()

    async def talk(here: Session) -> None:
        here.open("stage.yaml")
        await here.told("stage.yaml", lambda found: found == [])
        word = next(line.split(":")[0].strip() for line in text.split("blocks:")[1].splitlines() if ":" in line)
        assert "real [" in await here.hover("stage.yaml", text, f"  {word}:", 2)
        here.type("stage.yaml", text.replace("[P_hat, x_hat", "[P_hut, x_hat", 1))
        await here.told("stage.yaml", lambda found: [d.code for d in found] == ["E202"])

    session(folder, talk)


@pytest.mark.parametrize(("encoding", "size"), [("utf-8", 1), ("utf-16", 2), ("utf-32", 4)])
def test_columns_are_counted_as_the_editor_counts_them(folder: Path, encoding: str, size: int) -> None:
    line = "blocks: {gain: {mul: [u, 2], doc: \"😀 é\"}, y: {add: [gain, gian]}}"
    wide = f"sheet: wide\ninputs: [u]\n{line}\noutputs: [y]\n"
    (folder / "wide.yaml").write_text(wide, encoding="utf-8")

    def units(text: str) -> int:
        return len(text.encode(encoding if size == 1 else f"{encoding}-le")) // size

    async def talk(here: Session) -> None:
        here.open("wide.yaml")
        (found,) = await here.told("wide.yaml", lambda found: len(found) == 1)
        begins = units(line[: line.index("gian")])
        assert (found.range.start.character, found.range.end.character) == (begins, begins + 4)
        place = types.Position(2, units(line[: line.rindex("gain")]) + 1)
        document = types.TextDocumentIdentifier(here.uri("wide.yaml"))
        answer = await here.client.text_document_hover_async(types.HoverParams(document, place))
        assert answer is not None and answer.range is not None
        assert answer.range.start.character == place.character - 1
        change = await here.client.text_document_rename_async(types.RenameParams(document, place, "twice"))
        assert change is not None and change.changes is not None
        (edits,) = change.changes.values()
        found_at = {edit.range.start.character for edit in edits}
        assert found_at == {units(line[: line.index("gain")]), units(line[: line.rindex("gain")])}

    session(folder, talk, [encoding])
