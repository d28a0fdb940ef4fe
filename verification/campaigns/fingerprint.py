"""What results depend on beside the text of a campaign: this code, the sheets, the recordings."""

from __future__ import annotations

import hashlib
from functools import lru_cache
from pathlib import Path

import saoflow
import verification
from verification.campaigns.flights import content_of
from verification.campaigns.plan import Campaign

_SAOFLOW = ("blocks", "codegen", "diagrams", "recordings", "scheduler")
_OURS = ("campaigns", "flights", "recordings", "reference")
"""Folders whose content results depend on."""


@lru_cache(maxsize=1)
def code_digest() -> str:
    """Of the code that makes results, and of the shipped sheets and recordings, by content."""
    base, beside = Path(saoflow.__file__).parent, Path(verification.__file__).parent
    found = [*base.glob("*.py")]
    for folder in _SAOFLOW:
        found += [*(base / folder).rglob("*.py"), *(base / folder).rglob("*.yaml")]
    for folder in _OURS:
        found += [*(beside / folder).rglob("*.py"), *(beside / folder).rglob("*.csv.gz")]
    whole = hashlib.sha256()
    for path in sorted(found):
        root = base if path.is_relative_to(base) else beside
        whole.update(f"{root.name}/{path.relative_to(root).as_posix()}\0".encode())
        whole.update(hashlib.sha256(path.read_bytes()).digest())
    return whole.hexdigest()


def fingerprint(campaign: Campaign) -> dict[str, str]:
    """Digests by what they are of: a campaign goes on in a folder only if all of them are the same."""
    return {
        "campaign": campaign.digest,
        "code": code_digest(),
        "sheets": _digest(*(_sheet_content(variant.sheet) for variant in campaign.sheets)),
        "flights": _digest(*(content_of(flights) for flights in campaign.flights)),
    }


def _sheet_content(sheet: str) -> str:
    """A shipped sheet is part of the code; of another, its file and those beside it, which it may use."""
    path = Path(sheet)
    if not path.is_file():
        return sheet
    return _digest(
        *(f"{p.name} {hashlib.sha256(p.read_bytes()).hexdigest()}" for p in sorted(path.parent.glob("*.yaml")))
    )


def _digest(*texts: str) -> str:
    return hashlib.sha256("\0".join(texts).encode()).hexdigest()
