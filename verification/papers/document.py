"""The document of the papers' results: found paper modules, their findings, Markdown.

A folder of it holds ``README.md``, the pictures, and ``findings.json``: the findings as data, from which the papers
that are not run again keep their part.
"""

from __future__ import annotations

import importlib
import json
import pkgutil
import re
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

import verification.papers
from saoflow.whole_file import write_whole
from verification.papers.finding import Finding, Verdict

PAPERS = {
    "003": (
        "Wan, Keviczky: Real-time nonlinear moving horizon observer with pre-estimation for aircraft sensor fault "
        "detection and estimation (International Journal of Robust and Nonlinear Control)"
    ),
    "001": (
        "Alessandri, Baglietto, Battistelli, Zavala: Advances in moving horizon estimation for nonlinear systems "
        "(IEEE Conference on Decision and Control, 2010)"
    ),
    "002": (
        "Abdollahpouri, Haring, Johansen, Takács, Rohal'-Ilkiv: Double moving horizon estimation: linearization by a "
        "nonlinear transformation"
    ),
    "004": (
        "Wan, Keviczky: Real-time fault-tolerant moving horizon air data estimation for the RECONFIGURE benchmark "
        "(IEEE Transactions on Control Systems Technology 27, 2019)"
    ),
}
"""The papers in the order of the document."""


class DocumentError(Exception):
    """The document cannot be made; the message says why."""


Progress = Callable[[str], None]
"""Called with a word on what is done now."""


@dataclass(frozen=True)
class PaperModule:
    """A module that makes findings: ``findings(pictures: Path, *, short: bool) -> Iterator[Finding]``."""

    paper: str
    name: str
    findings: Callable[..., Iterator[Finding]]


def modules(only: Sequence[str] = ()) -> list[PaperModule]:
    """The modules ``paper_NNN*.py`` with a function ``findings``, by paper, then by name; ``only``: of these papers."""
    found = []
    for info in pkgutil.iter_modules(verification.papers.__path__):
        match = re.fullmatch(r"paper_(\d{3})(_\w+)?", info.name)
        if match is None or match[1] not in PAPERS or (only and match[1] not in only):
            continue
        module = importlib.import_module(f"verification.papers.{info.name}")
        if hasattr(module, "findings"):
            found.append(PaperModule(match[1], info.name, module.findings))
    order = list(PAPERS)
    return sorted(found, key=lambda module: (order.index(module.paper), module.name))


def made(
    chosen: Sequence[PaperModule], folder: Path, *, short: bool = False, progress: Progress | None = None
) -> list[Finding]:
    """Run the modules. Raises DocumentError if a finding is another paper's or names a picture that was not drawn."""
    found = []
    for module in chosen:
        if progress is not None:
            progress(f"paper {module.paper}")
        for finding in module.findings(folder, short=short):
            if finding.paper != module.paper:
                raise DocumentError(f"{module.name} makes a finding of paper {finding.paper}")
            missing = [name for name in finding.pictures if not (folder / name).is_file()]
            if missing:
                raise DocumentError(f"{module.name}, {finding.item}: no picture {', '.join(missing)}")
            found.append(finding)
            if progress is not None:
                progress(f"paper {finding.paper}, {finding.item}: {finding.judgement}")
    return found


def write_document(
    folder: Path, only: Sequence[str] = (), *, short: bool = False, progress: Progress | None = None
) -> list[Finding]:
    """Run the papers (``only``: these) and write the folder; papers that are not run keep what ``findings.json`` says.

    Raises OSError, and DocumentError if ``findings.json`` is not what this function wrote or a module errs.
    """
    folder.mkdir(parents=True, exist_ok=True)
    read_findings(folder)  # another file is refused before the work
    new = made(modules(only), folder, short=short, progress=progress)
    kept = [finding for finding in read_findings(folder) if only and finding.paper not in only]
    order = list(PAPERS)
    findings = sorted([*kept, *new], key=lambda finding: order.index(finding.paper))
    data = json.dumps([asdict(finding) for finding in findings], indent=1, ensure_ascii=False)
    write_whole(folder / "findings.json", (data + "\n").encode("utf-8"))
    write_whole(folder / "README.md", markdown(findings).encode("utf-8"))
    return findings


