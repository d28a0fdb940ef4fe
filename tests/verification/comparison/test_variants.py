"""Variants of a sheet as text: what is understood, and what is refused with a word why."""

from __future__ import annotations

import pytest

from saoflow import DiagnosisError
from verification.comparison.variants import MOST_VARIANTS, parse_variants


def labels(*texts: str) -> list[str]:
    return [variant.label for variant in parse_variants(texts)]


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("cmhe_fte", ["cmhe_fte"]),
        ("cmhe_fte[n_QP=1..4]", [f"cmhe_fte[n_QP={i}]" for i in (1, 2, 3, 4)]),
        ("mine/lag.yaml[k=0.1|pi/8]", ["mine/lag.yaml[k=0.1]", "mine/lag.yaml[k=pi/8]"]),
        (" cmhe_fte[ n_QP = 3 , N = 2 | 4 ] ", ["cmhe_fte[n_QP=3, N=2]", "cmhe_fte[n_QP=3, N=4]"]),
        ("a[n=-1..1]", ["a[n=-1]", "a[n=0]", "a[n=1]"]),
        ("a[P=[1, 2], k=max(1, 2)]", ["a[P=[1, 2], k=max(1, 2)]"]),
        ("a[n=2|1..3]", ["a[n=2]", "a[n=1]", "a[n=3]"]),
    ],
)
def test_understood(text: str, expected: list[str]) -> None:
    assert labels(text) == expected


def test_every_one_with_every_other() -> None:
    found = parse_variants(["a[n=1..3, m=5|6]"])
    assert [v.settings for v in found] == [(("n", str(n)), ("m", str(m))) for n in (1, 2, 3) for m in (5, 6)]
    assert all(v.unlimited for v in found)


def test_the_same_variant_flies_once() -> None:
    assert labels("a", "b", "a", "a[n=1|1]", "a[n=1..2]") == ["a", "b", "a[n=1]", "a[n=2]"]


@pytest.mark.parametrize(
    ("text", "cause"),
    [
        ("[n=1]", "it names no sheet"),
        ("a[n=1", "the bracket is not closed"),
        ("a[n=1]b", "something follows the bracket"),
        ("a[]", "there is nothing in the brackets"),
        ("a[n]", "`n` is no NAME=VALUE"),
        ("a[n=]", "`n=` is no NAME=VALUE"),
        ("a[n=1,]", "`` is no NAME=VALUE"),
        ("a[1=n]", "`1=n` is no NAME=VALUE"),
        ("a[n=1, n=2]", "`n` is given twice"),
        ("a[n=1||2]", "`1||2` has an empty value"),
        ("a[n=1..x]", "`1..x` is no range of whole numbers"),
        ("a[n=0.5..2]", "`0.5..2` is no range of whole numbers"),
        ("a[n=4..1]", "`4..1` goes down"),
        ("a[n=1..1000]", f"`1..1000` has 1000 values, at most {MOST_VARIANTS} are compared"),
    ],
)
def test_refused(text: str, cause: str) -> None:
    with pytest.raises(DiagnosisError) as caught:
        parse_variants([text])
    (diagnosis,) = caught.value.diagnoses
    assert (diagnosis.code, diagnosis.message, diagnosis.cause) == ("E807", f"`{text}` is not understood", cause)


def test_all_mistakes_are_told() -> None:
    with pytest.raises(DiagnosisError) as caught:
        parse_variants(["a[n=1", "b", "c[n=4..1]"])
    assert [d.cause for d in caught.value.diagnoses] == ["the bracket is not closed", "`4..1` goes down"]


def test_too_many() -> None:
    with pytest.raises(DiagnosisError, match="81 variants are too many"):
        parse_variants(["a[i=1..9, j=1..9]"])
