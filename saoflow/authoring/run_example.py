"""Running the example of an explanation in a folder of its own: what its last command says."""

from __future__ import annotations

import contextlib
import io
import os
import runpy
import shlex
import subprocess
import sys
import warnings
from collections.abc import Iterator
from pathlib import Path
from tempfile import TemporaryDirectory

from saoflow.authoring.explanation import Explanation
from saoflow.diagrams.store import SHIPPED

NO_COMPILER = "a C compiler"
"""What an example may be without, beside packages."""


def run_example(example: Explanation) -> str:
    """Run the commands one after another; the diagnoses of the last. Paths of shipped sheets lose what depends on the machine.

    Changes the working folder while it runs. Raises CalledProcessError if a command before the last fails.
    """
    said = ""
    with TemporaryDirectory(prefix="saoflow-") as folder, contextlib.chdir(folder), _without(example.without):
        for file in example.files:
            Path(file.name).write_text(file.text, encoding="utf-8")
        for command in example.commands:
            said = _run(command)
        said = said.replace(f"{Path(folder).resolve()}{os.sep}", "").replace(f"{folder}{os.sep}", "")
    return "\n".join(line.rstrip() for line in said.replace(str(SHIPPED), "saoflow/diagrams").rstrip().split("\n"))


def _run(command: str) -> str:
    """``saoflow`` and ``python`` in this process, which is quick; others by their own program."""
    words = shlex.split(command)
    if words[0] == "saoflow":
        return _command(words[1:])
    if words[0] == "python":
        out = io.StringIO()
        with contextlib.redirect_stdout(out):
            runpy.run_path(words[1], run_name="__main__")
        return out.getvalue()
    subprocess.run(words, check=True, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL)
    return ""


def _command(arguments: list[str]) -> str:
    from saoflow import cli

    errors = io.StringIO()
    with warnings.catch_warnings(), contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(errors):
        warnings.simplefilter("ignore")
        cli.run(arguments)
    return errors.getvalue()


@contextlib.contextmanager
def _without(what: str) -> Iterator[None]:
    """A machine on which something is not installed."""
    if not what:
        yield
        return
    package = "ziglang" if what == NO_COMPILER else what
    hidden = {name: module for name, module in sys.modules.items() if name.partition(".")[0] == package}
    path = os.environ.get("PATH", "")
    compilers = {name: os.environ.pop(name) for name in ("CC", "SAOFLOW_CC") if name in os.environ}
    for name in hidden:
        del sys.modules[name]
    sys.modules[package] = None  # type: ignore[assignment]  # Python's way to say that it cannot be imported
    if what == NO_COMPILER:
        os.environ["PATH"] = ""
    try:
        yield
    finally:
        del sys.modules[package]
        sys.modules.update(hidden)
        os.environ["PATH"] = path
        os.environ.update(compilers)