def read_findings(folder: Path) -> list[Finding]:
    """What ``findings.json`` of a folder holds; nothing if there is none. Raises DocumentError for another content."""
    path = folder / "findings.json"
    if not path.is_file():
        return []
    try:
        rows = json.loads(path.read_text(encoding="utf-8"))
        return [
            Finding(**{**row, "verdict": Verdict(row["verdict"]), "pictures": tuple(row["pictures"])}) for row in rows
        ]
    except (TypeError, KeyError, ValueError) as problem:
        raise DocumentError(f"{path} does not hold findings: {problem}; remove it and run every paper") from None


INTRODUCTION = """# The papers' results, made again

Written by `python -m verification.papers -o docs/papers`; `--only 003` runs one paper again. Each claim of the papers'
result sections is run with saoflow's sheets, on our flights where the paper's data are closed, and judged by a rule in
the code (`verification/papers/paper_*.py`) from the numbers measured. Tests run the shortened form. What is printed
wrongly in the papers is in [corrections.md](../corrections.md).
"""


def markdown(findings: Iterable[Finding]) -> str:
    """The document: introduction, summary table with links, and a section for each paper."""
    rows = list(findings)
    lines = [INTRODUCTION, "| paper | item | claim | verdict |", "|---|---|---|---|"]
    anchors = _anchors(rows)
    for finding, anchor in zip(rows, anchors, strict=True):
        cells = (_cell(finding.item), _cell(f"{finding.title}: {finding.claim}"), _cell(finding.judgement))
        lines.append(
            f"| {finding.paper} | [{cells[0]}](#{anchor}) | {cells[1]} | {_marked(cells[2], finding.verdict)} |"
        )
    lines.append("")
    lines.append(_totals(rows))
    paper = ""
    for finding, anchor in zip(rows, anchors, strict=True):
        if finding.paper != paper:
            paper = finding.paper
            lines.append(f"\n## Paper {paper}\n\n{PAPERS[paper]}.")
        lines.append(_section(finding, anchor))
    return "\n".join(lines).rstrip() + "\n"


def _section(finding: Finding, anchor: str) -> str:
    pictures = "".join(f"\n\n![{finding.item}: {finding.title}]({name})" for name in finding.pictures)
    return (
        f'\n<a id="{anchor}"></a>\n\n### {finding.item}: {finding.title}\n\n*The paper:*'
        f' {finding.claim.rstrip(".")}.\n\n*Here:*'
        f" {_marked(finding.judgement, finding.verdict)}.{pictures}\n\n{finding.text.strip()}"
    )


def _totals(findings: Sequence[Finding]) -> str:
    counts = [(verdict, sum(finding.verdict is verdict for finding in findings)) for verdict in Verdict]
    return f"{len(findings)} claims: " + ", ".join(f"{count} {verdict}" for verdict, count in counts if count) + "."


def _marked(judgement: str, verdict: Verdict) -> str:
    """The verdict's own words in bold."""
    return f"**{verdict}**{judgement.removeprefix(verdict)}"


def _cell(text: str) -> str:
    return " ".join(text.split()).replace("|", "\\|").rstrip(".")


def _anchors(findings: Sequence[Finding]) -> list[str]:
    """One for each finding, "003-fig-4"; a number behind those that repeat."""
    seen: dict[str, int] = {}
    anchors = []
    for finding in findings:
        name = f"{finding.paper}-" + re.sub(r"[^a-z0-9]+", "-", finding.item.lower()).strip("-")
        seen[name] = seen.get(name, 0) + 1
        anchors.append(name if seen[name] == 1 else f"{name}-{seen[name]}")
    return anchors
