"""The command line ``saoflow``: finds a command, runs it, and turns whatever happens into an exit code.

Commands are functions for typer, imported only when they are asked for. Those of other packages join through the
entry-point group ``saoflow.commands``; one that cannot be imported does not disturb the others.

Exit codes: 0 success; 1 what is checked does not hold; 2 bad input or usage; 130 interrupted; 143 terminated.
"""

from __future__ import annotations

import importlib
import os
import signal
import sys
import traceback
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

from saoflow.streams import StreamError, guard, silence

if TYPE_CHECKING:
    from saoflow.diagnosis import Diagnosis

BUILT_IN = {name: f"saoflow.commands.{name}:{name}" for name in ("check", "run", "budget", "view", "build", "show", "symbols", "fmu", "explain", "fmt", "diff", "new", "schema", "lsp")}
GROUP = "saoflow.commands"
ORDER = ("demo", "new", "check", "run", "budget", "view", "verify", "build", "fmu", "fly", "campaign", "compare", "explain", "fmt", "diff", "schema", "show", "symbols")
"""The order in which help lists commands; further ones follow."""

Command = Callable[..., Any]

USAGE = """\
Usage: saoflow COMMAND ...

Block diagrams in YAML from a restricted symbol set, run inside an operation budget.

Commands:
{commands}

`saoflow COMMAND --help` explains a command, with an example.
`saoflow --version` prints the version.
Exit codes: 0 success, 1 what is checked does not hold, 2 bad input or usage."""


def main() -> None:
    """The entry point: runs ``sys.argv`` and exits."""
    # A command that is told to end does so like one that is interrupted: half-written files are removed.
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(143))
    guard()
    sys.exit(run(sys.argv[1:]))


def run(arguments: Sequence[str]) -> int:
    """Run one command line; returns its exit code. Never raises for bad input."""
    try:
        code = _answered(arguments)
        sys.stdout.flush()
        return code
    except KeyboardInterrupt:
        return 130
    except BrokenPipeError:
        # Whoever read our output has enough. Nothing more is written, not even when Python ends.
        silence(1)
        return 0
    except StreamError as error:
        silence(error.stream)
        if error.stream == 1:
            _refuse_output(error)
        return 2


def _answered(arguments: Sequence[str]) -> int:
    """The exit code of a command line, all of its errors told; raises what a stream that cannot be written raises."""
    json = "--json" in arguments
    try:
        return _dispatch(list(arguments), json)
    except (BrokenPipeError, StreamError):
        raise
    except Exception as error:
        return _failed(error, json)


def _refuse_output(error: StreamError) -> None:
    """Tell, on standard error in any form, that standard output is no use."""
    from saoflow.diagnosis import Diagnosis

    cause = error.strerror or str(error)
    remedy = "make room, or send the output to another place"
    told = Diagnosis("E601", "standard output cannot be written", cause=cause, remedy=remedy)
    try:
        print(told.render(), file=sys.stderr, flush=True)
    except OSError:
        silence(2)


def _dispatch(arguments: list[str], json: bool) -> int:
    if not arguments or arguments[0] in ("--help", "-h", "help"):
        if len(arguments) > 1 and arguments[0] == "help":
            return _dispatch([arguments[1], "--help"], json)
        print(_usage())
        return 0 if arguments else 2
    if arguments[0] == "--version":
        print(f"saoflow {_version()}")
        return 0
    name = arguments[0]
    if name == "check" and (code := _kept_check(arguments[1:])) is not None:
        return code
    command = _find(name, json)
    return 2 if command is None else _call(name, command, arguments[1:], json)


def _kept_check(arguments: list[str]) -> int | None:
    """The exit code if all that is to be checked was found to be right before; sheets are checked often, by editors and CI."""
    from saoflow.commands.kept_check import answer

    return answer(arguments)


def _call(name: str, function: Command, arguments: list[str], json: bool) -> int:
    """Parse the arguments of a command and run it."""
    import typer
    import typer.main

    # Help in the terminal's width, without decorations that a screen reader or a log would stumble over.
    app = typer.Typer(add_completion=False, rich_markup_mode=None, pretty_exceptions_enable=False)
    app.command(name)(function)
    command = typer.main.get_command(app)
    try:
        result = command.main(arguments, prog_name=f"saoflow {name}", standalone_mode=False)
    except typer.Exit as leave:
        return leave.exit_code
    except typer.Abort:
        return 130
    except SystemExit as leave:
        # The ways of typer and rich to say that the pipe is closed.
        if type(sys.stdout).__name__ == "PacifyFlushWrapper" or isinstance(leave.__context__, BrokenPipeError):
            raise BrokenPipeError from None
        return leave.code if isinstance(leave.code, int) else 1
    except Exception as error:
        if not hasattr(error, "format_message"):
            raise
        return _misused(name, error, [option for parameter in command.params for option in parameter.opts], json)
    return result if isinstance(result, int) else 0


