"""Every command that the pages show runs: as it stands, filled in, or shortened (``verification/documentation/command_table.py``).

The whole of it is ``python -m verification.documentation.commands --whole``. Commands above marked blocks are run by
``test_pages.py`` and ``tests/verification/demo/test_readme.py``.
"""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from saoflow.authoring.explanation import explanations
from verification.demo.readme import blocks
from verification.documentation import command_table as table
from verification.documentation.commands import (
    Outcome,
    entries,
    main,
    prepare,
    promised,
    run,
    run_page,
    run_step,
    steps,
)
from verification.documentation.shown_commands import ROOT, page_name, pages, shown_commands

RUN = [page for page in pages() if any(step.runs for step in steps(page))]
LEFT_OUT = {"pip install ziglang"}
"""All that is run nowhere; a new one has to be put here, too."""


@pytest.mark.parametrize("page", RUN, ids=page_name)
def test_the_commands_of_a_page_run(page: Path) -> None:
    problems = [f"{outcome.step.shown.line}: {outcome.problem}" for outcome in run_page(page) if outcome.problem]
    assert problems == [], "\n\n".join(problems)


def test_pages_with_commands_are_found() -> None:
    names = {page_name(page) for page in RUN}
    assert {"README.md", "docs/tutorial.md", "docs/campaign.md", "docs/c_code.md", "docs/papers/README.md"} <= names
    assert sum(len(steps(page)) for page in RUN) > 100


# ---------------------------------------------------------------- the table


SHOWN = [shown for page in pages() for shown in shown_commands(page)]


def test_every_entry_of_the_table_is_shown_somewhere() -> None:
    commands = {shown.command for shown in SHOWN}
    assert [entry.command for entry in entries() if entry.command not in commands] == []
    assert [held.page for held in table.HELD if held.page not in {shown.page for shown in SHOWN if shown.typed}] == []
    assert [one.page for one in table.SUPPOSED if not (ROOT / one.page).is_file()] == []


def test_no_command_is_in_the_table_twice() -> None:
    ways = (*table.FILLED, *table.SHORT, *(e for e in table.ELSEWHERE if not e.page), *table.NOT_HERE)
    commands = [entry.command for entry in ways]
    assert len(commands) == len(set(commands))


def options(command: str) -> set[str]:
    return set(re.findall(r"(?<=\s)--?[a-z][\w-]*", command))


@pytest.mark.parametrize("short", table.SHORT, ids=lambda short: short.command)
def test_a_shortened_command_is_the_same_command(short: table.Short) -> None:
    """The same program, all its options, and never a mere word of help."""
    begins = re.match(r"(?:saoflow \w+|python [\w./-]+(?: [\w.]+)?|make \w+)", short.command)
    assert begins is not None
    assert begins[0] in short.run
    assert options(short.command) <= options(short.run)
    assert not {"--help", "-h", "--list"} & options(short.run)
    assert len(short.why) > 5


def test_what_runs_elsewhere_is_run_there() -> None:
    for entry in table.ELSEWHERE:
        file, _, test = entry.where.partition("::")
        text = (ROOT / file).read_text(encoding="utf-8")
        if test:
            found = re.search(rf"^def {test}\(.*?(?=^\S|\Z)", text, re.MULTILINE | re.DOTALL)
            assert found is not None, entry.where
            text = found[0]
        assert entry.words in text, entry.where


def test_what_is_run_nowhere_is_listed() -> None:
    assert {entry.command for entry in table.NOT_HERE} == LEFT_OUT
    for entry in table.NOT_HERE:
        print(f"not run: {entry.command}: {entry.why}")


def test_the_explanations_commands_are_those_of_their_page() -> None:
    """`test_explain.py` runs every example of docs/diagnoses.md, so the page may show nothing else."""
    typed = {shown.command for shown in SHOWN if shown.page == "docs/diagnoses.md" and shown.typed}
    run_there = {re.split(r"\s#\s", command)[0].strip() for entry in explanations() for command in entry.commands}
    assert typed <= run_there


# ---------------------------------------------------------------- code


def test_every_block_of_python_is_a_file_that_is_run() -> None:
    for page in pages():
        lines = page.read_text(encoding="utf-8").split("\n")
        files = {block.first - 1 for block in blocks("\n".join(lines)) if block.kind == "file"}
        loose = [k + 1 for k, line in enumerate(lines) if line.startswith("```python") and k not in files]
        if page_name(page) != "docs/diagnoses.md":
            assert loose == [], f"{page_name(page)}: put <!-- file: NAME.py --> above line {loose}"


# ---------------------------------------------------------------- it can fail


def outcomes(page: Path, text: str) -> list[Outcome]:
    page.write_text(text, encoding="utf-8")
    return list(run_page(page, among=[page]))


def problems(page: Path, text: str) -> list[str]:
    return [outcome.problem.split("\n")[0] for outcome in outcomes(page, text)]


