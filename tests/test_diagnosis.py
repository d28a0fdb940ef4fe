"""How a diagnosis stands on a terminal."""

from __future__ import annotations

import pytest

from saoflow.diagnosis import Diagnosis, Position


def rendered(line: str, column: int, length: int) -> list[str]:
    return Diagnosis("E202", "what", Position("f.yaml", 3, column, length), source_line=line).render().splitlines()[1:]


@pytest.mark.parametrize(
    ("line", "word", "columns"),
    [
        ("y: {add: [速度, zz]}", "zz", 16),  # two columns for each of the two
        ("y: {add: [速度, zz]}", "速度", 10),
        ("y: {add: [γ, zz]}", "zz", 13),
        ("y: {add: [e\u0301, zz]}", "zz", 13),  # an accent of its own takes none
    ],
)
def test_the_caret_stands_below_what_it_means_in_any_alphabet(line: str, word: str, columns: int) -> None:
    _, marks = rendered(line, line.index(word) + 1, len(word))
    width = 4 if word == "速度" else 2
    assert marks == " " * 3 + "| " + " " * columns + "^" * width


def test_control_characters_of_a_file_do_not_reach_the_terminal() -> None:
    shown, marks = rendered("a,\x1b[31mb\rc\td", 3, 1)
    assert shown == " 3 | a,\ufffd[31mb\ufffdc d" and marks == "   |   ^"
