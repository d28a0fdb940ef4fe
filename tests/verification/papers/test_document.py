"""The document of the papers' results: what is refused, what is kept, how it reads."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from verification.papers import document
from verification.papers.__main__ import main
from verification.papers.document import (
    DocumentError,
    PaperModule,
    made,
    markdown,
    modules,
    read_findings,
    write_document,
)
from verification.papers.finding import Finding, Verdict
from verification.papers.style import figure, save


def finding(
    paper: str = "003", item: str = "Fig. 3", verdict: Verdict = Verdict.HOLDS, condition: str = "", **more
) -> Finding:
    return Finding(paper, item, "a title", "a | b is large", verdict, condition, "Measured: 3.", **more)


def drawing(paper: str, item: str, calls: list[str]):
    def findings(pictures: Path, *, short: bool = False):
        calls.append(paper)
        with figure(3.0, 2.0) as drawn:
            drawn.subplots().plot([0.0, 1.0], [0.0, 1.0])
            save(drawn, pictures / f"{paper}.png")
        yield finding(paper, item, pictures=(f"{paper}.png",))

    return PaperModule(paper, f"paper_{paper}", findings)


@pytest.mark.parametrize("verdict", list(Verdict))
def test_a_condition_stands_where_the_verdict_needs_one_and_only_there(verdict: Verdict):
    needs = verdict in (Verdict.ONLY_IF, Verdict.NOT_HERE)
    assert finding(verdict=verdict, condition="the inputs are biased" if needs else "").judgement.startswith(verdict)
    with pytest.raises(ValueError, match="condition"):
        finding(verdict=verdict, condition="" if needs else "the inputs are biased")


def test_every_link_of_the_table_leads_to_its_section():
    text = markdown([finding(), finding(), finding("001", "Table I", Verdict.ONLY_IF, "N is large"), finding("004")])
    links = re.findall(r"\]\(#([\w-]+)\)", text)
    assert links == re.findall(r'<a id="([\w-]+)">', text) == ["003-fig-3", "003-fig-3-2", "001-table-i", "004-fig-3"]
    assert "| 001 | [Table I](#001-table-i) | a title: a \\| b is large | **holds only if** N is large |" in text
    assert "4 claims: 3 holds, 1 holds only if." in text


def test_one_paper_run_again_leaves_the_others(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    calls: list[str] = []
    known = [drawing("003", "Fig. 3", calls), drawing("004", "Fig. 4", calls)]
    monkeypatch.setattr(document, "modules", lambda only=(): [m for m in known if not only or m.paper in only])
    first = write_document(tmp_path)
    text = (tmp_path / "README.md").read_bytes()
    assert write_document(tmp_path, ["004"]) == first == read_findings(tmp_path)
    assert calls == ["003", "004", "004"]
    assert (tmp_path / "README.md").read_bytes() == text
    assert sorted(p.name for p in tmp_path.iterdir()) == ["003.png", "004.png", "README.md", "findings.json"]


def test_wrong_modules_and_foreign_files_are_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    for wrong in (finding("001"), finding("003", pictures=("none.png",))):
        module = PaperModule("003", "paper_003", lambda pictures, *, short, wrong=wrong: iter([wrong]))
        with pytest.raises(DocumentError):
            made([module], tmp_path)
    (tmp_path / "findings.json").write_text('[{"paper": "003"}]')
    assert main(["-o", str(tmp_path), "--only", "003"]) == 2
    assert "findings.json does not hold findings" in capsys.readouterr().err
    with pytest.raises(SystemExit):
        main(["-o", str(tmp_path / "findings.json")])
    with pytest.raises(SystemExit):
        main(["--only", "005"])


def test_a_picture_is_the_same_every_time_and_a_huge_one_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    drawn = []
    for name in ("one.png", "two.png"):
        with figure(3.0, 2.0) as made_figure:
            made_figure.subplots().plot([0.0, 1.0], [1.0, 0.0], label="x")
            save(made_figure, tmp_path / name)
        drawn.append((tmp_path / name).read_bytes())
    assert drawn[0] == drawn[1]
    monkeypatch.setattr("verification.papers.style.LARGEST", 100)
    with figure(3.0, 2.0) as made_figure, pytest.raises(ValueError, match="fewer points"):
        save(made_figure, tmp_path / "three.png")
    assert not (tmp_path / "three.png").exists()


def test_modules_are_found_by_name_in_the_order_of_the_papers():
    order = list(document.PAPERS)
    found = [module.paper for module in modules()]
    assert found == sorted(found, key=order.index)


def test_the_shipped_document_is_what_its_findings_say():
    """README.md is written from findings.json; its pictures are there, and no other."""
    folder = Path(__file__).parents[3] / "docs" / "papers"
    found = read_findings(folder)
    assert (folder / "README.md").read_text(encoding="utf-8") == markdown(found)
    pictures = [name for one in found for name in one.pictures]
    assert sorted(pictures) == sorted(path.name for path in folder.glob("*.png"))
    assert all((folder / name).stat().st_size < 150_000 for name in pictures)