def test_commands_are_found_where_a_reader_finds_them(tmp_path: Path) -> None:
    page = tmp_path / "page.md"
    page.write_text(
        "`saoflow check` is a name, `saoflow check a.yaml` and `saoflow run a.yaml\nb.csv -o c.csv` are commands.\n"
        "\n    saoflow symbols    # a remark\n    X=1 saoflow demo && saoflow schema\n    import saoflow\n"
        "\n```console\n$ make demo\nmake says: python x.py\n```\n```yaml\nsaoflow check: 1\n```\n"
        "<!-- file: x.py -->\n```python\npython = 1\n```\n<!-- file: y.py -->\n```python\n```\n"
        "<!-- numbers: python x.py | head -1 -->\n```\npip install nothing\n```\n"
        "<!-- measured: python benchmarks/z.py -->\n```\n1\n```\n",
        encoding="utf-8",
    )
    assert [(shown.line, shown.command, shown.typed) for shown in shown_commands(page)] == [
        (1, "saoflow check a.yaml", False),
        (1, "saoflow run a.yaml b.csv -o c.csv", False),
        (4, "saoflow symbols", True),
        (5, "X=1 saoflow demo", True),
        (5, "saoflow schema", True),
        (9, "make demo", True),
        (20, "python y.py", True),
        (27, "python benchmarks/z.py", True),
    ]


def test_wrong_commands_are_seen(tmp_path: Path) -> None:
    page = tmp_path / "page.md"
    assert problems(page, "    saoflow check nowhere.yaml\n") == ["saoflow check nowhere.yaml: exit code 2, not 0"]
    assert problems(page, "    python -m verification.nothing\n") == ["python -m verification.nothing: exit code 1, not 0"]
    wrong = "<!-- file: a.py -->\n```python\nimport sys\nprint('Traceback (most recent call last)', file=sys.stderr)\n```\n"
    assert problems(page, wrong) == ["python a.py: a traceback"]
    silent = "<!-- file: a.py -->\n```python\n```\n    python a.py -o b.txt\n"
    assert problems(page, silent) == ["", "python a.py -o b.txt: b.txt was not written"]
    old = "<!-- file: b.txt -->\n```\nold\n```\n" + silent.replace("```python\n", "```python\nimport os\nos.utime('b.txt', (0, 0))\n")
    assert problems(page, old) == ["", "python a.py -o b.txt: b.txt was not written"]


def test_what_is_typed_later_finds_what_was_written_before(tmp_path: Path) -> None:
    """By a program above a block of numbers, which is compared elsewhere, or by a command."""
    text = (
        "<!-- file: start.py -->\n```python\nopen('a.txt', 'w').write('x')\n```\n"
        "<!-- numbers: python start.py -->\n```\n```\n"
        "<!-- file: more.py -->\n```python\nimport sys\nopen(sys.argv[2], 'a').write(open(sys.argv[1]).read())\n```\n"
        "    python more.py a.txt b.txt\n    python more.py b.txt c.txt\n    python more.py d.txt e.txt    # there is no d.txt\n"
    )
    found = [problem.rpartition(": ")[2] for problem in problems(tmp_path / "page.md", text)]
    assert found == ["exit code 1, not 0", "", "", "exit code 1, not 0"]


def test_a_stale_answer_is_seen(tmp_path: Path) -> None:
    """Blocks of results that take seconds are compared here; those that are run in part are not."""
    page = tmp_path / "page.md"
    text = "<!-- numbers: python -m verification.results.horizon_operations --help | tail -1 -->\n```\n{}\n```\n"
    right = "  --longest LONGEST  the largest N; at least 3"
    assert problems(page, text.format(right)) == [""]
    assert problems(page, text.format(right.replace("3", "4")))[0].endswith("the page shows another answer")


def test_what_is_promised() -> None:
    assert promised("saoflow run a.yaml b.csv -o c.csv --report d.html") == ["c.csv", "d.html"]
    assert promised('X="a b" saoflow view sheets/a.yaml --svg') == ["a.svg"]
    assert promised("saoflow fmu a.yaml") == ["a.fmu"]
    assert promised("saoflow budget a.yaml") == []


def test_a_folder_holds_what_a_page_supposes_and_the_checkout_stays(tmp_path: Path) -> None:
    page = ROOT / "docs" / "lean.md"
    before = page.read_bytes()
    prepare(tmp_path, page)
    assert run("python -m verification.results.lean_table --help", tmp_path).returncode == 0
    (tmp_path / "docs" / "lean.md").write_text("changed", encoding="utf-8")
    assert page.read_bytes() == before
    assert "saoflow" in run("saoflow --version", tmp_path).stdout


def test_the_command_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    page = tmp_path / "page.md"
    page.write_text("`saoflow explain E999`, `saoflow explain E211`, `pip install ziglang`\n", encoding="utf-8")
    assert main([str(page), "--list"]) == 0
    assert capsys.readouterr().out.count("page.md:1") == 3
    with pytest.raises(SystemExit, match="2"):
        main([str(tmp_path / "none.md")])
    for step in steps(page, among=[page]):
        prepared = tmp_path / step.shown.command.split()[-1]
        assert bool(step.left_out) or bool(run_step(step, _made(prepared))) == ("E999" in step.shown.command)


def _made(folder: Path) -> Path:
    folder.mkdir()
    return folder
