"""Frames in compiled C: the same Simulator, state and bits as the interpreter's, hundreds of times faster.

One flight runs the statements of the code that flies; a batch runs a register of flights side by side. Look-ups alone find
their interval another way here.
"""

from __future__ import annotations

import ctypes
import time
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from saoflow.codegen.compiler import register_bytes
from saoflow.codegen.interface import ENTRY
from saoflow.codegen.objects import Objects
from saoflow.codegen.stack import stack_bound
from saoflow.diagnosis import Diagnosis, DiagnosisError, refusal
from saoflow.scheduler.program import FrameProgram, ProgramPort
from saoflow.scheduler.simulator import Arrays, Simulator, State, one_or_batch

PAUSE = 0.1
"""Seconds in C before progress is told and Ctrl-C is heard."""

SMALL_STACK = 1 << 20
"""Bytes that any thread has left."""
MOST_STACK = 16 << 20
"""Bytes of a frame for one flight. A frame that takes more would be minutes in the compiler."""

Runner = Callable[..., None]


class NativeSimulator(Simulator):
    """Frames of one program in C. Same methods as :class:`Simulator`; ``exact`` does not exist here."""

    def __init__(self, program: FrameProgram, objects: Objects) -> None:
        super().__init__(program)
        self._objects = objects
        self._stack = _stack_needed(program)
        self._runners: dict[int, Runner] = {0: _runner(objects, 0)}
        self._slots: np.ndarray | None = None
        """(slots, flights), binary64."""
        self._type = np.dtype(np.float64 if program.real == 64 else np.float32)
        self.lanes = register_bytes() // self._type.itemsize
        """Flights that a batch runs side by side."""

    def reset(self) -> None:
        """Back to the initial values."""
        super().reset()
        self._slots = None

    def state(self) -> State:
        """A copy of the present state."""
        if self._slots is None:
            return super().state()
        slots = self._slots.copy()
        return State(slots[:, 0] if self._flights is None else slots, self._frame)

    def restore(self, state: State) -> None:
        """Go on from a state, of this or the interpreter's simulator. Raises DiagnosisError E508."""
        super().restore(state)
        slots = super().state().slots
        self._slots = np.array(slots.reshape(len(slots), -1), dtype=np.float64, order="C")
        self._state = None

    def _run_one(self, arrays: Arrays, frames: int, progress: Callable[[int], None] | None) -> Arrays:
        return self._run_batch(arrays, None, frames, progress)

    def _run_batch(
        self, arrays: Arrays, flights: int | None, frames: int, progress: Callable[[int], None] | None
    ) -> Arrays:
        count = 1 if flights is None else flights
        slots = self._slots_for(flights, count)
        lead = () if flights is None else (count,)
        ports = (*self.program.outputs, *self.program.probes)
        outputs = {port.name: np.empty((*lead, frames, *port.type.shape), dtype=self._type) for port in ports}
        given = [_strided(arrays[port.name], port, flights is not None) for port in self.program.inputs]
        taken = [_strided(outputs[port.name], port, flights is not None) for port in ports]
        lanes = self.lanes if count > 1 else 0
        if lanes not in self._runners:
            self._runners[lanes] = _runner(self._objects, lanes)
        loop = _Loop(self._runners[lanes], slots, given, taken, max(lanes, 1))
        _with_stack(self._stack * max(lanes, 1), lambda: loop.run(count, frames, progress))
        self._slots, self._flights, self._frame = slots, flights, self._frame + frames
        return outputs

    def _slots_for(self, flights: int | None, count: int) -> np.ndarray:
        """The state to go on from: a copy, so that an interrupted run leaves the present one as it is."""
        if self._slots is None:
            initial = np.array([float(slot.initial) for slot in self.program.states])
            return np.repeat(initial[:, None], count, axis=1)
        if (flights is None) != (self._flights is None):
            raise one_or_batch()
        self._check_flights(flights)
        return self._slots.copy()


