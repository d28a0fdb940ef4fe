"""Shipped recordings of flights (JSBSim, noise-free, with truth), and how to read them.

Made by ``python -m verification.flights.ship``; what each of them is stands in
``verification/flights/catalogue.py``.
"""

from __future__ import annotations

from pathlib import Path

from saoflow.diagnosis import unknown_name
from verification.recordings.recording import FRAME_PERIOD, Recording, read_recording, write_recording

__all__ = [
    "FRAME_PERIOD",
    "Recording",
    "load_recording",
    "read_recording",
    "shipped_recordings",
    "write_recording",
]

FOLDER = Path(__file__).parent
SUFFIX = ".csv.gz"


def shipped_recordings() -> tuple[str, ...]:
    """The names of the shipped recordings, sorted."""
    return tuple(sorted(path.name.removesuffix(SUFFIX) for path in FOLDER.glob(f"*{SUFFIX}")))


def load_recording(name: str) -> Recording:
    """The shipped recording ``name``. Raises DiagnosisError E721 (unknown name), E501 (damaged file)."""
    known = shipped_recordings()
    if name not in known:
        otherwise = "name one of them, or record a flight with `saoflow fly`"
        raise unknown_name("E721", f"no shipped recording `{name}`", name, known, what="shipped", otherwise=otherwise)
    return read_recording(FOLDER / f"{name}{SUFFIX}")
