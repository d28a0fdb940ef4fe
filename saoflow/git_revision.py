"""A sheet as it was in a revision of its git repository, with the sheets beside it."""

from __future__ import annotations

import io
import subprocess
import tarfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory

from saoflow.diagnosis import DiagnosisError, refusal

LONGEST = 60.0
"""Seconds that git may take."""


@contextmanager
def sheet_at(file: str, revision: str) -> Iterator[Path]:
    """The path of the sheet as it was at ``revision``, in a folder that is there while the context lasts.

    Raises DiagnosisError E612: no git, no repository, no such revision, or the sheet was not there.
    """
    path = Path(file).resolve()
    if revision.startswith("-") or not revision.strip():
        raise _trouble(f"`{revision}` is no revision", "a revision is a branch, a tag or a commit", "write main, or HEAD~1")
    top = _git(path.parent, "rev-parse", "--show-toplevel").decode().strip()
    _git(path.parent, "rev-parse", "--verify", "--quiet", f"{revision}^{{commit}}", trouble=f"there is no revision `{revision}`")
    folder = path.parent.relative_to(Path(top).resolve())
    packed = _git(
        Path(top), "archive", "--format=tar", revision, "--", str(folder), trouble=f"`{folder}` is not in `{revision}`"
    )
    with TemporaryDirectory(prefix="saoflow-") as temporary:
        with tarfile.open(fileobj=io.BytesIO(packed)) as archive:
            archive.extractall(temporary, filter="data")
        found = Path(temporary) / folder / path.name
        if not found.is_file():
            raise _trouble(f"`{path.name}` is not in `{revision}`", "the revision has no such file", "name another revision")
        yield found


def _git(folder: Path, *arguments: str, trouble: str = "") -> bytes:
    try:
        done = subprocess.run(["git", "-C", str(folder), *arguments], capture_output=True, timeout=LONGEST, check=False)
    except (OSError, subprocess.TimeoutExpired) as error:
        raise _trouble("git cannot be run", str(error), "install git, or compare with a file: --vs FILE") from None
    if done.returncode:
        said = done.stderr.decode(errors="replace").strip().splitlines()
        cause = said[-1] if said else f"git {arguments[0]} fails without a word"
        raise _trouble(trouble or f"`{folder}` is in no git repository", cause, "name a revision that `git log` shows")
    return done.stdout


def _trouble(message: str, cause: str, remedy: str) -> DiagnosisError:
    return refusal("E612", message, cause=cause, remedy=remedy)
