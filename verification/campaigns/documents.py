"""The documents of the shipped campaigns.

    python -m verification.campaigns.documents [FILE...] [-o docs/campaign] [--runs DIR]

Runs campaigns, the shipped `table_iv`, `monte_carlo` and `detection` if none is named, and copies their reports: NAME.md, NAME.png, and
NAME.json, which ``python -m verification.papers`` reads. ``--runs`` keeps the runs, and goes on from them. The first time, flights are
recorded for some minutes.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path

from saoflow.diagnosis import DiagnosisError
from saoflow.whole_file import write_whole
from verification.campaigns.plan import Campaign
from verification.campaigns.reader import load_campaign
from verification.campaigns.report import write_report
from verification.campaigns.run import run_campaign

NAMES = ("table_iv", "monte_carlo", "detection")


def main(arguments: Sequence[str] | None = None) -> int:
    """Write the documents. Exit code 2: a campaign cannot be run, or nothing can be written there."""
    parser = argparse.ArgumentParser(prog="python -m verification.campaigns.documents", description=__doc__)
    parser.add_argument("campaigns", nargs="*", metavar="FILE", default=NAMES, help="files, or names of shipped ones")
    parser.add_argument("-o", "--output", type=Path, default=Path("docs/campaign"), help="the folder to write")
    parser.add_argument("--runs", type=Path, help="the folder that keeps the runs")
    given = parser.parse_args(arguments)
    try:
        given.output.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(prefix="saoflow-campaigns-") as temporary:
            for name in given.campaigns:
                _write(load_campaign(name), given.runs or Path(temporary), given.output)
    except (OSError, DiagnosisError) as problem:
        print(problem, file=sys.stderr)
        return 2
    return 0


def _write(campaign: Campaign, runs: Path, output: Path) -> None:
    name = campaign.name
    _, files = write_report(campaign, run_campaign(campaign, runs / name).results)
    for path in files:
        if path.suffix in (".md", ".png", ".json"):
            content = path.read_bytes()
            if path.suffix == ".md":
                content += f"\n![delays, detection by size and by kind of fault]({name}.png)\n".encode()
                content += b"\nWritten by `python -m verification.campaigns.documents`.\n"
            write_whole(output / f"{name}{path.suffix}", content)
            print(output / f"{name}{path.suffix}")


if __name__ == "__main__":
    sys.exit(main())
