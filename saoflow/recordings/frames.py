"""The inputs of a sheet from a recording, as a whole or in parts; its outputs as columns."""

from __future__ import annotations

from collections.abc import Generator, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from saoflow.diagnosis import Diagnosis, DiagnosisError, Position, did_you_mean
from saoflow.recordings.parts import column_parts, read_columns
from saoflow.recordings.table import Part, Table, extension
from saoflow.wires import WireType

TIME = "t"
"""The column that is copied from the recording of the inputs to that of the outputs."""


@dataclass(frozen=True, slots=True, eq=False)
class Frames:
    """A recording as a simulator takes it: one array (frames, *shape) per port, and the time column if there is one."""

    inputs: dict[str, np.ndarray]
    t: np.ndarray | None
    count: int
    missing: dict[str, int]
    """How many samples are missing, by column; only columns where some are."""
    warnings: tuple[Diagnosis, ...]


def column_names(name: str, shape: tuple[int, ...]) -> list[str]:
    """The columns of one port, in row-major order, numbered from 1."""
    return [name + "".join(f"_{i + 1}" for i in index) for index in np.ndindex(*shape)]


def read_table(path: str | Path, names: Sequence[str] | None = None) -> Table:
    """The numbers of a recording: the named columns, or all of them. Raises DiagnosisError E501 to E506, E103, E605."""
    return read_columns(str(path), lambda found: list(found) if names is None else _all_there(path, names, found))


def _all_there(path: str | Path, names: Sequence[str], found: Sequence[str]) -> list[str] | list[Diagnosis]:
    spare = [name for name in found if name not in set(names)]
    missing = [name for name in names if name not in set(found)]
    return [_no_column(str(path), name, "it is asked for", found, spare) for name in missing] or list(names)


def read_frames(path: str | Path, ports: Mapping[str, WireType]) -> Frames:
    """The inputs of a sheet from a recording, as a whole. ``ports``: its inputs by name.

    Raises DiagnosisError with all that is found: E501 (unreadable), E103, E504 (empty), E502 (a column is missing),
    E503 (no number), E505 (rows of different length), E506 (a column twice), E110 (too large), E605 (no pyarrow).
    """
    wanted = _Wanted(str(path), ports)
    frames = wanted.frames(read_columns(str(path), wanted.choose, wanted.flags))
    return replace(frames, warnings=_warnings(str(path), frames.count, frames.missing, wanted.flags))


