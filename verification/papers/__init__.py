"""What the papers' result sections claim, run again and judged: ``python -m verification.papers``.

Each ``paper_NNN*.py`` makes the findings of one paper (:mod:`verification.papers.finding`) and draws their pictures in one
style (:mod:`verification.papers.style`); :mod:`verification.papers.document` puts them together.
"""
