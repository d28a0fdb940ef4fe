"""How the commands of the pages are run where they are not run just as they stand: filled in, shortened, or elsewhere.

Forms are filled in with what another page shows where that fits: what runs the same is run once.

Whatever a page shows and this table does not name is run as it stands. An entry that no page shows any more is an error.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

from verification.campaigns.reader import SHIPPED


@dataclass(frozen=True)
class Filled:
    """A form, with words in capitals or dots in it: what is run for it, one after the other."""

    command: str
    runs: tuple[str, ...]
    ends: int = 0
    """The exit code of the last."""
    why: str = ""
    """Where it is no form."""


@dataclass(frozen=True)
class Short:
    """The same with fewer frames, flights, runs or repetitions. ``--whole`` runs it as the page shows it."""

    command: str
    run: str
    why: str


@dataclass(frozen=True)
class Ends:
    """A command that ends with another exit code than 0, as the page says."""

    command: str
    code: int
    why: str


@dataclass(frozen=True)
class Elsewhere:
    """A command that something else runs: ``words`` stand in the file ``where``, or in its test ``::name``."""

    command: str
    where: str
    words: str
    why: str
    page: str = ""
    """On this page alone; "": on every page."""
    always: bool = False
    """With ``--whole``, too."""


@dataclass(frozen=True)
class NotHere:
    """A command that cannot be run here, not with ``--whole`` either."""

    command: str
    why: str


@dataclass(frozen=True)
class Held:
    """A page whose blocks at a prompt are run, and their answers compared, by a test of its own."""

    page: str
    test: str


@dataclass(frozen=True)
class Supposed:
    """A file that a page supposes its reader to have."""

    page: str
    name: str
    content: str
    why: str


@dataclass(frozen=True)
class Needs:
    """A program without which a command is left out, and said to be."""

    command: str
    program: str


Entry = Filled | Short | Ends | Elsewhere | NotHere | Needs

FEW = re.compile(r"\bfew/(\w+)\.yaml")
"""A shipped campaign with few runs, `few_runs`; written where a command below names it."""


def few_runs(name: str) -> str:
    """A shipped campaign with two runs of a set, of flights of a minute, two of them drawn; with `umhe_fte`, which has the
    parameters of the flagship and compiles in a fifth of the time. Raises OSError."""
    text = (Path(SHIPPED) / f"{name}.yaml").read_text(encoding="utf-8")
    text = re.sub(r"\b(count|drawn): \d+", r"\1: 2", text)
    text = re.sub(r"^sheets: .*", "sheets: [umhe_fte]", text, flags=re.M)
    return re.sub(r"duration: \[\d+, \d+\]", "duration: [60, 66]", text)


_COMPARE = 'saoflow compare "umhe_fte[n_detect=6]" --budget 2400 --campaign few/comparison.yaml -o out/compare.html'
_PIP = "pip install --dry-run --no-index --no-build-isolation"
_EXTRAS = f"{_PIP} '.[lsp,cluster]'"
_ABOUT_PIP = "from the checkout, what it needs looked for among what is installed, nothing written: tests ask no package index"
_ABOUT_PAPERS = "the shortest paper takes ten seconds; tests/verification/papers/test_paper_*.py run the short form of each"
_ABOUT_BITS = "tests/verification/bits/test_bits.py holds the flagships"

FILLED = (
    Filled("saoflow check SHEET", ("saoflow check airspeed.yaml",)),
    Filled(
        "saoflow run SHEET IN -o OUT", ("saoflow run airspeed.yaml readings.csv -o out.parquet --report run.html",)
    ),
    Filled("saoflow budget SHEET", ("saoflow budget cmhe_fte_lean",)),
    Filled(
        "saoflow budget SHEET --target NAME [--clock MHZ] [--share PART]",
        ("saoflow budget umhe_fte --target e500mc --clock 800 --share 0.5",),
    ),
    Filled("saoflow budget cmhe_fte --target NAME", ("saoflow budget umhe_fte --target mpc755",)),
    Filled("saoflow view SHEET -o FILE.html", ("saoflow view cmhe_fte -o cmhe_fte.html",)),
    Filled("saoflow view SHEET", ("saoflow view cmhe_fte -o cmhe_fte.html",)),
    Filled("saoflow verify SHEET", ("saoflow verify umhe_fte --frames 60",)),
    Filled("saoflow fly -o OUT", ("saoflow fly --noise -o flight.csv",)),
    Filled("saoflow campaign FILE -o DIR", ("saoflow campaign few/monte_carlo.yaml -o out/monte_carlo --workers 1",)),
    Filled("saoflow compare SHEET...", (_COMPARE,)),
    Filled("saoflow build SHEET -o DIR", ("saoflow build umhe_fte -o out/c",)),
    Filled("saoflow fmu SHEET", ("saoflow fmu umhe_fte",)),
    Filled("saoflow show SHEET --stage ...", ("saoflow show airspeed.yaml --stage program",)),
    Filled("saoflow new NAME", ("saoflow new mine",)),
    Filled("saoflow explain CODE", ("saoflow explain E211",)),
    Filled("saoflow symbols NAME", ("saoflow symbols lookup",)),
    Filled("saoflow fmt FILE...", ("saoflow new second", "saoflow fmt airspeed.yaml second.yaml")),
    Filled("saoflow diff A B", ("saoflow diff airspeed.yaml second.yaml",), 1),
    Filled("saoflow COMMAND --help", ("saoflow run --help", "saoflow campaign --help")),
    Filled("saoflow run --backend c", ("saoflow run airspeed.yaml readings.csv -o compiled.csv --backend c",)),
    Filled(
        'SAOFLOW_CC="clang -O2" saoflow run --backend c ...',
        ("saoflow new mine", 'SAOFLOW_CC="clang -O2" saoflow run mine.yaml mine.csv -o mine_out.csv --backend c'),
    ),
    Filled("pip install saoflow", (_EXTRAS,), why=_ABOUT_PIP),
    Filled("pip install 'saoflow[lsp]'", (_EXTRAS,), why=_ABOUT_PIP),
    Filled("pip install 'saoflow[cluster]'", (_EXTRAS,), why=_ABOUT_PIP),
    Filled("pip install -e '.[flights]'", (f"{_PIP} -e '.[flights]'",), why=_ABOUT_PIP),
)

SHORT = (
    # The flagship, in fewer frames.
    Short("saoflow verify cmhe_fte", "saoflow verify cmhe_fte --frames 60", "10 000 frames take a minute"),
    Short("saoflow verify cmhe_fte_lean", "saoflow verify cmhe_fte_lean --frames 60", "as above"),
    Short("saoflow verify umhe_fte --frames 600", "saoflow verify umhe_fte --frames 60", "600 frames take seconds"),
    Short("saoflow fmu cmhe_fte", "saoflow fmu umhe_fte", "a smaller sheet; tests/fmi compiles the flagship"),
    Short("saoflow fmu cmhe_fte --version 2 -o two.fmu", "saoflow fmu umhe_fte --version 2 -o two.fmu", "as above"),
    Short("saoflow build cmhe_fte -o out/c", "saoflow build umhe_fte -o out/c", "a smaller sheet; tests/codegen builds the flagship"),
    Short("python -m verification.results.fig4", "python -m verification.results.fig4 --seeds 1", "three sheets, three seeds"),
    # Campaigns of thousands of flights.
    Short(
        "saoflow campaign table_iv -o out/table_iv",
        "saoflow campaign few/table_iv.yaml -o out/table_iv --workers 1",
        "270 runs of up to 700 s, whose flights JSBSim records first",
    ),
    Short(
        "saoflow campaign monte_carlo -o out/monte_carlo",
        "saoflow campaign few/monte_carlo.yaml -o out/monte_carlo --workers 1",
        "10 000 runs",
    ),
    Short(
        "saoflow campaign detection -o out/detection",
        "saoflow campaign few/detection.yaml -o out/detection --workers 1",
        "2240 runs, whose flights JSBSim records first",
    ),
    Short(
        "saoflow campaign mine.yaml -o out/mine --workers 2 --set n_detect=4",
        "sed -i 's/- cmhe_fte/- ekf_fte/; /umhe_fte/d; s/count: 4/count: 1/' mine.yaml"
        " && saoflow campaign mine.yaml -o out/mine --workers 2 --set n_detect=4",
        "the flagship compiled once more",
    ),
    Short(
        'saoflow compare "cmhe_fte[n_QP=1..4]" cmhe_fte_lean umhe_fte ekf_fte --budget 19500 -o out/compare.html',
        _COMPARE,
        "seven sheets to compile, 700 runs each",
    ),
    Short(
        "python -m verification.campaigns.documents",
        "python -m verification.campaigns.documents few/table_iv.yaml",
        "three campaigns of 270 to 10 000 runs",
    ),
    # Results on flights and on the papers' plants: minutes each.
    Short(
        "python -m verification.results.false_alarms",
        "python -m verification.results.false_alarms --flights a320_calm_350kt_5000ft --seeds 1 --seconds 20",
        "six flights, three seeds",
    ),
    Short(
        "python -m verification.results.false_alarms --all",
        "python -m verification.results.false_alarms --all --flights a320_beyond_350kt_5000ft --seeds 1 --seconds 20",
        "the whole catalogue, three seeds",
    ),
    Short(
        "python -m verification.results.fault_table -o docs/fault_table.md",
        "python -m verification.results.fault_table -o docs/fault_table.md --flights a320_calm_350kt_5000ft --seeds 1"
        " --seconds 13 --kinds non_return_to_zero",
        "576 runs",
    ),
    Short(
        "python -m verification.results.active_set_passes",
        "python -m verification.results.active_set_passes --frames 30",
        "600 windows, each solved some twenty times",
    ),
    Short(
        "python -m verification.results.reactor_passes",
        "python -m verification.results.reactor_passes --seeds 1 --steps 12",
        "three runs of 250 steps, each window solved with sixty passes",
    ),
    Short(
        "python -m verification.results.horizon_operations",
        "python -m verification.results.horizon_operations --longest 3",
        "four sheets, each elaborated at 19 horizons",
    ),
    Short(
        "python -m verification.demo.readme",
        "python -m verification.demo.readme docs/limits.md",
        "the README's numbers take minutes; another page, renewed in the same way",
    ),
    # Bits: a random sheet, and no flagship, or umhe_fte where there is no random sheet.
    Short("python -m verification.bits", 'python -m verification.bits --sheets 1 --flagship --target "gcc -O1"', _ABOUT_BITS),
    Short(
        "python -m verification.bits --quick",
        'python -m verification.bits --quick --sheets 1 --flagship --target "clang -O2"',
        _ABOUT_BITS,
    ),
    # Benchmarks, measured once.
    Short("python benchmarks/interpreter.py", "python benchmarks/interpreter.py --repeat 1 --frames 10 --flights 10 --batch-frames 2", "repetitions"),
    Short("python benchmarks/start_up.py", "python benchmarks/start_up.py --repeat 1 --only programs", "repetitions"),
    Short("python benchmarks/elaboration.py", "python benchmarks/elaboration.py --repeat 1 --sizes 300 1000", "sheets of 100 000 blocks"),
    Short("python benchmarks/campaign.py", "python benchmarks/campaign.py --flights 20 --only reference --repeat 1", "40 000 flights"),
    Short(
        "python benchmarks/calibration.py --markdown",
        "python benchmarks/calibration.py --markdown --seeds 305 --set powerpc",
        "23 sheets, three machines",
    ),
    # Set-up.
    Short("make demo", "make demo", "with .venv there already; the set-up is that of `make test`, which CI runs"),
)

ELSEWHERE = (
    Elsewhere("make test", ".ci/run", "make test", "it is what CI runs, on a fresh checkout", always=True),
    Elsewhere(
        "make docs",
        "tests/verification/documentation/test_site.py::test_the_site_is_built_and_asks_nobody",
        '"-m", "verification.documentation"',
        "the test runs the line of the Makefile, and looks at the site",
    ),
    Elsewhere("saoflow demo", "Makefile", "$(BIN)/saoflow demo", "`make demo` on the same page ends with it", "README.md"),
    Elsewhere(
        "python -m verification.demo.picture",
        "tests/verification/demo/test_demo.py::test_picture",
        "write_picture(result",
        "it flies the demo again, which takes seconds, for the picture that the test makes from its own",
    ),
    Elsewhere(
        "python -m verification.cleanliness",
        "tests/verification/cleanliness/test_cleanliness.py",
        'main(["--quick", "--random", "1"])',
        "half a minute of compilers, sanitizers and valgrind even when it is shortened",
    ),
    Elsewhere(
        "python -m verification.cleanliness --quick",
        "tests/verification/cleanliness/test_cleanliness.py",
        'main(["--quick", "--random", "1"])',
        "as above",
    ),
    Elsewhere(
        "python -m verification.bits --frames 100000 --sheets 0 --target PowerPC ARM",
        "tests/verification/bits/test_bits.py::test_the_flagship_has_the_interpreters_bits",
        'compare_flagship("cmhe_fte"',
        "seconds of cross compilers and emulators for every frame",
    ),
    Elsewhere(
        'python -m verification.bits --target "backend c"',
        "tests/verification/bits/test_bits.py::test_backend_c_has_the_interpreters_bits",
        'compare_flagship("umhe_fte"',
        "as above",
    ),
    Elsewhere(
        "python -m verification.results.lean_table",
        "tests/test_flagship_lean.py",
        "lean_table.main([",
        "the test counts the same sheets, and holds the page's table",
    ),
    Elsewhere("python -m verification.papers", "tests/verification/papers/test_document.py", "write_document(", _ABOUT_PAPERS),
    Elsewhere(
        "python -m verification.papers -o docs/papers",
        "tests/verification/papers/test_document.py",
        "write_document(",
        _ABOUT_PAPERS,
    ),
    Elsewhere(
        "python -m saoflow.authoring.catalogue",
        "tests/authoring/test_explain.py::test_the_page_is_fresh",
        "catalogue.page()",
        "it writes into the checkout; the test compares what it would write",
        always=True,
    ),
    Elsewhere(
        "python -m verification.documentation.commands --whole",
        "tests/verification/documentation/test_commands.py::test_the_command_line",
        "main([",
        "it would run itself",
        always=True,
    ),
    Elsewhere(
        "saoflow campaign FILE --dask ADDRESS",
        "tests/verification/campaigns/test_dask.py",
        "run_campaign",
        "it needs a scheduler and its workers, which the test starts",
        always=True,
    ),
)

NOT_HERE = (
    NotHere("pip install ziglang", "a compiler of 90 MB from the package index"),
)

ENDS = (
    Ends("python benchmarks/calibration.py --markdown", 1, "the page says which sheets miss the bar"),
    Ends("saoflow budget cmhe_fte --set N=5", 1, "the page says that a longer window exceeds the budget"),
)

NEEDS = (
    Needs('SAOFLOW_CC="clang -O2" saoflow run --backend c ...', "clang"),
    Needs("saoflow run --backend c", "cc"),
    Needs("make demo", "make"),
)

HELD = (
    Held("docs/diagnoses.md", "tests/authoring/test_explain.py"),
    Held("docs/new_symbol.md", "tests/verification/documentation/test_new_symbol.py"),
)

SUPPOSED = (
    Supposed("README.md", "readings.csv", "vc_1,vc_2,vc_3\n" + "250,251,256\n" * 4, "columns and values of the page"),
)
