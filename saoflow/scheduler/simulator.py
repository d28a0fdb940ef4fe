"""Running frames: recordings and single frames, one flight or a batch, with state that can be taken out and put back."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from saoflow.diagnosis import Diagnosis, DiagnosisError, did_you_mean
from saoflow.scheduler.program import FrameProgram, ProgramPort

if TYPE_CHECKING:
    from saoflow.scheduler.interpreter import Interpreter

Arrays = dict[str, np.ndarray]
CHUNK = 4096
"""Flights of a batch that run together, so that the values of a frame stay in the cache."""


@dataclass(frozen=True, slots=True, eq=False)
class State:
    """Everything remembered between frames: (slots,) for one flight, (slots, flights) for a batch, as binary64."""

    slots: np.ndarray
    frame: int


class Simulator:
    """Frames of one program. ``run`` and ``step`` go on from the present state; ``reset`` starts again."""

    def __init__(self, program: FrameProgram, exact: bool = False) -> None:
        self.program = program
        self.exact = exact
        self._scalar: Interpreter | None = None
        self._array: Interpreter | None = None
        self._state: tuple[Any, ...] | None = None
        self._flights: int | None = None
        self._frame = 0

    # -- state

    def reset(self) -> None:
        """Back to the initial values."""
        self._state, self._flights, self._frame = None, None, 0

    def state(self) -> State:
        """A copy of the present state."""
        if self._state is None:
            return State(np.array([float(slot.initial) for slot in self.program.states]), self._frame)
        if self._flights is None:
            return State(np.array([float(np.ravel(v)[0]) for v in self._state]), self._frame)
        slots = np.empty((len(self._state), self._flights))
        for i, value in enumerate(self._state):
            slots[i] = value
        return State(slots, self._frame)

    def restore(self, state: State) -> None:
        """Go on from a state taken with :meth:`state`. Raises DiagnosisError E508 if it is another sheet's."""
        if state.slots.shape[:1] != (len(self.program.states),) or state.slots.ndim > 2:
            raise DiagnosisError(
                [
                    Diagnosis(
                        "E508",
                        "the state does not belong to this sheet",
                        cause=f"the sheet remembers {len(self.program.states)} values, the state holds "
                        f"{list(state.slots.shape)}",
                        remedy="restore a state that the same sheet with the same parameters gave",
                    )
                ]
            )
        self._flights = None if state.slots.ndim == 1 else state.slots.shape[1]
        booleans = [isinstance(slot.initial, bool) for slot in self.program.states]
        if self._flights is None and self.program.real == 64:
            self._state = tuple(bool(v) if b else float(v) for v, b in zip(state.slots, booleans, strict=True))
        else:
            real = np.float64 if self.program.real == 64 else np.float32
            rows = np.atleast_2d(state.slots.T).T if state.slots.ndim == 1 else state.slots
            self._state = tuple(
                row.astype(bool) if b else row.astype(real) for row, b in zip(rows, booleans, strict=True)
            )
        self._frame = state.frame

    # -- frames

    def step(self, inputs: Mapping[str, Any]) -> Arrays:
        """One frame. An input is an array of the port's shape (for a batch with a leading flight axis)."""
        shaped = {name: np.asarray(value) for name, value in inputs.items()}
        frames: dict[str, np.ndarray] = {}
        for port in self.program.inputs:
            if port.name in shaped:
                value = shaped[port.name]
                axis = value.ndim - len(port.type.shape)
                frames[port.name] = np.expand_dims(value, max(axis, 0))
        frames.update({name: value for name, value in shaped.items() if name not in frames})
        out = self.run(frames)
        return {
            port.name: np.take(out[port.name], 0, axis=out[port.name].ndim - 1 - len(port.type.shape))
            for port in (*self.program.outputs, *self.program.probes)
        }

    def run(self, inputs: Mapping[str, Any], progress: Callable[[int], None] | None = None) -> Arrays:
        """Frames in a row: inputs (frames, *shape), or (flights, frames, *shape) for a batch; outputs likewise.

        ``progress`` is called now and then with the number of frames done. Raises DiagnosisError E502, E507.
        """
        arrays, flights, frames = self._checked(inputs)
        if flights is None and self.program.real == 64:
            return self._run_one(arrays, frames, progress)
        return self._run_batch(arrays, flights, frames, progress)

    def run_chunks(self, chunks: Iterable[Mapping[str, Any]]) -> Iterator[Arrays]:
        """Frames in a row that need not be in memory together: the outputs of each chunk of inputs, as it is asked for.

        Chunks are what :meth:`run` takes, of one flight or of one batch, and of any number of frames; the outputs
        are to the bit those of one run of all frames. Raises DiagnosisError E502, E507, E508.
        """
        for chunk in chunks:
            yield self.run(chunk)

    def _run_one(self, arrays: Arrays, frames: int, progress: Callable[[int], None] | None) -> Arrays:
        if self._scalar is None:
            from saoflow.scheduler.interpreter import scalar_interpreter

            self._scalar = scalar_interpreter(self.program, self.exact)
        state = self._state_for(None, self._scalar)
        (frame,) = self._scalar.frames
        columns: list[list[Any]] = []
        for port in self.program.inputs:
            flat = arrays[port.name].reshape(frames, port.type.size)
            flat = flat.astype(bool) if port.type.boolean else flat.astype(np.float64)
            columns += [flat[:, i].tolist() for i in range(port.type.size)]
        rows = zip(*columns, strict=True) if columns else iter([()] * frames)
        results: list[tuple[Any, ...]] = []
        for k, row in enumerate(rows):
            values, state = frame(row, state)
            results.append(values)
            if progress is not None and not k % 64:
                progress(k)
        self._state, self._flights, self._frame = state, None, self._frame + frames
        return self._named(np.array(results, dtype=np.float64).reshape(frames, -1), (frames,))

    def _run_batch(
        self, arrays: Arrays, flights: int | None, frames: int, progress: Callable[[int], None] | None
    ) -> Arrays:
        if self._array is None:
            from saoflow.scheduler.interpreter import array_interpreter

            self._array = array_interpreter(self.program, self.exact)
        count = 1 if flights is None else flights
        state = self._state_for(count, self._array)
        real = np.float64 if self.program.real == 64 else np.float32
        width = sum(port.type.size for port in (*self.program.outputs, *self.program.probes))
        out = np.empty((count, frames, width), dtype=real)
        chunks: list[tuple[Any, ...]] = []
        done = 0
        with np.errstate(all="ignore"):
            for start in range(0, count, CHUNK):
                stop = min(start + CHUNK, count)
                part = tuple(_part(slot, start, stop, count) for slot in state)
                columns = self._batch_columns(arrays, start, stop, count, frames, real)
                (frame,) = self._array.frames
                for k in range(frames):
                    values, part = frame([column[k] for column in columns], part)
                    for j, value in enumerate(values):
                        out[start:stop, k, j] = value
                    done += 1
                    if progress is not None and not k % 16:
                        progress(done * frames // (frames * -(-count // CHUNK)))
                chunks.append(tuple(np.broadcast_to(slot, (stop - start,)) for slot in part))
        self._state = tuple(np.concatenate(slots) for slots in zip(*chunks, strict=True)) if chunks else state
        self._flights, self._frame = flights, self._frame + frames
        if flights is None:
            return self._named(out[0], (frames,))
        return self._named(out, (flights, frames))

    def _batch_columns(
        self, arrays: Arrays, start: int, stop: int, count: int, frames: int, real: type[np.floating[Any]]
    ) -> list[np.ndarray]:
        columns: list[np.ndarray] = []
        for port in self.program.inputs:
            flat = arrays[port.name].reshape(count, frames, port.type.size)[start:stop]
            flat = flat.astype(bool) if port.type.boolean else flat.astype(real)
            columns += [np.ascontiguousarray(flat[:, :, i].T) for i in range(port.type.size)]
        return columns

    def _state_for(self, flights: int | None, interpreter: Interpreter) -> tuple[Any, ...]:
        if self._state is None:
            return interpreter.initial_state
        self._check_flights(flights)
        return self._state

    def _check_flights(self, flights: int | None) -> None:
        """Raises DiagnosisError E508 if the frames before were of another number of flights."""
        if flights is not None and self._flights is not None and flights != self._flights:
            raise DiagnosisError(
                [
                    Diagnosis(
                        "E508",
                        "the batch has another number of flights than the state",
                        cause=f"the state holds {self._flights} flights, the inputs {flights}",
                        remedy="call reset() before another batch",
                    )
                ]
            )
        if (flights is None) != (self._flights is None) and self.program.real == 64:
            raise one_or_batch()

    def _named(self, flat: np.ndarray, leading: tuple[int, ...]) -> Arrays:
        named: Arrays = {}
        start = 0
        for port in (*self.program.outputs, *self.program.probes):
            part = flat[..., start : start + port.type.size]
            named[port.name] = part.reshape(*leading, *port.type.shape)
            start += port.type.size
        return named

    # -- checking

    def _checked(self, inputs: Mapping[str, Any]) -> tuple[Arrays, int | None, int]:
        problems: list[Diagnosis] = []
        arrays: Arrays = {}
        lead: tuple[int, ...] | None = None
        for port in self.program.inputs:
            if port.name not in inputs:
                near = did_you_mean(port.name, inputs)
                problems.append(
                    Diagnosis(
                        "E502",
                        f"input `{port.name}` is missing",
                        cause=f"given are: {', '.join(inputs) or 'none'}",
                        remedy=near or f"give an array of {_expected(port)}",
                    )
                )
                continue
            try:
                array = np.asarray(inputs[port.name], dtype=np.float64)
            except (TypeError, ValueError):
                problems.append(_misshapen(port, "it is not an array of numbers"))
                continue
            rank = array.ndim - len(port.type.shape)
            if rank not in (1, 2) or array.shape[rank:] != port.type.shape:
                problems.append(_misshapen(port, f"it has shape {list(array.shape)}"))
                continue
            if lead is None:
                lead = array.shape[:rank]
            elif lead != array.shape[:rank]:
                problems.append(
                    _misshapen(port, f"it has leading axes {list(array.shape[:rank])}, the input before {list(lead)}")
                )
                continue
            arrays[port.name] = array
        if problems:
            raise DiagnosisError(problems)
        if lead is None:
            lead = np.asarray(next(iter(inputs.values()))).shape[:1] if inputs else (1,)
        return (arrays, None, lead[0]) if len(lead) == 1 else (arrays, lead[0], lead[1])


def one_or_batch() -> DiagnosisError:
    """E508: frames of one flight after frames of a batch, or the other way round."""
    return DiagnosisError(
        [
            Diagnosis(
                "E508",
                "one flight and a batch do not share a state",
                cause="the frames before were of the other kind",
                remedy="call reset(), or use a simulator for each",
            )
        ]
    )


def _part(slot: Any, start: int, stop: int, count: int) -> Any:
    return slot[start:stop] if isinstance(slot, np.ndarray) and slot.shape == (count,) else slot


def _expected(port: ProgramPort) -> str:
    shape = ", ".join(map(str, port.type.shape))
    return f"shape (frames{', ' + shape if shape else ''}), or with a leading axis of flights"


def _misshapen(port: ProgramPort, cause: str) -> Diagnosis:
    return Diagnosis("E507", f"input `{port.name}` has the wrong shape", cause=cause, remedy=f"give {_expected(port)}")
