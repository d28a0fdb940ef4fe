"""What the commands share: collecting diagnoses, answering in text or JSON, ``--set``, progress, tables."""

from __future__ import annotations

import json as json_text
import sys
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING, Annotated, Any, TypeVar

import typer

from saoflow.diagnosis import Diagnoses, Diagnosis, DiagnosisError, did_you_mean
from saoflow.streams import silence

if TYPE_CHECKING:
    from rich.console import Console
    from rich.progress import Progress

    from saoflow.diagrams.expression_value import Quantity
    from saoflow.pipeline import LoadedSheet

T = TypeVar("T")

SheetName = Annotated[
    str, typer.Argument(metavar="SHEET", help="A YAML file, or the name of a shipped sheet.", show_default=False)
]
Json = Annotated[bool, typer.Option("--json", help="Machine-readable result on standard output.")]
Set = Annotated[
    list[str] | None,
    typer.Option(
        "--set", metavar="NAME=VALUE", help="Override a parameter of the sheet; repeatable.", show_default=False
    ),
]

OVER_BUDGET = "E401"
FAILED, BAD_INPUT = 1, 2
"""Exit codes: what is checked does not hold; the input or the command line is wrong."""


class Findings(Diagnoses):
    """Diagnoses of steps that do not depend on each other, so that all of them are told at once."""

    def attempt(self, do: Callable[[], T]) -> T | None:
        """The result, or None after a diagnosis."""
        try:
            return do()
        except DiagnosisError as error:
            self.extend(error.diagnoses)
            return None


def exit_code(diagnoses: Sequence[Diagnosis]) -> int:
    """0 without errors; 1 if only a budget is exceeded; 2 for anything else."""
    codes = {d.code for d in diagnoses if d.severity == "error"}
    return 0 if not codes else FAILED if codes == {OVER_BUDGET} else BAD_INPUT


def finish(diagnoses: Sequence[Diagnosis], json: bool, facts: Mapping[str, Any] | None = None) -> None:
    """Tell the diagnoses (text on standard error, or JSON with the facts), and end with their exit code if it is not 0."""
    code = exit_code(diagnoses)
    with errors_stay(diagnoses):
        if json:
            answer = {**(facts or {}), "diagnoses": [d.to_dict() for d in diagnoses]}
            print(json_text.dumps(answer, indent=1, allow_nan=False), flush=True)
        else:
            tell(diagnoses)
    if code:
        raise typer.Exit(code)


@contextmanager
def errors_stay(diagnoses: Sequence[Diagnosis]) -> Iterator[None]:
    """Where nobody reads on (`| head`), errors are errors all the same: the command ends with their exit code."""
    try:
        yield
    except BrokenPipeError:
        code = exit_code(diagnoses)
        if not code:
            raise
        silence(1)
        silence(2)
        raise typer.Exit(code) from None


def tell(diagnoses: Sequence[Diagnosis]) -> None:
    """Diagnoses as text on standard error."""
    sys.stdout.flush()
    for diagnosis in diagnoses:
        print(diagnosis.render(), file=sys.stderr)


def load_sheet(
    name: str, settings: Sequence[str] | None, findings: Findings, check: bool = True
) -> LoadedSheet | None:
    """Load a sheet with ``--set`` parameters and ``check`` it as far as its schedule; None after a diagnosis."""
    from saoflow.pipeline import load

    own = Findings()
    given = parse_settings(settings or (), own)
    sheet = own.attempt(lambda: load(name))
    if sheet is not None and not own.errors:
        sheet.given = given
        if check:
            own.attempt(sheet.check)
    findings.extend(own.found)
    return None if own.errors else sheet


def parse_settings(settings: Sequence[str], findings: Findings) -> dict[str, Quantity]:
    """The values of ``--set NAME=VALUE``; E603 for what is no such pair or is set twice."""
    from saoflow.pipeline import quantity_of

    given: dict[str, Quantity] = {}
    for text in settings:
        name, equals, value = (part.strip() for part in text.partition("="))
        if not (equals and name.isidentifier() and value):
            cause = "there is no `=` in it" if not equals else "there is no value" if not value else "no parameter name"
            findings.add(
                Diagnosis(
                    "E603", f"`--set {text}` sets nothing", cause=cause, remedy="write --set NAME=VALUE: --set n=3"
                )
            )
            continue
        if name in given:
            findings.add(
                Diagnosis(
                    "E603", f"`--set {name}` is given twice", cause="only one can hold", remedy="drop one of them"
                )
            )
            continue
        quantity = findings.attempt(lambda name=name, value=value: quantity_of(name, value))  # type: ignore[misc]
        if quantity is not None:
            given[name] = quantity
    return given


def one_of(option: str, value: str, allowed: Sequence[str], code: str = "E603") -> Diagnosis:
    """An option's value that is none of those allowed."""
    return Diagnosis(
        code,
        f"`{option}` cannot be `{value}`",
        cause=f"it is one of: {', '.join(allowed)}",
        remedy=did_you_mean(value, allowed) or f"write {option} {allowed[0]}",
    )


def console(stderr: bool = False, width: int = 110) -> Console:
    """A terminal as wide as it is; a file gets so many columns and no colours."""
    from rich.console import Console

    stream = sys.stderr if stderr else sys.stdout
    return Console(stderr=stderr, width=None if stream.isatty() else width, highlight=False, soft_wrap=False)


PATIENCE = 1.0
"""Seconds of work before a progress bar shows."""


class Bar:
    """Progress on standard error: only on a terminal, and only for work of more than a second."""

    def __init__(self, title: str, total: float) -> None:
        self.title, self.total = title, total
        self.start = time.monotonic()
        self.progress: Progress | None = None
        self.wanted = sys.stderr.isatty()
        self.task: Any = None

    def __call__(self, done: float) -> None:
        """So much is done."""
        if not self.wanted or (self.progress is None and time.monotonic() - self.start < PATIENCE):
            return
        if self.progress is None:
            from rich.console import Console
            from rich.progress import Progress

            self.progress = Progress(console=Console(stderr=True), transient=True)
            self.progress.start()
            self.task = self.progress.add_task(self.title, total=self.total)
        self.progress.update(self.task, completed=done)


@contextmanager
def progress_bar(title: str, total: float) -> Iterator[Bar]:
    """A bar that goes away when the work is done or has failed."""
    bar = Bar(title, total)
    try:
        yield bar
    finally:
        if bar.progress is not None:
            bar.progress.stop()