class FrameReader:
    """The inputs of a sheet from a recording of any length, in parts: iterate once, and close (or use ``with``).

    Raises DiagnosisError as :func:`read_frames` does, but for E110: at once for what is wrong with the header or the
    first part, else in the place of the part that has the first mistake.
    """

    def __init__(self, path: str | Path, ports: Mapping[str, WireType]) -> None:
        self.path = str(path)
        self._wanted = _Wanted(self.path, ports)
        self._parts: Generator[Part, None, None] = column_parts(self.path, self._wanted.choose, self._wanted.flags)
        self._first: Part | None = next(self._parts)
        self.count = 0
        """Frames that were read so far."""
        self.missing: dict[str, int] = {}
        """How many of their samples are missing, by column."""
        self.share = 0.0
        """The share of the file that was read, 0 to 1."""

    def __enter__(self) -> FrameReader:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Close the file."""
        self._parts.close()

    def __iter__(self) -> Iterator[Frames]:
        part = self._first
        self._first = None
        while part is not None:
            frames = self._wanted.frames(part.table)
            self.count += frames.count
            for column, number in frames.missing.items():
                self.missing[column] = self.missing.get(column, 0) + number
            self.share = part.share
            yield frames
            del frames
            part = next(self._parts, None)
        self.share = 1.0

    @property
    def warnings(self) -> tuple[Diagnosis, ...]:
        """What is worth a word about the frames that were read: W501."""
        return _warnings(self.path, self.count, self.missing, self._wanted.flags)


class _Wanted:
    """The columns that the inputs of a sheet need."""

    def __init__(self, path: str, ports: Mapping[str, WireType]) -> None:
        self.path = path
        self.ports = ports
        self.columns = {name: column_names(name, wire.shape) for name, wire in ports.items()}
        self.needed = [column for port in self.columns.values() for column in port]
        self.flags = frozenset(
            column for name, wire in ports.items() if wire.boolean for column in self.columns[name]
        )

    def choose(self, found: Sequence[str]) -> list[str] | list[Diagnosis]:
        """The columns to read of those that are there, or what is missing."""
        clashes = _shared(self.columns)
        if clashes:
            return clashes
        there, wanted = set(found), set(self.needed)
        spare = [name for name in found if name not in wanted]
        problems = []
        for name, port in self.columns.items():
            shape = self.ports[name].shape
            cause = f"input `{name}` is {_shown(shape)}{f': columns {_few(port)}' if shape else ''}"
            absent = [column for column in port if column not in there]
            if len(absent) == len(port) > 1:
                problems.append(_no_column(self.path, absent[0], cause, found, spare, absent))
            else:
                problems += [_no_column(self.path, column, cause, found, spare) for column in absent]
        return problems or [*self.needed, *([TIME] if TIME in there and TIME not in wanted else [])]

    def frames(self, table: Table) -> Frames:
        """Rows as a simulator takes them; no warnings yet."""
        inputs, missing = {}, {}
        for name, port in self.columns.items():
            wire = self.ports[name]
            parts = [table[column] for column in port]
            stacked = np.stack(parts, axis=-1) if wire.shape else parts[0]
            finite = np.isfinite(stacked)
            if not finite.all():
                counts = np.count_nonzero(~finite, axis=0)
                missing.update(
                    {column: int(n) for column, n in zip(port, np.atleast_1d(counts), strict=True) if n},
                )
                if wire.boolean:
                    stacked = np.where(finite, stacked, 0.0)
            inputs[name] = stacked.reshape(len(table), *wire.shape)
        t = table[TIME] if TIME in table.names and TIME not in self.needed else None
        return Frames(inputs, t, len(table), missing, ())


def output_columns(
    arrays: Mapping[str, np.ndarray], ports: Mapping[str, WireType], t: np.ndarray | None = None
) -> dict[str, np.ndarray]:
    """Columns of outputs (frames, *shape) for :func:`write_table`: ``t`` first, booleans as 0 and 1.

    Raises DiagnosisError E506 if two ports share a column.
    """
    columns = {name: column_names(name, wire.shape) for name, wire in ports.items()}
    clashes = _shared(columns)
    if clashes:
        raise DiagnosisError(clashes)
    taken = {column for port in columns.values() for column in port}
    table: dict[str, np.ndarray] = {} if t is None or TIME in taken else {TIME: t}
    for name, wire in ports.items():
        flat = np.asarray(arrays[name]).reshape(-1, wire.size)
        for i, column in enumerate(columns[name]):
            table[column] = flat[:, i].astype(np.int8) if wire.boolean else flat[:, i]
    return table


def _shared(columns: Mapping[str, Sequence[str]]) -> list[Diagnosis]:
    """Ports whose elements have the same column: ``P`` of size 2 beside a scalar ``P_1``."""
    owner: dict[str, str] = {}
    found = []
    for name, port in columns.items():
        for column in port:
            other = owner.setdefault(column, name)
            if other != name:
                found.append(
                    Diagnosis(
                        "E506",
                        f"`{other}` and `{name}` share the column `{column}`",
                        cause="elements of a vector are columns with a number behind the name",
                        remedy=f"rename the port `{name}` in the sheet",
                    )
                )
    return found


def _no_column(
    path: str,
    column: str,
    cause: str,
    found: Sequence[str],
    spare: Sequence[str],
    absent: Sequence[str] = (),
) -> Diagnosis:
    """A column that is missing, or (``absent``) all those of a port."""
    header = ",".join(found)
    # A column of an element is like one with the same number only: alpha_1 like alpha1, not like alpha_2.
    alike = [name for name in spare if _digits(name) == _digits(column)]
    near = did_you_mean(column, alike)
    remedy = f"add {'them' if absent else 'it'}; the recording has: {_few(found)}"
    if near:
        remedy = f"{near} then rename it in the recording to `{column}`"
    text = extension(path) != ".parquet"
    if text and len(found) == 1 and any(mark in header for mark in ";\t|"):
        cause, remedy = "the names in the first line are not separated by commas", "save the file as CSV with commas"
    elif text and found and all(_numeric(name) for name in found):
        cause = "the first line holds numbers, not the names of the columns"
        remedy = "put a header line first: the names, separated by commas"
    names = ", ".join(f"`{name}`" for name in absent[:8]) + (", ..." if len(absent) > 8 else "")
    message = f"there are no columns {names}" if absent else f"there is no column `{column}`"
    place = next((i for i, name in enumerate(found) if near == f"did you mean `{name}`?"), None)
    start = 1 if place is None else len(",".join([*found[:place], ""])) + 1
    length = 1 if place is None else len(found[place])
    shown = header if text and place is not None else None
    return Diagnosis("E502", message, Position(path, 1, start, length), cause, remedy, source_line=shown)


def _digits(name: str) -> str:
    return "".join(filter(str.isdigit, name))


def _numeric(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


def _shown(shape: tuple[int, ...]) -> str:
    if not shape:
        return "a scalar: one column of its name"
    return f"a vector of {shape[0]}" if len(shape) == 1 else "an array of " + " x ".join(map(str, shape))


def _few(names: Sequence[str], most: int = 8) -> str:
    shown = ", ".join(name or "(no name)" for name in names[:most])
    return f"{shown}, ... ({len(names)} in all)" if len(names) > most else shown


def _warnings(path: str, rows: int, missing: Mapping[str, int], flags: frozenset[str]) -> tuple[Diagnosis, ...]:
    if not missing:
        return ()
    total = sum(missing.values())
    worst = sorted(missing.items(), key=lambda item: -item[1])
    shown = ", ".join(f"{column} {n}" for column, n in worst[:8])
    more = f", and {len(worst) - 8} further columns" if len(worst) > 8 else ""
    taken = "; a missing boolean is taken as 0" if flags & set(missing) else ""
    return (
        Diagnosis(
            "W501",
            f"{total} missing {'sample' if total == 1 else 'samples'} in {rows} {'row' if rows == 1 else 'rows'}",
            Position(path, 1, 1),
            f"not a finite number, or an empty cell: {shown}{more}",
            f"none needed if the sheet is made for it: the samples go in as they are, an empty cell as NaN{taken}",
        ),
    )