class _Loop:
    """Calls of the runner, each of about PAUSE seconds."""

    def __init__(
        self, runner: Runner, slots: np.ndarray, given: Sequence[_Strided], taken: Sequence[_Strided], width: int
    ) -> None:
        self.runner = runner
        self.slots = slots
        self.given = given
        self.taken = taken
        self.width = width
        self.pace = 200_000.0
        """Frames a second, as measured."""

    def run(self, flights: int, frames: int, progress: Callable[[int], None] | None) -> None:
        """All frames of all flights; ``progress`` as in :meth:`Simulator.run`."""
        groups = -(-flights // self.width)
        in_steps, out_steps = _steps(self.given), _steps(self.taken)
        for group in range(groups):
            start = 0
            while start < frames:
                stop = min(frames, start + max(1, int(self.pace * PAUSE)))
                began = time.perf_counter()
                self.runner(
                    self.slots.ctypes.data,
                    (ctypes.c_long * 3)(flights, group * self.width, stop - start),
                    _pointers(self.given, start),
                    in_steps,
                    _pointers(self.taken, start),
                    out_steps,
                )
                self.pace = (stop - start) / max(time.perf_counter() - began, 1e-7)
                if progress is not None:
                    progress((group * frames + stop) // groups)
                start = stop


class _Strided:
    """An array as the runner reads it: its address, and how far the next flight and the next frame are."""

    __slots__ = ("array", "data", "flight", "frame")

    def __init__(self, array: np.ndarray, batch: bool) -> None:
        steps = [stride // array.itemsize for stride in array.strides]
        self.array = array
        self.data = array.ctypes.data
        self.flight = steps[0] if batch else 0
        self.frame = steps[1] if batch else steps[0]


def _strided(array: np.ndarray, port: ProgramPort, batch: bool) -> _Strided:
    """The array itself where its elements lie side by side (also broadcast over flights), else a copy."""
    lead = 2 if batch else 1
    size = array.itemsize
    beside = tuple(int(np.prod(port.type.shape[i + 1 :])) * size for i in range(len(port.type.shape)))
    whole = all(stride % size == 0 for stride in array.strides) and array.flags.aligned
    return _Strided(array if whole and array.strides[lead:] == beside else np.ascontiguousarray(array), batch)


def _pointers(arrays: Sequence[_Strided], frame: int) -> Any:
    return (ctypes.c_void_p * len(arrays))(*(a.data + frame * a.frame * a.array.itemsize for a in arrays))


def _steps(arrays: Sequence[_Strided]) -> Any:
    return (ctypes.c_long * (2 * len(arrays)))(*(step for a in arrays for step in (a.flight, a.frame)))


def _stack_needed(program: FrameProgram) -> int:
    """Bytes for one flight, at most. Raises DiagnosisError E610 for a sheet that is not compiled for its size."""
    needed = stack_bound(program)
    if needed > MOST_STACK:
        raise DiagnosisError(
            [
                Diagnosis(
                    "E610",
                    f"a frame of `{program.sheet}` is too large for the stack: up to {needed} bytes, {MOST_STACK} allowed",
                    cause="every wire of a sheet is a local variable of its C function",
                    remedy="use backend `interpreter`, or smaller matrices, folds and maps",
                )
            ]
        )
    return needed


def _with_stack(needed: int, work: Callable[[], None]) -> None:
    """Run in this thread, or in one with a larger stack."""
    if needed <= SMALL_STACK:
        work()
        return
    import threading

    problems: list[BaseException] = []

    def run() -> None:
        try:
            work()
        except BaseException as problem:
            problems.append(problem)

    before = threading.stack_size(-(-(needed + SMALL_STACK) // 65536) * 65536)
    try:
        thread = threading.Thread(target=run)
        thread.start()
    finally:
        threading.stack_size(before)
    thread.join()
    if problems:
        raise problems[0]


def _runner(objects: Objects, lanes: int) -> Runner:
    path = objects.path(lanes)
    try:
        library = ctypes.CDLL(str(path))
    except OSError as error:
        raise refusal(
            "E607",
            "the compiled frame cannot be loaded",
            cause=str(error),
            remedy="set XDG_CACHE_HOME to a folder from which programs may be loaded, or use backend `interpreter`",
        ) from None
    function = getattr(library, ENTRY)
    function.argtypes = [ctypes.c_void_p] * 6
    function.restype = None
    return function  # type: ignore[no-any-return]
