"""Records the shipped flights anew: ``python -m verification.flights.ship [FOLDER]``."""

from __future__ import annotations

import sys
from pathlib import Path

from rich.console import Console
from rich.progress import Progress

from verification import recordings
from verification.flights.catalogue import SHIPPED
from verification.flights.record import record
from verification.recordings import write_recording


def ship(folder: Path) -> None:
    """Records every shipped flight into ``folder``."""
    with Progress(console=Console(stderr=True)) as progress:
        task = progress.add_task("recording", total=len(SHIPPED))
        for number, plan in enumerate(SHIPPED):
            progress.update(task, description=plan.name)

            def show(done: float, before: int = number) -> None:
                progress.update(task, completed=before + done)

            recording = record(plan, show)
            write_recording(recording, folder / f"{plan.name}{recordings.SUFFIX}")
        progress.update(task, completed=len(SHIPPED), description="recorded")


if __name__ == "__main__":
    ship(Path(sys.argv[1]) if len(sys.argv) > 1 else recordings.FOLDER)