def _misused(name: str, error: Any, options: list[str], json: bool) -> int:
    """A command line that the parser refuses, as a diagnosis."""
    from saoflow.diagnosis import did_you_mean

    message = str(error.format_message()).split(" Did you mean")[0].split(" (Possible options")[0].rstrip(".")
    wrong = getattr(error, "option_name", None)
    near = did_you_mean(wrong, options) if wrong and "o such option" in message else ""
    return _refuse(
        message[:1].lower() + message[1:],
        f"the command line of `saoflow {name}` does not allow it",
        near or f"`saoflow {name} --help` shows what it takes, with an example",
        json,
    )


def _refuse(message: str, cause: str, remedy: str, json: bool) -> int:
    from saoflow.diagnosis import Diagnosis

    return _tell([Diagnosis("E609", message, cause=cause, remedy=remedy)], json)


def _tell(diagnoses: Sequence[Diagnosis], json: bool) -> int:
    """Diagnoses that no command tells itself, in the form that was asked for."""
    if json:
        import json as json_text

        print(json_text.dumps({"diagnoses": [d.to_dict() for d in diagnoses]}, indent=1))
    else:
        print("\n".join(d.render() for d in diagnoses), file=sys.stderr)
    return 2


def _failed(error: Exception, json: bool) -> int:
    """What no command foresaw: diagnoses that came through, or an error of ours."""
    from saoflow.diagnosis import Diagnosis, DiagnosisError

    if isinstance(error, DiagnosisError):
        return _tell(error.diagnoses, json)
    if isinstance(error, MemoryError):
        short = Diagnosis(
            "E611",
            "there is not enough memory",
            cause=str(error) or "the system gives no more, or a limit is set (ulimit -v)",
            remedy="give saoflow more memory, or a smaller sheet or batch; `saoflow run` takes recordings of any length",
        )
        return _tell([short], json)
    if isinstance(error, FileNotFoundError) and not _has_working_folder():
        cause, remedy = "it was removed or replaced while a shell stood in it", "change to a folder that is there: cd ."
        return _tell([Diagnosis("E101", "the working folder is gone", cause=cause, remedy=remedy)], json)
    if os.environ.get("SAOFLOW_TRACEBACK"):
        traceback.print_exception(error)
    frame = traceback.extract_tb(error.__traceback__)[-1]
    report = Diagnosis(
        "E699",
        f"an error inside saoflow: {type(error).__name__}: {error}",
        cause=f"saoflow {_version()} did not foresee this, in {os.path.basename(frame.filename)}, line {frame.lineno}",
        remedy="please report it with the input; SAOFLOW_TRACEBACK=1 shows where it happened",
    )
    return _tell([report], json)


def _has_working_folder() -> bool:
    try:
        os.getcwd()
    except FileNotFoundError:
        return False
    return True


# -- finding commands


def _find(name: str, json: bool) -> Command | None:
    """The function of a command; None after a diagnosis."""
    if name in BUILT_IN:
        return _load(BUILT_IN[name])
    joined = _joined()
    if name not in joined:
        from saoflow.diagnosis import did_you_mean

        _refuse(
            f"there is no {'option' if name.startswith('-') else 'command'} `{name}`",
            f"the commands are: {', '.join(_in_order({*BUILT_IN, *joined}))}",
            did_you_mean(name, {*BUILT_IN, *joined}) or "`saoflow --help` explains them",
            json,
        )
        return None
    try:
        return _load(joined[name])
    except Exception as error:
        if os.environ.get("SAOFLOW_TRACEBACK"):
            traceback.print_exception(error)
        _refuse(
            f"the command `{name}` cannot be loaded",
            f"importing {joined[name]} gives {type(error).__name__}: {error}",
            "install its package again",
            json,
        )
        return None


def _joined() -> dict[str, str]:
    """The commands of the entry-point group, as ``module:function``."""
    from importlib.metadata import entry_points

    return {entry.name: entry.value for entry in entry_points(group=GROUP) if entry.name not in BUILT_IN}


def _load(place: str) -> Command:
    module, _, function = place.partition(":")
    found: Command = getattr(importlib.import_module(module), function.split("[")[0].strip())
    return found


def _in_order(names: set[str]) -> list[str]:
    return [name for name in ORDER if name in names] + sorted(names - set(ORDER))


def _usage() -> str:
    places = {**_joined(), **BUILT_IN}
    lines = []
    for name in _in_order(set(places)):
        try:
            summary = _first_line(places[name])
        except Exception as error:
            summary = f"(cannot be loaded: {error})"
        lines.append(f"  {name:<9}{summary}")
    return USAGE.format(commands="\n".join(lines))


def _first_line(place: str) -> str:
    """What a command says of itself, read from its file: importing all of them takes ten times as long."""
    import ast
    import importlib.util

    module, _, function = place.partition(":")
    spec = importlib.util.find_spec(module)
    source = getattr(spec and spec.loader, "get_source", lambda _: None)(module)
    for node in ast.parse(source or "").body:
        if isinstance(node, ast.FunctionDef) and node.name == function and (doc := ast.get_docstring(node)):
            return doc.splitlines()[0]
    return (_load(place).__doc__ or "").strip().splitlines()[0]


def _version() -> str:
    from importlib.metadata import PackageNotFoundError, version

    try:
        return version("saoflow")
    except PackageNotFoundError:
        return "(not installed)"


if __name__ == "__main__":
    main()
