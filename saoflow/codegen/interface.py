"""The C names of a sheet: its structs, their fields, its functions."""

from __future__ import annotations

from dataclasses import dataclass

ENTRY = "saoflow_run"
"""What a compiled object offers: the loop over frames of ``runner.py``."""


@dataclass(frozen=True, slots=True)
class StateField:
    """A field of the state struct: the slots of one delay, from the first on."""

    name: str
    path: str
    first: int
    size: int
    boolean: bool


@dataclass(frozen=True, slots=True)
class Interface:
    """The C names that a caller needs."""

    prefix: str
    real_type: str
    input_struct: str
    output_struct: str
    state_struct: str
    init: str
    step: str
    inputs: tuple[str, ...]
    """Field names, in the order of the ports."""
    outputs: tuple[str, ...]
    states: tuple[StateField, ...]
    procedures: tuple[str, ...]
    """Function names, in the order of the program's procedures."""
    tables: tuple[str, ...]
