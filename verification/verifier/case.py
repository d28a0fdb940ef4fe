"""What a sheet is compared with: the protocol between a numpy reference and the verifier.

A :class:`ReferenceCase` starts the reference in every frame from the state that the SHEET is in, so that an error is
seen where it is made and does not pile up. A :class:`FunctionReference` is the plain form for a user's own sheet: one
function from all inputs to all outputs.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Values = Mapping[str, Array]
"""Arrays by name: ports, probed wires or compared quantities."""

TOLERANCE = 1e-10
"""Largest difference frame by frame, relative to max(\\|reference\\|, sigma)."""


@dataclass(frozen=True, eq=False)
class Compared:
    """One quantity that both sides compute: a wire of the sheet against an array of the reference.

    They are listed in the order in which a frame computes them: the first that differs is where to look.
    """

    name: str
    """Its name in the report."""
    wire: str | tuple[str, ...]
    """The sheet's output, or the path of a probed wire; of the same shape as the reference's array. Several wires
    (of the instances of a fold) are stacked along a leading axis."""
    sigma: Array | float
    """Scale of the quantity, in the wire's unit; broadcasts against it. Smaller values count as this large."""
    tolerance: float = TOLERANCE
    unit: str = ""
    part: str = "frame"
    """The part of the sheet that the report lists it under."""
    repeat: str = ""
    """Which of several quantities of one name this is, such as the pass of an iteration: the report shows their worst."""
    after: int = 0
    """Compared only in frames where the first ``after`` choices fell alike."""
    following: bool = False
    """The wire is the output of a delay: its value in the NEXT frame is what this frame's reference expects."""

    @property
    def key(self) -> str:
        """Its name among the values of :class:`Expected`: the wire's name tells repeats and namesakes apart."""
        return f"{self.name} at {self.wire_name}" if self.repeat or self.part != "frame" else self.name

    @property
    def wires(self) -> tuple[str, ...]:
        """The wire, or the wires that are stacked."""
        return (self.wire,) if isinstance(self.wire, str) else self.wire

    @property
    def wire_name(self) -> str:
        """The wire as the report names it."""
        return self.wires[0] if len(self.wires) == 1 else f"{self.wires[0]} ... {self.wires[-1]}"

    def of_sheet(self, values: Values) -> Array:
        """The quantity from the sheet's wires, one row a frame."""
        if isinstance(self.wire, str):
            return values[self.wire]
        return np.stack([values[wire] for wire in self.wire], axis=1)


@dataclass(frozen=True)
class Choice:
    """A discrete value that a comparison of real numbers decides, such as the step length of a line search.

    Where rounding makes the comparison fall otherwise, what depends on it is not compared in that frame. That is
    excused only with a margin of at most ``margin``, and in at most ``share`` of the frames.
    """

    name: str
    wire: str
    margin: float = 1e-12
    share: float = 1e-3


@dataclass(frozen=True, eq=False)
class Expected:
    """What the reference gives in one frame."""

    values: Values
    """By the keys of the case's ``compared``: their names, in the simple case."""
    choices: Values = field(default_factory=dict)
    """By the names of the case's ``choices``: the discrete value, shape ()."""
    margins: Mapping[str, float] = field(default_factory=dict)
    """By the same names: how near the comparison was to falling otherwise, relative."""


@dataclass(frozen=True, eq=False)
class Scenario:
    """A run from the initial state: inputs by port, one row a frame."""

    name: str
    inputs: Values
    fault_free: bool = False
    """Whether the closed loop with tables has to stay near the reference."""
    first_frame: int = 0
    """Which frame of the recording is the first."""

    def __len__(self) -> int:
        return len(next(iter(self.inputs.values()))) if self.inputs else 0


@dataclass(frozen=True)
class Closeness:
    """An output of the closed loop with tables, and how far it may be from the reference in fault-free runs.

    ``limit`` None: its largest difference is shown without a verdict. ``scale`` turns the port's unit into ``unit``.
    """

    output: str
    limit: float | None
    unit: str
    scale: float = 1.0


@dataclass(frozen=True)
class Decision:
    """A latched decision of the closed loop: the same in every frame, but where its measure is near its threshold."""

    output: str
    measure: str
    """The output that is held against the threshold, of the same shape."""
    threshold: float
    table_error: float
    """How far the tables may move the measure."""
    unit: str
    scale: float = 1.0
    """Turns the port's unit into ``unit``; threshold and table error are in ``unit``."""
    window: int = 1
    """Over how many frames, the present one included, the decision counts."""


@dataclass(frozen=True, eq=False)
class ClosedLoop:
    """The sheet with its tables against the reference, each from its own state."""

    run: Callable[[Values], Values]
    close: tuple[Closeness, ...]
    decisions: tuple[Decision, ...] = ()


@dataclass(frozen=True, eq=False)
class ReferenceCase:
    """A reference that can start from any state of the sheet."""

    sheet: str
    scenarios: Callable[[int, int], Sequence[Scenario]]
    """From (frames in total, seed) to runs."""
    state_wires: tuple[str, ...]
    """The wires (outputs of delays) that hold the sheet's state at the beginning of a frame."""
    expect: Callable[[Values, Values], Expected]
    """From the state wires and the inputs of one frame to what the reference computes in it."""
    compared: tuple[Compared, ...]
    choices: tuple[Choice, ...] = ()
    initial: Values = field(default_factory=dict)
    """By the keys of those compared that are ``following``: what they hold in the first frame."""
    closed_loop: ClosedLoop | None = None


@dataclass(frozen=True, eq=False)
class FunctionReference:
    """A plain function from all inputs of a run, one row a frame, to all outputs, one row a frame.

    ``scenarios`` makes the runs, from (frames in total, seed); without it the inputs are random.
    ``sigma`` by output; without it the largest magnitude of the reference's output in the run.
    """

    run: Callable[[dict[str, Array]], Mapping[str, Array]]
    scenarios: Callable[[int, int], Sequence[Scenario]] | None = None
    sigma: Mapping[str, float] = field(default_factory=dict)
    tolerance: float = TOLERANCE


Reference = ReferenceCase | FunctionReference
