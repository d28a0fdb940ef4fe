"""The folder of a campaign: a file for each chunk as it comes, and in the end one table.

    campaign.json      what runs here: name and digests
    parts/00012.parquet
    results.parquet    all runs, in their order, once all parts are there

Every file is written whole or not at all, so a campaign that is killed at any point goes on where it was; parts hold
the same bytes whoever wrote them when, so the table has the same bytes, too.
"""

from __future__ import annotations

import json
import os
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import IO, Any

from saoflow.diagnosis import DiagnosisError, refusal
from saoflow.recordings.parquet_reader import need_pyarrow
from saoflow.whole_file import write_whole
from verification.campaigns.cases import Chunk
from verification.campaigns.row import COLUMNS, Row

RESULTS = "results.parquet"
_MANIFEST = "campaign.json"
_PARTS = "parts"
_LOCK = ".lock"
_GROUP = 1024
"""Rows that are in memory at a time when the table is put together."""
_LEFT_BEHIND = re.compile(r"\..*\.\d+\.part")
_WHAT = {
    "campaign": "the campaign's file says something else",
    "code": "saoflow, its sheets or its recordings are of another version",
    "sheets": "a sheet has changed",
    "flights": "a recording or the recorder has changed",
}


class Store:
    """A campaign's folder, held for this process alone. Use as a context manager.

    Raises DiagnosisError E601 (cannot be written), E605 (no pyarrow), E802 (another campaign), E804 (in use).
    """

    def __init__(self, folder: str | os.PathLike[str], name: str, fingerprint: Mapping[str, str]) -> None:
        self.folder = Path(folder)
        self._arrow = need_pyarrow(RESULTS)
        self._lock: IO[bytes] | None = None
        try:
            if self.folder.exists() and not (self.folder / _MANIFEST).is_file():
                self._refuse_strangers()
            (self.folder / _PARTS).mkdir(parents=True, exist_ok=True)
            self._hold()
            self._clean()
            self._agree(name, dict(fingerprint))
        except OSError as error:
            raise _unwritable(self.folder, error) from None

    def __enter__(self) -> Store:
        return self

    def __exit__(self, *_: object) -> None:
        if self._lock is not None:
            self._lock.close()

    def _hold(self) -> None:
        """One process a folder; the operating system lets go of it however that one ends."""
        self._lock = open(self.folder / _LOCK, "wb")  # noqa: SIM115 - open as long as the store
        try:
            import fcntl
        except ImportError:  # not there on Windows
            return
        try:
            fcntl.flock(self._lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            self._lock.close()
            raise refusal(
                "E804",
                f"{self.folder}: a campaign is running in this folder",
                cause="another process holds it",
                remedy="wait for it, or name another folder with -o",
            ) from None

    def _clean(self) -> None:
        """Remove what a killed process left half-written."""
        for folder in (self.folder, self.folder / _PARTS):
            for path in folder.iterdir():
                if _LEFT_BEHIND.fullmatch(path.name):
                    path.unlink()

    def _agree(self, name: str, fingerprint: dict[str, str]) -> None:
        path = self.folder / _MANIFEST
        ours = {"campaign": name, "digests": fingerprint}
        if not path.exists():
            write_whole(path, (json.dumps(ours, indent=1, sort_keys=True) + "\n").encode())
            return
        try:
            theirs = json.loads(path.read_bytes())
            their_name, digests = str(theirs["campaign"]), dict(theirs["digests"])
        except (ValueError, KeyError, TypeError):
            self._refuse(f"its {_MANIFEST} cannot be read", "")
        changed = [why for key, why in _WHAT.items() if digests.get(key) != fingerprint.get(key)]
        if changed:
            self._refuse("; ".join(changed), their_name)

    def _refuse_strangers(self) -> None:
        """A folder with anything in it that is no campaign's. What a process killed at its very start left is not."""
        begun = {_PARTS, _LOCK}
        strangers = {p.name for p in self.folder.iterdir() if not _LEFT_BEHIND.fullmatch(p.name)} - begun
        parts = self.folder / _PARTS
        if strangers or (parts.is_dir() and any(parts.iterdir())):
            self._refuse("there are files in it, and none of them says that a campaign began here", "")

    def _refuse(self, cause: str, name: str) -> None:
        if self._lock is not None:
            self._lock.close()
        what = f"the campaign `{name}` as it was when it began" if name else "something else"
        raise refusal(
            "E802",
            f"{self.folder}: the folder holds {what}",
            cause=cause,
            remedy="name another folder with -o, or remove this one",
        )

    # -- parts

    def _part(self, chunk: Chunk) -> Path:
        return self.folder / _PARTS / f"{chunk.number:05d}.parquet"

    def has(self, chunk: Chunk) -> bool:
        """Whether the chunk's rows are there, all of them."""
        try:
            with self._arrow.parquet.ParquetFile(self._part(chunk)) as file:
                return bool(file.metadata.num_rows == len(chunk))
        except (OSError, self._arrow.ArrowException):
            return False

    def keep(self, chunk: Chunk, rows: Sequence[Row]) -> None:
        """Write the rows of a chunk. Raises DiagnosisError E601."""
        sink = self._arrow.BufferOutputStream()
        self._arrow.parquet.write_table(self._table(rows), sink, compression="zstd")
        try:
            write_whole(self._part(chunk), sink.getvalue().to_pybytes())
        except OSError as error:
            raise _unwritable(self._part(chunk), error) from None

    def _schema(self) -> Any:
        arrow = self._arrow
        types = {"int": arrow.int64(), "float": arrow.float64(), "bool": arrow.bool_(), "str": arrow.string()}
        return arrow.schema([arrow.field(name, types[kind], nullable=False) for name, kind in COLUMNS])

    def _table(self, rows: Sequence[Row]) -> Any:
        columns = {name: [getattr(row, name) for row in rows] for name, _ in COLUMNS}
        return self._arrow.table(columns, schema=self._schema())

    # -- the whole

    def finish(self, chunks: Iterable[Chunk]) -> Path:
        """Put all parts together, in order of the runs. Raises DiagnosisError E601."""
        parquet = self._arrow.parquet
        temporary = self.folder / f".{RESULTS}.{os.getpid()}.part"
        try:
            try:
                with parquet.ParquetWriter(temporary, self._schema(), compression="zstd") as writer:
                    for group in self._groups(chunks):
                        writer.write_table(group)
                os.replace(temporary, self.folder / RESULTS)
            finally:
                temporary.unlink(missing_ok=True)
        except OSError as error:
            raise _unwritable(self.folder / RESULTS, error) from None
        return self.folder / RESULTS

    def _groups(self, chunks: Iterable[Chunk]) -> Iterator[Any]:
        waiting: list[Any] = []
        for chunk in chunks:
            with self._arrow.parquet.ParquetFile(self._part(chunk)) as file:
                waiting.append(file.read(use_threads=False))  # threads would keep memory of their own
            if sum(len(table) for table in waiting) >= _GROUP:
                yield self._arrow.concat_tables(waiting).combine_chunks()
                waiting = []
        if waiting:
            yield self._arrow.concat_tables(waiting).combine_chunks()


def rows_of(path: str | os.PathLike[str]) -> Iterator[Row]:
    """The rows of a results file, a few at a time. Raises DiagnosisError E501, E605."""
    arrow = need_pyarrow(os.fspath(path))
    try:
        with arrow.parquet.ParquetFile(path) as file:
            for group in range(file.num_row_groups):
                for record in file.read_row_group(group, use_threads=False).to_pylist():
                    yield Row(**record)
    except (OSError, TypeError, arrow.ArrowException) as error:
        raise refusal(
            "E501",
            f"{path}: these are no results of a campaign",
            cause=str(error).splitlines()[0],
            remedy="run the campaign again",
        ) from None


def _unwritable(path: Path, error: OSError) -> DiagnosisError:
    return refusal(
        "E601",
        f"{path} cannot be written",
        cause=error.strerror or str(error),
        remedy="name a folder that you may write to, on a disk with room",
    )
